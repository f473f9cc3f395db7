"""Engines do the same work for many jobs, on processes of this machine or on a Ray cluster.

An engine knows nothing about images. `base.Engine` is the interface; `local` and `ray` implement it. These modules
import neither torch nor Warp, which only the work needs.
"""
