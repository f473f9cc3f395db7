"""Engines: the same work on many jobs, on the processes of this machine or on a Ray cluster.

An engine knows nothing of images. `base.Engine` is what each of them is; `local` and `cluster` are the two there are.
These modules import neither torch nor Warp: that is left to the work.
"""
