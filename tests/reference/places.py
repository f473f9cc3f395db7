"""Places of new paths in plain NumPy float64: the blur as a sum over all pixels, the draw by one running sum."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

Real = NDArray[np.float64]


def blurred(error: Real, sigma: float, reach: int) -> Real:
    """Return ``error`` [h, w], without what is negative or not finite, blurred by a Gaussian that ends at ``reach``."""
    height, width = error.shape
    clean = np.where(np.isfinite(error) & (error > 0.0), error, 0.0)
    total, weight = np.zeros_like(clean), 0.0
    for dy, dx in product(range(-reach, reach + 1), repeat=2):
        share = np.exp(-0.5 * (dx * dx + dy * dy) / sigma**2)
        rows, columns = np.clip(np.arange(height) + dy, 0, height - 1), np.clip(np.arange(width) + dx, 0, width - 1)
        total += share * clean[rows][:, columns]
        weight += share
    return total / weight


def drawn(weights: Real, numbers: Real, block: int) -> NDArray[np.int64]:
    """Return the pixels [K] of ``weights`` [P] that the first two of ``numbers`` [K, 5] draw, first a block of them."""
    found = []
    for in_sum, in_block, *_ in numbers:
        ends = np.cumsum([part.sum() for part in np.split(weights, range(block, len(weights), block))])
        first = block * np.flatnonzero(ends > in_sum * ends[-1])[0]
        within = np.cumsum(weights[first : first + block])
        found.append(first + np.flatnonzero(within > in_block * within[-1])[0])
    return np.array(found)
