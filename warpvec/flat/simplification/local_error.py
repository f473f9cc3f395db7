"""Tell which segments an error of the picture belongs to."""

from __future__ import annotations

import numpy as np

from warpvec.arrays import Floats, Floats32, Integers, counted
from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.flat.simplification.outline_samples import cubic_points


def errors_near(control: Floats, error: Floats32) -> Floats:
    """Return the sum of ``error`` [h, w] over the pixels that each segment [R, 4, 2] passes, and those beside them.

    A pixel near several segments counts for each of them.
    """
    height, width = error.shape
    reach = np.linalg.norm(np.diff(control, axis=1), axis=-1).sum(1)
    counts = (
        np.clip(np.ceil(reach / SIMPLIFICATION.error_spacing), 1, SIMPLIFICATION.error_points_max).astype(np.int64) + 1
    )
    row = np.repeat(np.arange(len(control)), counts)
    place = counted(counts)
    t = place / (counts - 1)[row]
    points = cubic_points(control[row], t[:, None])[:, 0]
    x, y = np.floor(points.T).astype(np.int64)
    offsets = np.array([(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)])
    x, y = x[:, None] + offsets[:, 0], y[:, None] + offsets[:, 1]
    inside = (x >= 0) & (y >= 0) & (x < width) & (y < height)
    keys = np.unique(((row[:, None] * height + y) * width + x)[inside])
    owner, pixel = np.divmod(keys, height * width)
    return np.bincount(owner, error.reshape(-1)[pixel].astype(np.float64), len(control)).astype(np.float64)


def boxes_of(control: Floats, owner: Integers, count: int) -> tuple[Floats, Floats]:
    """Return the least and the greatest coordinates [count, 2] of the segments [R, 4, 2] of each ``owner`` [R]."""
    low, high = np.full((count, 2), np.inf), np.full((count, 2), -np.inf)
    np.minimum.at(low, owner, control.min(1))
    np.maximum.at(high, owner, control.max(1))
    return low, high


def errors_in_boxes(error: Floats32, low: Floats, high: Floats) -> Floats:
    """Return the sum of ``error`` [h, w] in the pixels of each box [K] and those beside it."""
    height, width = error.shape
    sums = np.pad(error.astype(np.float64).cumsum(0).cumsum(1), ((1, 0), (1, 0)))
    size = np.array([width, height])
    (left, top), (right, bottom) = (
        np.clip(each, 0, size).astype(np.int64).T for each in (np.floor(low) - 1, np.ceil(high) + 1)
    )
    return sums[bottom, right] - sums[top, right] - sums[bottom, left] + sums[top, left]
