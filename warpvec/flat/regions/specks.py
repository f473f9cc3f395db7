"""Specks: areas so small that they go, unless they stand out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpvec.arrays import Floats, Floats32, Integers32, Mask
from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.regions.assignment import Assignment
from warpvec.flat.regions.label_areas import areas_of
from warpvec.flat.regions.paints import Paints


@dataclass(frozen=True)
class SpeckLimits:
    """Areas in pixels below which areas are specks.

    Attributes:
        area: limit of areas that look like what lies around them.
        clear_area: limit of areas that stand out.
    """

    area: float
    clear_area: float


def specks_of(assignment: Assignment, paints: Paints, metric: Floats32, limits: SpeckLimits) -> Mask:
    """Return the pixels [h, w] in connected areas of one label that are specks; ``metric`` [4, 4] compares colours."""
    areas = areas_of(assignment)
    size = np.bincount(areas.ravel())
    is_speck = size < limits.area
    is_small = is_speck & (size >= limits.clear_area)
    if is_small.any():
        is_speck &= ~(is_small & (_contrasts(areas, is_small, assignment, paints, metric) >= REGIONS.clear_contrast))
    return is_speck[areas]


def _contrasts(areas: Integers32, is_asked: Mask, assignment: Assignment, paints: Paints, metric: Floats32) -> Floats:
    """Return the least difference of each area from what touches it; infinity for areas not asked for."""
    least = np.full(len(is_asked), np.inf)
    label = assignment.label
    rows, columns = np.nonzero(is_asked[areas])
    x, y = ((place + 0.5).astype(np.float32) for place in (columns, rows))
    own = paints.at(label[rows, columns], x, y) @ metric
    for down, right in ((-1, 0), (1, 0), (0, -1), (0, 1)):
        row, column = np.clip(rows + down, 0, label.shape[0] - 1), np.clip(columns + right, 0, label.shape[1] - 1)
        difference = np.abs(own - paints.at(label[row, column], x, y) @ metric).max(-1)
        is_beyond = areas[row, column] != areas[rows, columns]
        np.minimum.at(least, areas[rows, columns][is_beyond], difference[is_beyond])
    return least
