"""Tell which segments an error of the picture belongs to."""

from __future__ import annotations

import numpy as np

from warpvec.arrays import Floats, Floats32, Integers
from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.polish.machine import machine_of_thread, on_host, vectors_on_host


def errors_near(control: Floats, error: Floats32) -> Floats:
    """Return the sum of ``error`` [h, w] over the pixels that each segment [R, 4, 2] passes, and those beside them.

    A pixel near several segments counts for each of them.
    """
    height, width = error.shape
    sums, seen = np.zeros(len(control)), np.full(height * width, -1, np.int32)
    bounds = [SIMPLIFICATION.error_spacing, int(SIMPLIFICATION.error_points_max)]
    curves = vectors_on_host(control)
    arrays = [curves, on_host(np.ascontiguousarray(error, np.float32)), on_host(seen), on_host(sums)]
    machine_of_thread().run("add_near_errors", [len(control), height, width, *bounds, *arrays])
    return sums


def boxes_of(control: Floats, owner: Integers, count: int) -> tuple[Floats, Floats]:
    """Return the least and the greatest coordinates [count, 2] of the segments [R, 4, 2] of each ``owner`` [R]."""
    low, high = np.full((count, 2), np.inf), np.full((count, 2), -np.inf)
    np.minimum.at(low, owner, control.min(1))
    np.maximum.at(high, owner, control.max(1))
    return low, high


def errors_in_boxes(error: Floats32, low: Floats, high: Floats) -> Floats:
    """Return the sum of ``error`` [h, w] in the pixels of each box [K] and those beside it."""
    return sums_in_boxes(summed(error), low, high)


def summed(error: Floats32) -> Floats:
    """Return the sum of ``error`` [h, w] above and to the left of each corner of a pixel [h + 1, w + 1]."""
    sums = np.zeros((error.shape[0] + 1, error.shape[1] + 1))
    inner = sums[1:, 1:]
    np.cumsum(error, 0, np.float64, inner)
    np.cumsum(inner, 1, out=inner)
    return sums


def sums_in_boxes(sums: Floats, low: Floats, high: Floats) -> Floats:
    """Return what `errors_in_boxes` does of an error that is `summed` [h + 1, w + 1]."""
    height, width = sums.shape[0] - 1, sums.shape[1] - 1
    size = np.array([width, height])
    (left, top), (right, bottom) = (
        np.clip(each, 0, size).astype(np.int64).T for each in (np.floor(low) - 1, np.ceil(high) + 1)
    )
    return sums[bottom, right] - sums[top, right] - sums[bottom, left] + sums[top, left]
