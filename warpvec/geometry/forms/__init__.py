"""The forms that a path can have: one file each, and `warpvec.geometry.forms.registry`."""
