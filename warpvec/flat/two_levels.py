"""Whether a picture has two levels only, as faxes, scans in black and white, and thresholded drawings have."""

from __future__ import annotations

from warpvec.arrays import Floats, Mask
from warpvec.flat.constants.mono import MONO


def has_two_levels(coverage: Floats) -> bool:
    """Return whether almost no pixel along the edges of ``coverage`` [h, w] in [0, 1] is partly covered."""
    between = int(((coverage > MONO.between_levels) & (coverage < 1 - MONO.between_levels)).sum())
    return between < MONO.two_level_share * edge_count(coverage > 0.5)


def edge_count(ink: Mask) -> int:
    """Return how many sides of pixels part ``ink`` from paper [h, w]."""
    return int((ink[:, 1:] != ink[:, :-1]).sum() + (ink[1:] != ink[:-1]).sum())
