"""The renderer's and the optimizer's kernels, one stage per file; see ``kernels/README.md``."""
