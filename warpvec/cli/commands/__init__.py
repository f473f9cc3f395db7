"""The commands of ``warpvec``, a file each; what they share stands in ``inputs.py`` and ``report.py``.

These modules import neither torch nor Warp: that is done inside the commands, so that ``--help`` is quick.
"""
