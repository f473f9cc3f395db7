"""Lines thinner than a pixel stay in one piece where they lie between two pixels."""

from __future__ import annotations

import numpy as np

from warpvec.arrays import Floats32, Integers32, Places
from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.regions.assignment import Assignment


def keep_hairlines(assignment: Assignment, is_noisy: bool) -> None:
    """Give pixels to lines that have less than half of each of two pixels side by side, but enough of both."""
    label, other, share = assignment.label, assignment.other, assignment.share
    width_min = REGIONS.noisy_hairline_width_min if is_noisy else REGIONS.hairline_width_min
    _raise_shares(label, other, share, width_min)
    _raise_shares(label.T, other.T, share.T, width_min)


def _raise_shares(label: Integers32, other: Integers32, share: Floats32, width_min: float) -> None:
    """Change the arrays [h, w] where lines of ``width_min`` run between two pixels of a row."""
    middle, left_side, right_side = slice(1, -1), slice(1, -2), slice(2, -1)
    line = other[middle, left_side]
    is_split = (line != label[middle, left_side]) & (line != label[middle, right_side])
    rows, columns = np.nonzero(is_split & (line == other[middle, right_side]))
    rows, columns = rows + 1, columns + 1
    name = other[rows, columns]
    left, right = 1 - share[rows, columns], 1 - share[rows, columns + 1]
    beside = [_share_of(name, label, other, share, rows, columns + step) for step in (-1, 2)]
    ahead = [
        _share_of(name, label, other, share, rows + down, columns + step) for down in (-1, 1) for step in range(-1, 3)
    ]
    chosen = (left + right >= width_min) & (np.maximum(*beside) <= REGIONS.hairline_beside_max)
    chosen &= np.maximum.reduce(ahead) <= REGIONS.hairline_ahead_max
    rows, columns, name = rows[chosen], columns[chosen], name[chosen]
    left, right = left[chosen], right[chosen]
    more = columns + (right > left)
    less = columns + (right <= left)
    other[rows, more], label[rows, more], share[rows, more] = label[rows, more], name, REGIONS.hairline_raised_share
    share[rows, less] = 1 - np.maximum(left + right - REGIONS.hairline_raised_share, 0)
    is_gone = share[rows, less] == 1
    other[rows[is_gone], less[is_gone]] = label[rows[is_gone], less[is_gone]]


def _share_of(
    name: Integers32, label: Integers32, other: Integers32, share: Floats32, rows: Places, columns: Places
) -> Floats32:
    """Return the share of the regions ``name`` [N] in pixels."""
    part = share[rows, columns]
    rest = np.where(other[rows, columns] == name, 1 - part, 0)
    return np.where(label[rows, columns] == name, part, rest)
