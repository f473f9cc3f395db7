"""Join regions of a picture that one ramp shows.

Noise breaks a gradient into flat areas, whose borders are as ragged as the noise, and a steep gradient is broken into
flat bands. One ramp shows two such areas better than a colour for each. It shows two areas of a designer worse: there
the colour changes at once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpvec.arrays import Integers
from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.regions.color_moments import ColorMoments
from warpvec.watch.watch import UNWATCHED, Watch

Pair = tuple[int, int]
"""Two regions, the smaller number first."""


@dataclass(frozen=True, eq=False)
class Shown:
    """How well pixels are shown by the paints of their regions.

    Attributes:
        moments: sums over these pixels.
        rest: sum of squares that the paints leave.
        is_flat: whether the paints are one colour each.
    """

    moments: ColorMoments
    rest: float
    is_flat: bool = True

    def with_ramp(self, *others: Shown) -> Shown:
        """Return these pixels and those of ``others`` with one ramp."""
        moments = self.moments
        for other in others:
            moments = moments.joined(other.moments)
        return Shown(moments, moments.ramp().rest, is_flat=False)


def join_regions(regions: dict[int, Shown], seams: dict[Pair, Shown], count: int, watch: Watch = UNWATCHED) -> Integers:
    """Return for each of ``count`` regions the one that it becomes.

    Again and again, those two join that gain most. The larger one gives its name.

    Args:
        regions: the pixels inside those that may be joined.
        seams: pixels at the border of two of these.
        count: number of all regions.
        watch: the watch over the run. When it is over, no more are joined.
    """
    union, regions, seams = np.arange(count), dict(regions), dict(seams)
    gains: dict[Pair, float] = {}
    while not watch.is_over():
        for pair, seam in seams.items():
            if pair not in gains:
                gains[pair] = _gain(regions[pair[0]], regions[pair[1]], seam)
        best = max(gains, key=lambda pair: gains[pair], default=None)
        if best is None or gains[best] <= 0.0:
            break
        kept, gone = sorted(best, key=lambda name: (-regions[name].moments.count, name))
        regions[kept] = regions[kept].with_ramp(regions.pop(gone), seams.pop(best))
        union[union == gone] = kept
        gains = {pair: gain for pair, gain in gains.items() if not set(pair) & set(best)}
        seams = _with_one_name(seams, kept, gone)
    return union


def _gain(one: Shown, two: Shown, seam: Shown) -> float:
    """Return how many squares a ramp over two regions leaves less than their paints; below 0 if it leaves more."""
    joint = one.with_ramp(two, seam)
    if joint.moments.count < REGIONS.joint_area_min:
        return -np.inf
    slack = 0.0 if one.is_flat and two.is_flat else REGIONS.joint_slack * min(one.rest, two.rest)
    return one.rest + two.rest + seam.rest + slack - joint.rest


def _with_one_name(seams: dict[Pair, Shown], kept: int, gone: int) -> dict[Pair, Shown]:
    """Return ``seams`` with the region ``kept`` in place of ``gone``."""
    result: dict[Pair, Shown] = {}
    for pair, seam in seams.items():
        one, two = sorted(kept if name == gone else name for name in pair)
        known = result.get((one, two))
        if known is not None:
            seam = Shown(known.moments.joined(seam.moments), known.rest + seam.rest)
        result[one, two] = seam
    return result
