"""Layers of a picture of regions, bottom to top: which region is painted over which."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warpvec.flat.regions import Regions

Integers = NDArray[np.int64]
Mask = NDArray[np.bool_]

PAINT_APART = 2.5 / 255
"""Largest difference of a channel of two paints that count as equal."""


@dataclass(frozen=True)
class Layer:
    """One shape of a drawing.

    Attributes:
        members: regions that show its paint.
        above: regions that are painted later, beneath which it may go on.
    """

    members: tuple[int, ...]
    above: frozenset[int]


def stack(regions: Regions) -> list[Layer]:
    """Return the layers of ``regions``, the lowest first.

    A region lies beneath those that it surrounds. Of neighbours, the one with the larger area, its holes filled, lies
    beneath. Regions that are transparent, or have the paint of the canvas, are holes through all layers.
    """
    shown = [index for index in range(len(regions)) if not is_outside(regions)[index]]
    area = filled_areas(regions.label, len(regions))
    order = sorted(shown, key=lambda index: (-area[index], index))
    return [Layer((region,), frozenset(order[place + 1 :])) for place, region in enumerate(order)]


def is_outside(regions: Regions) -> Mask:
    """Return which regions [K] (bool) no layer shows: the canvas, those of its paint, and transparent ones."""
    outside = regions.opacity <= 0.0
    if regions.canvas is not None and not outside[regions.canvas]:
        outside = outside | [same_paint(regions, index, regions.canvas) for index in range(len(regions))]
    return outside


def same_paint(regions: Regions, first: int, second: int) -> bool:
    """Return whether two regions have the same paint, within ``PAINT_APART``."""
    if first == second:
        return True
    if regions.kind[first] or regions.kind[second]:
        return False
    apart = np.abs(regions.color[first] - regions.color[second]).max()
    return bool(max(apart, abs(regions.opacity[first] - regions.opacity[second])) <= PAINT_APART)


def filled_areas(label: NDArray[np.int32], count: int) -> Integers:
    """Return the area in pixels of each of ``count`` regions [K] with what it surrounds."""
    from scipy import ndimage  # type: ignore[import-untyped]

    boxes = ndimage.find_objects(label + 1, count)
    return np.array(
        [0 if box is None else ndimage.binary_fill_holes(label[box] == k).sum() for k, box in enumerate(boxes)],
        np.int64,
    )
