"""The commands of ``warpvec``, a file each. What they share is in ``warpvec/cli``.

These modules import neither Torch nor Warp; the commands do when they run, so that ``--help`` is quick.
"""
