"""Connected areas of one label: by pixel sides, and lines by corners."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec.arrays import Floats32, Integers32
from warpvec.flat.connected_parts import connected_parts
from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.regions.assignment import Assignment
from warpvec.flat.regions.region_growing import linked_areas


def areas_of(assignment: Assignment) -> Integers32:
    """Return the connected areas [h, w] of one label: by pixel sides, and thin ones by corners."""
    label = assignment.label
    right, below = label[:, 1:] == label[:, :-1], label[1:] == label[:-1]
    areas = linked_areas(np.ones(label.shape, bool), right, below)
    pairs = np.concatenate([_corner_links(assignment, areas, is_mirrored) for is_mirrored in (False, True)])
    return connected_parts(pairs[:, 0], pairs[:, 1], int(areas.max()) + 1).astype(np.int32)[areas]


def _corner_links(assignment: Assignment, areas: Integers32, is_mirrored: bool) -> Integers32:
    """Return the pairs of areas [P, 2] that a line of one label joins at the corner of two pixels.

    A line passes a corner if its label has enough of the four pixels around. Where the other label could pass too,
    the smaller area does: it is the line, and the larger one is joined elsewhere.
    """
    label, other, share, area = (
        values[:, ::-1] if is_mirrored else values
        for values in (assignment.label, assignment.other, assignment.share, areas)
    )
    first, last, aside, below = _corners(label)
    where = np.nonzero((first == last) & (first != aside) & (first != below))
    name, aside, below = first[where], aside[where], below[where]
    shares, others = ([corner[where] for corner in _corners(values)] for values in (share, other))
    present = shares[0] + shares[1]
    for beyond, part in zip(others[2:], shares[2:], strict=True):
        present = present + np.where(beyond == name, 1 - part, 0)
    start, end, *sides = (corner[where] for corner in _corners(area))
    size = np.bincount(areas.ravel())
    yields = (aside == below) & (np.minimum(*(size[side] for side in sides)) < np.minimum(size[start], size[end]))
    is_mixed = np.minimum.reduce(shares) < 1
    chosen = (start != end) & is_mixed & (present >= 4 * REGIONS.corner_share) & ~yields
    return np.unique(np.stack([start[chosen], end[chosen]], 1), axis=0)


def _corners(values: NDArray[Any]) -> tuple[NDArray[Any], ...]:
    """Return the pixels at the upper left, lower right, upper right and lower left of all corners [h - 1, w - 1]."""
    return values[:-1, :-1], values[1:, 1:], values[:-1, 1:], values[1:, :-1]


def most_contact(areas: Integers32, label: Integers32) -> Floats32:
    """Return for each area the largest part of its border that one label has on the other side."""
    left, right, upper, lower = np.s_[:, :-1], np.s_[:, 1:], np.s_[:-1], np.s_[1:]
    area, own = (np.concatenate([a[side].ravel() for side in (left, right, upper, lower)]) for a in (areas, label))
    beyond = np.concatenate([label[side].ravel() for side in (right, left, lower, upper)])
    crossing = own != beyond
    width = int(label.max()) + 1
    pair, count = np.unique(area[crossing].astype(np.int64) * width + beyond[crossing], return_counts=True)
    most, total = np.zeros(areas.max() + 1), np.zeros(areas.max() + 1)
    np.maximum.at(most, pair // width, count)
    np.add.at(total, pair // width, count)
    return (most / np.maximum(total, 1)).astype(np.float32)
