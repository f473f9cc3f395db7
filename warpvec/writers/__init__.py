"""The kinds of files that a drawing can be saved as: one file each, and `warpvec.writers.registry`."""
