"""Long level and upright runs of outlines between pixels, which are straight on purpose: no curve may replace them."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from warpvec.arrays import Floats, Integers, Mask
from warpvec.flat.constants.curves import CURVES
from warpvec.flat.curves.closed_runs import closed_runs
from warpvec.flat.curves.outline_nodes import Samples


def straight_samples(samples: Samples, length_min: Floats) -> Mask:
    """Return which samples [M] lie on a level or upright run of at least ``length_min`` pixels [L] of their loop.

    A corner is at one of its ends at least: the top of a large circle is a long run too, but steps follow on both
    sides. At neither end does the outline go on along it: at the cut end of a slanting line, the run between the
    corner and the next step may be long.
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
        for first, last in closed_runs(is_level):
            if last - first >= count and _is_meant(xy, first, last, axis, look):
                found[np.arange(first, last) % len(xy)] = True
    return found


def _is_meant(xy: Floats, first: int, last: int, axis: int, look: int) -> bool:
    """Return whether the run of a loop [n, 2] from ``first`` to ``last``, level in ``axis``, is straight on purpose."""

    def away(reach: int) -> Floats:
        """Return how far the loop is from both ends of the run, ``reach`` samples beyond them [2, 2]."""
        return xy[[(first - reach) % len(xy), (last + reach) % len(xy)]] - xy[[first % len(xy), last % len(xy)]]

    # The next step of a slanting line is as far off as this one was long: half of that shows that it goes on.
    near, far = away(look), away((last - first) // 2)
    along = xy[last % len(xy), 1 - axis] - xy[first % len(xy), 1 - axis]
    has_corner = (np.abs(near[:, axis]) > np.abs(near[:, 1 - axis])).any()
    goes_on = (np.sign(along) * np.array([-1.0, 1.0]) * far[:, 1 - axis] > np.abs(far[:, axis])).any()
    return bool(has_corner and not goes_on)
