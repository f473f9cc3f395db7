"""Layers of a picture of regions, bottom to top: which region is painted over which."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warpvec.flat.junctions import evidence_above
from warpvec.flat.regions import Regions

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Mask = NDArray[np.bool_]

PAINT_APART = 2.5 / 255
"""Largest difference of a channel of two paints that count as equal."""


AREA_EVIDENCE, SURELY = 0.25, 100.0
"""Evidence that the smaller of two regions lies above, beside that of junctions, at most 1; and that a region lies
above one that surrounds it."""

MOVES_MAX = 8
"""Rounds in which each layer may move to where it agrees best with the others."""


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
    shown = np.nonzero(~is_outside(regions))[0]
    area, surrounds = filled_areas(regions.label, len(regions))
    above = evidence_above(regions, shown)
    above += AREA_EVIDENCE * np.sign(area[None, :] - area[:, None])
    above += SURELY * (surrounds.T.astype(float) - surrounds)
    order = best_order(above, sorted(shown, key=lambda index: (-area[index], index)))
    hides = regions.opacity >= 1.0
    return [
        Layer((region,), frozenset(upper for upper in order[place + 1 :] if hides[upper]))
        for place, region in enumerate(order)
    ]


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


def best_order(above: Floats, start: Sequence[int]) -> list[int]:
    """Return the indices of ``start`` in the order, lowest first, that agrees best with ``above`` [K, K].

    Entry [a, b] says how clearly a lies above b. Single entries move while the sum over all pairs grows.
    """
    order = list(start)
    for _ in range(MOVES_MAX):
        before = list(order)
        for entry in before:
            rest = [other for other in order if other != entry]
            gain = above[entry, rest] - above[rest, entry]
            place = int(np.concatenate([[0.0], np.cumsum(gain)]).round(9).argmax())
            current = order.index(entry)
            values = np.concatenate([[0.0], np.cumsum(gain)])
            if values[place] > values[current] + 1e-9:
                order = [*rest[:place], entry, *rest[place:]]
        if order == before:
            break
    return order


def filled_areas(label: NDArray[np.int32], count: int) -> tuple[Integers, Mask]:
    """Return the area in pixels of each of ``count`` regions with what it surrounds [K], and what that is [K, K]."""
    from scipy import ndimage

    area, surrounds = np.zeros(count, np.int64), np.zeros((count, count), bool)
    for region, box in enumerate(ndimage.find_objects(label + 1, count)):
        if box is not None:
            filled = ndimage.binary_fill_holes(label[box] == region)
            area[region] = filled.sum()
            surrounds[region, np.unique(label[box][filled])] = True
    np.fill_diagonal(surrounds, False)
    return area, surrounds
