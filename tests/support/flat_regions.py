"""Regions of drawn shapes, and their coverage of pixels, for tests of flat art."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from warpvec.flat.regions.paints import Paints
from warpvec.flat.regions.regions import Regions

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Shape = Callable[[Floats, Floats], Mask]

_FINE = 16


def coverage(shape: Shape, width: int, height: int) -> Floats:
    """Return how much of each pixel [height, width] a shape covers, which says what points are inside by x and y."""
    return _mean_of_pixels(shape(*_fine_grid(width, height)))


def _fine_grid(width: int, height: int) -> tuple[Floats, Floats]:
    y, x = (np.indices((height * _FINE, width * _FINE)) + 0.5) / _FINE
    return x, y


def _mean_of_pixels(values: Mask) -> Floats:
    height, width = (side // _FINE for side in values.shape)
    mean: Floats = values.reshape(height, _FINE, width, _FINE).mean((1, 3))
    return mean


def disc(x: float, y: float, radius: float) -> Shape:
    return lambda px, py: np.hypot(px - x, py - y) <= radius


def box(left: float, top: float, right: float, bottom: float) -> Shape:
    return lambda px, py: (px >= left) & (px <= right) & (py >= top) & (py <= bottom)


def regions_of(
    shapes: list[tuple[Shape, tuple[float, float, float, float]]],
    width: int = 96,
    height: int = 96,
    canvas: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0),
) -> Regions:
    """Return the regions of ``shapes`` painted in order in red, green, blue and opacity: region 0 is the canvas.

    Each shape has a region of its own, also what it shows in several parts.
    """
    grid = _fine_grid(width, height)
    top = np.zeros(grid[0].shape, np.int64)
    for index, (shape, _) in enumerate(shapes):
        top[shape(*grid)] = index + 1
    seen = np.stack([_mean_of_pixels(top == index) for index in range(len(shapes) + 1)])
    order = np.argsort(-seen, 0, kind="stable")
    first, second = order[0], order[min(1, len(shapes))]
    most, next_most = (np.take_along_axis(seen, index[None], 0)[0] for index in (first, second))
    is_pure = (next_most < 1e-9) | (first == second)
    second = np.where(is_pure, first, second)
    share = np.where(is_pure, 1.0, most / (most + next_most))
    paints = np.array([canvas, *(paint for _, paint in shapes)], np.float32)
    kind, geometry = np.zeros(len(paints), np.int32), np.zeros((len(paints), 4), np.float32)
    labels = (first.astype(np.int32), second.astype(np.int32))
    values = Paints(paints[:, :3], paints[:, 3], kind, geometry, paints[:, :3])
    return Regions(*labels, share.astype(np.float32), values, 0)


def split_regions(regions: Regions) -> Regions:
    """Return ``regions`` with a region for each connected part, in order of the first pixel, the canvas first."""
    from scipy import ndimage

    label, rows = np.zeros_like(regions.label), []
    for region in range(len(regions)):
        parts, count = ndimage.label(regions.label == region)
        label = np.where(parts > 0, parts + len(rows) - 1, label)
        rows += [region] * count
    old = np.array(rows)
    # The rest of a mixed pixel belongs to the closest part of its paint.
    other = label.copy()
    for region in range(len(regions)):
        _, nearest = ndimage.distance_transform_edt(regions.label != region, return_indices=True)
        mixed = (regions.other == region) & (regions.label != region)
        other[mixed] = label[tuple(nearest)][mixed]
    labels = (label.astype(np.int32), other.astype(np.int32))
    return Regions(*labels, regions.share, regions.paints.select(old), 0)
