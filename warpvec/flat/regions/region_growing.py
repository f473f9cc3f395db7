"""Connected areas of pure pixels: those that no edge touches."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats, Floats32, Integers32, Mask, Places
from warpvec.flat.connected_parts import connected_parts
from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.regions.paints import Paints
from warpvec.image.spread import largest_channel

NONE = -1
"""Label of a pixel that belongs to no region yet."""

SIDES = ((-1, 0), (0, -1), (0, 1), (1, 0))
"""Steps to the four neighbours of a pixel, in rows and columns."""


def grow_seeds(picture: Floats32, step: float, width: int, with_ramps: bool = False) -> Integers32:
    """Return connected areas of pure pixels [h, w], numbered from 0, and ``NONE`` elsewhere.

    A pixel is pure if it lies in a square of ``width`` pixels in which no neighbours differ by more than ``step``. The
    pixels of an edge are alike along the edge, but not across it. Squares of steeper ramps count ``with_ramps``.
    """
    differences = [np.diff(picture, axis=axis) for axis in (1, 0)]
    right, below = (largest_channel(np.abs(difference)) <= step for difference in differences)
    pure = _pure(right, below, width)
    if with_ramps:
        right |= _is_steady(differences[0], 1)
        below |= _is_steady(differences[1], 0)
        pure |= _pure(right, below, REGIONS.steep_ramp_width)
    return linked_areas(pure, right, below)


def _is_steady(difference: Floats32, axis: int) -> Mask:
    """Return where differences of neighbours along ``axis`` are as those before and behind: on a ramp, not an edge."""
    if difference.size == 0:
        return np.zeros(difference.shape[:2], bool)
    change = largest_channel(np.abs(np.diff(difference, axis=axis))) <= REGIONS.steep_ramp_bend
    ends = [(0, 0), (0, 0)]
    ends[axis] = (1, 1)
    padded = np.pad(change, ends, constant_values=True)
    before, behind = (np.take(padded, range(start, start + difference.shape[axis]), axis) for start in (0, 1))
    return (largest_channel(np.abs(difference)) <= REGIONS.steep_ramp_step) & before & behind


def _pure(right: Mask, below: Mask, width: int) -> Mask:
    """Return the pixels [h, w] of the squares in which all links to the right and below hold."""
    height, row_length = below.shape[0] + 1, right.shape[1] + 1
    if min(height, row_length) < width:
        return np.zeros((height, row_length), bool)
    across = _windows(right, width, width - 1)
    down = _windows(below, width - 1, width)
    corners = across & down
    pure = np.zeros((height, row_length), bool)
    pure[: corners.shape[0], : corners.shape[1]] = corners
    return ndimage.binary_dilation(pure, np.ones((width, width)), origin=-((width - 1) // 2) - (width % 2 == 0) * 1)


def _windows(mask: Mask, height: int, width: int) -> Mask:
    """Return whether ``mask`` holds in each window of ``height`` x ``width``."""
    rows, columns = mask.shape[0] - height + 1, mask.shape[1] - width + 1
    return np.logical_and.reduce(
        [mask[row : row + rows, column : column + columns] for row in range(height) for column in range(width)]
    )


def linked_areas(pure: Mask, right: Mask, below: Mask) -> Integers32:
    """Number the areas of pixels that links connect, in the order of their first pixels; ``NONE`` is elsewhere.

    The links of runs of pixels in a row are searched, because there are far fewer runs than pixels.
    """
    goes_on = np.zeros(pure.shape, bool)
    goes_on[:, 1:] = right & pure[:, 1:] & pure[:, :-1]
    run = np.cumsum(pure & ~goes_on, dtype=np.int32).reshape(pure.shape) - 1
    count = int(run[-1, -1]) + 1
    if not count:
        return np.full(pure.shape, NONE, np.int32)
    link = below & pure[1:] & pure[:-1]
    is_first = link.copy()  # of the links of two runs, one is enough
    is_first[:, 1:] &= ~(link[:, :-1] & goes_on[1:, 1:] & goes_on[:-1, 1:])
    parts = connected_parts(run[:-1][is_first], run[1:][is_first], count).astype(np.int32)
    return np.where(pure, parts[run], np.int32(NONE))


def connected_areas(mask: Mask, diagonal: bool = False) -> Integers32:
    """Return numbers from 0 of the connected areas of ``mask`` [h, w], and ``NONE`` elsewhere."""
    labels, _ = ndimage.label(mask, np.ones((3, 3)) if diagonal else None)
    return (labels - 1).astype(np.int32)


def pixels_of(labels: Integers32) -> list[Places]:
    """Return the pixels of each area of ``labels`` [h, w], from 0, numbered by rows."""
    order = np.argsort(labels.ravel(), kind="stable")
    count = np.bincount(labels.ravel() + 1)
    return np.split(order, np.cumsum(count)[:-1])[1:] if len(count) > 1 else []


def points_of(pixels: Places, width: int) -> Floats:
    """Return the centres x, y [N, 2] of pixels numbered by rows."""
    return np.stack([pixels % width, pixels // width], 1).astype(np.float64) + 0.5


def without_small(labels: Integers32, area_min: float) -> Integers32:
    """Return ``labels`` [h, w], numbered anew, without the areas of fewer than ``area_min`` pixels."""
    area = np.bincount(labels[labels >= 0], minlength=labels.max() + 1)
    is_kept = area >= area_min
    number = np.append(np.where(is_kept, np.cumsum(is_kept) - 1, NONE), NONE)
    return number[labels].astype(np.int32)


def grow_by_paint(
    labels: Integers32, where: Mask, picture: Floats32, paints: Paints, metric: Floats32, tolerance: float
) -> Integers32:
    """Return ``labels`` [h, w] with each area grown over the pixels ``where`` [h, w] beside it that show its paint."""
    labels = labels.copy()
    height, width = labels.shape
    is_new = labels != NONE
    for _ in range(REGIONS.growth_max):
        rows, columns = np.nonzero(_beside(is_new) & (labels == NONE) & where)
        if len(rows) == 0:
            break
        best, label = np.full(len(rows), tolerance, np.float32), np.full(len(rows), NONE, np.int32)
        for down, right in SIDES:
            row, column = np.clip(rows + down, 0, height - 1), np.clip(columns + right, 0, width - 1)
            beside = np.flatnonzero(labels[row, column] != NONE)
            candidate = labels[row[beside], column[beside]]
            difference = _difference(candidate, rows[beside], columns[beside], picture, paints, metric)
            is_better = difference < best[beside]
            better = beside[is_better]
            best[better], label[better] = difference[is_better], candidate[is_better]
        is_new = np.zeros(labels.shape, bool)
        is_new[rows, columns] = label != NONE
        labels[rows, columns] = label
    return labels


def _beside(mask: Mask) -> Mask:
    """Return the pixels with a neighbour in ``mask`` [h, w]."""
    result = np.zeros_like(mask)
    result[1:] |= mask[:-1]
    result[:-1] |= mask[1:]
    result[:, 1:] |= mask[:, :-1]
    result[:, :-1] |= mask[:, 1:]
    return result


def _difference(
    label: Integers32, rows: Places, columns: Places, picture: Floats32, paints: Paints, metric: Floats32
) -> Floats32:
    x, y = (place.astype(np.float32) + np.float32(0.5) for place in (columns, rows))
    seen = (picture[rows, columns] - paints.at(label, x, y)) @ metric
    return largest_channel(np.abs(np.asarray(seen, np.float32)))
