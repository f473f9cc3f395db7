"""Find the places of the stops of a ramp: the bends of the colours along it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec.flat.constants.regions import REGIONS

Floats = NDArray[np.floating[Any]]


def stop_places(at: Floats, means: Floats, count: Floats) -> list[Floats]:
    """Return the places of 2, 3, ... stops, ascending, of colours ``means`` [B, D] of ``count`` pixels at ``at`` [B].

    Those of each number divide the places into parts that straight lines show best, each part by itself. That takes
    the time of a few least squares: sums over all parts follow from sums up to each place.
    """
    costs, size = _line_costs(at, means, count), len(at)
    most = min(REGIONS.knots_max, size)
    least, before = [costs[0]], []
    for _ in range(most - 2):
        through = least[-1][:, None] + costs
        through[np.tril_indices(size)] = np.inf
        before.append(through.argmin(0))
        least.append(through.min(0))
    found = []
    for parts in range(1, most):
        places = [size - 1]
        for steps in reversed(before[: parts - 1]):
            places.append(int(steps[places[-1]]))
        found.append(at[np.unique([0, *places])])
    return found


def _line_costs(at: Floats, means: Floats, count: Floats) -> Floats:
    """Return the squared error [B, B] that the best line leaves of the places from i to j, both included."""
    x = at - at.mean()
    values = np.column_stack([np.ones_like(x), x, x * x, (means**2).sum(1), means, means * x[:, None]])
    sums = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(count[:, None] * values, 0)])
    parts = sums[None, 1:] - sums[:-1, None]
    w, wx, wxx, wyy = np.moveaxis(parts[..., :4], -1, 0)
    wy, wxy = np.split(parts[..., 4:], 2, -1)
    w = np.maximum(w, 1e-12)
    spread = np.maximum(wxx - wx * wx / w, 1e-12)
    slope = wxy - wy * (wx / w)[..., None]
    cost = wyy - (wy**2).sum(-1) / w - (slope**2).sum(-1) / spread
    return np.where(np.tri(len(x), k=-1, dtype=bool), np.inf, np.maximum(cost, 0.0))
