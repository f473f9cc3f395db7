"""Regions of one paint that are one shape, interrupted by something above it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from warpvec.flat.junctions import Junctions
from warpvec.flat.regions import Regions

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Mask = NDArray[np.bool_]

PAINT_APART = 2.5 / 255
"""Largest difference of a channel of two paints that count as equal."""

FACING = np.cos(np.radians(25.0))
"""Cosine of the largest angle between an outline, where it goes beneath another shape, and the way to where it comes
out again. A circle of which a sixth is hidden goes on at 30 degrees, half of it on either side."""

STRAIGHT = np.cos(np.radians(12.0))
"""The same where an outline goes on so straight that one is enough. Else two are needed: a band has two sides."""

ENDS_APART = 4.0
"""Pixels between two ends of one outline that count as two."""

SAMPLES = 48
"""Points of the way from end to end that must be hidden."""


def same_paint(regions: Regions, first: int, second: int) -> bool:
    """Return whether two regions have the same flat paint, within ``PAINT_APART``."""
    if first == second:
        return True
    if regions.kind[first] or regions.kind[second]:
        return False
    apart = np.abs(regions.color[first] - regions.color[second]).max()
    return bool(max(apart, abs(regions.opacity[first] - regions.opacity[second])) <= PAINT_APART)


def interrupted_pairs(regions: Regions, junctions: Junctions, order: list[int]) -> Iterator[tuple[int, int]]:
    """Yield pairs of regions of one paint whose outlines go on from one to the other beneath what is painted later.

    Args:
        regions: regions of a picture.
        junctions: junctions of all regions in ``order``.
        order: the regions, the lowest first.
    """
    place = np.full(len(regions) + 1, -1)
    place[order] = np.arange(len(order))
    hides = np.append(regions.opacity >= 1.0, False)
    # The last entry stands for what lies beyond the picture.
    goes_under = hides[junctions.after] & (place[junctions.after] > place[junctions.region])
    comes_out = hides[junctions.before] & (place[junctions.before] > place[junctions.region])
    touched = set(junctions.region[goes_under | comes_out].tolist())
    candidates = [region for region in order if region in touched]  # most letters of a text touch nothing above them
    for index, first in enumerate(candidates):
        for second in candidates[index + 1 :]:
            if not same_paint(regions, first, second):
                continue
            above = hides[:-1] & (place[:-1] > place[first]) & (np.arange(len(regions)) != second)
            strength = 0
            for a, b in ((first, second), (second, first)):
                leaving = np.nonzero(goes_under & (junctions.region == a))[0]
                arriving = np.nonzero(comes_out & (junctions.region == b))[0]
                strength += _facing(regions, junctions, leaving, arriving, above)
            if strength >= 2:
                yield first, second


def _facing(regions: Regions, junctions: Junctions, leaving: Integers, arriving: Integers, above: Mask) -> int:
    """Return how clearly outlines go on from junctions ``leaving`` to those ``arriving``, beneath regions ``above``.

    Each that goes on straight counts 2, each other one that goes on 1.
    """
    if not len(leaving) or not len(arriving):
        return 0
    way = junctions.point[arriving] - junctions.point[leaving][:, None]
    length = np.linalg.norm(way, axis=-1)
    unit = way / np.maximum(length, 1e-9)[..., None]
    goes_on = -(junctions.back[leaving][:, None] * unit).sum(-1)
    comes_in = (junctions.forth[arriving] * unit).sum(-1)
    straight = np.minimum(goes_on, comes_in)
    faces = (straight > FACING) & (length > ENDS_APART)
    rows, columns = np.nonzero(faces)
    share = np.linspace(0.1, 0.9, SAMPLES)[:, None]
    start, end = junctions.point[leaving[rows]], junctions.point[arriving[columns]]
    x, y = np.floor(start[:, None] * (1.0 - share) + end[:, None] * share).astype(np.int64).reshape(-1, 2).T
    height, width = regions.label.shape
    label = regions.label[np.clip(y, 0, height - 1), np.clip(x, 0, width - 1)]
    is_hidden = above[label].reshape(-1, SAMPLES).mean(1) > 0.9
    found = np.zeros(len(leaving), np.int64)
    np.maximum.at(found, rows[is_hidden], np.where(straight[rows, columns][is_hidden] > STRAIGHT, 2, 1))
    return int(found.sum())
