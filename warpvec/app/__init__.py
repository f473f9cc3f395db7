"""The server and the page of ``warpvec app``: drop a picture, watch it being drawn, edit it, save it."""
