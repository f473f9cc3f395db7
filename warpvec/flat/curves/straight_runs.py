"""Long level and upright runs of outlines between pixels, which are straight on purpose: no curve may replace them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from warpvec.arrays import Floats, Integers, Mask
from warpvec.flat.constants.curves import CURVES
from warpvec.flat.curves.outline_nodes import Samples


def straight_samples(samples: Samples, length_min: Floats) -> Mask:
    """Return which samples [M] lie on a level or upright run of at least ``length_min`` pixels [L] of their loop.

    A corner is at one of its ends at least: the top of a large circle is a long run too, but steps follow on both
    sides.
    """
    found = np.zeros(len(samples.xy), bool)
    for loop, (start, stop) in enumerate(pairwise(samples.first)):
        xy, step = samples.xy[start:stop], float(samples.step[loop])
        count = int(np.ceil(length_min[loop] / step)) if np.isfinite(length_min[loop]) else len(xy)
        if count < len(xy):
            found[start:stop] = _runs(xy, count, max(1, round(CURVES.run_look / step)))
    return found


def straight_counts(is_straight: Mask, samples: Samples, loop: Integers, start: Integers, reach: Integers) -> Integers:
    """Return how many samples are straight [B] among the ``reach`` ones [B] from the sample ``start`` [B] of a loop."""
    total = np.concatenate([[0], np.cumsum(is_straight)])
    first, last = samples.first[loop], samples.first[loop + 1]
    begin, end = first + start, first + start + reach
    beyond = np.maximum(end - last, 0)
    return np.asarray(total[np.minimum(end, last)] - total[begin] + total[first + beyond] - total[first])


def _runs(xy: Floats, count: int, look: int) -> Mask:
    """Return which samples [n] of a loop are of a run of at least ``count``, with a corner at an end.

    Args:
        xy: even samples [n, 2].
        count: samples of the shortest run.
        look: samples beyond an end that tell whether a corner is there.
    """
    found = np.zeros(len(xy), bool)
    steps = np.roll(xy, -1, 0) - xy
    for axis in (0, 1):
        is_level = np.abs(steps[:, axis]) < CURVES.run_error
        if is_level.all() or not is_level.any():
            continue
        shift = int(np.flatnonzero(~is_level)[0])
        change = np.diff(np.concatenate([[0], np.roll(is_level, -shift).astype(np.int64), [0]]))
        for first, last in zip(np.flatnonzero(change > 0), np.flatnonzero(change < 0), strict=True):
            ends = [(first, first - look), (last, last + look)]
            aways = [xy[(far + shift) % len(xy)] - xy[(near + shift) % len(xy)] for near, far in ends]
            is_corner = any(abs(away[axis]) > abs(away[1 - axis]) for away in aways)
            if last - first >= count and is_corner:
                found[(np.arange(first, last) + shift) % len(xy)] = True
    return found
