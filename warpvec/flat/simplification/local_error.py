"""Tell which segments an error of the picture belongs to."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from warpvec.flat.simplification.outline_samples import Floats, cubic_points

SPACING = 0.8
"""Distance in pixels of the points along a segment around which its pixels are."""

POINTS_MAX = 4096
"""Most points along one segment: it may reach far outside of the picture."""


def errors_near(control: Floats, error: NDArray[np.float32]) -> Floats:
    """Return the sum of ``error`` [h, w] over the pixels that each segment [R, 4, 2] passes, and those beside them.

    A pixel near several segments counts for each of them.
    """
    height, width = error.shape
    reach = np.linalg.norm(np.diff(control, axis=1), axis=-1).sum(1)
    counts = np.clip(np.ceil(reach / SPACING), 1, POINTS_MAX).astype(np.int64) + 1
    row = np.repeat(np.arange(len(control)), counts)
    place = np.arange(len(row)) - np.repeat(np.cumsum(counts) - counts, counts)
    t = place / (counts - 1)[row]
    points = cubic_points(control[row], t[:, None])[:, 0]
    x, y = np.floor(points.T).astype(np.int64)
    offsets = np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)])
    x, y = x[:, None] + offsets[:, 0], y[:, None] + offsets[:, 1]
    inside = (x >= 0) & (y >= 0) & (x < width) & (y < height)
    keys = np.unique(((row[:, None] * height + y) * width + x)[inside])
    owner, pixel = np.divmod(keys, height * width)
    return np.bincount(owner, error.reshape(-1)[pixel].astype(np.float64), len(control)).astype(np.float64)
