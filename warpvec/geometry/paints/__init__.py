"""The kinds of gradients that a path can have: one file each, and `warpvec.geometry.paints.registry`."""
