"""Straight sides and square ends of thin parts: the stems and bars of letters.

The outline of a stem follows the noise of sub-pixels. A side that is nearly level or upright becomes exactly so, at its
mean place, and the end between two such sides becomes square. Both keep the area, and so the ink of the pixels.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats, Integers, Mask
from warpvec.flat.constants.lettering import LETTERING
from warpvec.flat.curves.closed_runs import closed_runs


class _Side(NamedTuple):
    """A level or upright side of a loop.

    Attributes:
        axis: coordinate that all its points share: 0 if it is upright, 1 if it is level.
        rows: its points in the loop, in order [k].
        place: the coordinate that they share.
        way: 1 or -1, whether the other coordinate rises or falls along it.
    """

    axis: int
    rows: Integers
    place: float
    way: float


def with_straight_sides(loop: Floats) -> Floats:
    """Return the closed contour ``loop`` [n, 2] of a thin part, in pixels, with straight sides and square ends."""
    sides = _sides(loop)
    pairs = [(side, sides[(index + 1) % len(sides)]) for index, side in enumerate(sides)]
    ends = {index: end for index, pair in enumerate(pairs) if (end := _square_end(loop, *pair)) is not None}
    straight, stays = loop.copy(), np.ones(len(loop), bool)
    for index, side in enumerate(sides):
        is_beside_end = index in ends or (index - 1) % len(sides) in ends
        kept = side if is_beside_end else _side(loop, side.rows, side.axis, LETTERING.lone_error, LETTERING.lone_side)
        if kept is not None:
            straight[kept.rows, kept.axis] = kept.place
    for index, end in ends.items():
        _make_square(straight, stays, *pairs[index], end)
    return straight[stays]


def _sides(loop: Floats) -> list[_Side]:
    """Return the sides of ``loop`` [n, 2] in its order; where two overlap, the longer one."""
    runs = [(run, axis) for axis in (0, 1) for run in _runs(_is_straight(loop, axis))]
    tried = [_side(loop, run, axis, LETTERING.side_error, LETTERING.side_length) for run, axis in runs]
    found = [side for side in tried if side is not None]
    found.sort(key=lambda side: -len(side.rows))
    taken, sides = np.zeros(len(loop), bool), list[_Side]()
    for side in found:
        if not taken[side.rows].any():
            taken[side.rows] = True
            sides.append(side)
    return sorted(sides, key=lambda side: int(side.rows[0]))


def _side(loop: Floats, run: Integers, axis: int, error: float, length_min: float) -> _Side | None:
    """Return the longest piece of a ``run`` of points [k] that lies within ``error`` of its line, if it is long."""
    is_near = np.abs(loop[run, axis] - np.median(loop[run, axis])) <= error
    rows = run[max(_runs(np.append(is_near, False)), key=len, default=np.arange(1))]
    across, along = loop[rows, axis], loop[rows, 1 - axis]
    if abs(along[-1] - along[0]) < length_min:
        return None
    lengths = np.diff(along)
    place = float(((across[1:] + across[:-1]) / 2.0 * lengths).sum() / lengths.sum())
    return _Side(axis, rows, place, float(np.sign(along[-1] - along[0])))


def _is_straight(loop: Floats, axis: int) -> Mask:
    """Return which points [n] are of a piece, as long as a side at least, that hardly leaves a line across ``axis``."""
    steps = round(LETTERING.side_length * LETTERING.fineness)
    if len(loop) <= 2 * steps:
        return np.zeros(len(loop), bool)
    rows = (np.arange(len(loop))[:, None] + np.arange(steps + 1)) % len(loop)
    across, along = loop[rows, axis], loop[rows, 1 - axis]
    is_long = np.abs(along[:, -1] - along[:, 0]) >= LETTERING.side_share * LETTERING.side_length
    begins = (np.ptp(across, 1) <= 2.0 * LETTERING.side_error) & is_long
    return np.asarray(ndimage.maximum_filter1d(begins, steps + 1, mode="wrap", origin=steps // 2), bool)


def _runs(mask: Mask) -> list[Integers]:
    """Return the rows of each run of a closed ``mask`` [n], in order."""
    return [np.arange(first, last) % len(mask) for first, last in closed_runs(mask)]


def _square_end(loop: Floats, side: _Side, following: _Side) -> float | None:
    """Return where the square end of a stem lies along it, if the part of ``loop`` between two sides is an end."""
    axis = side.axis
    width = (side.place - following.place) * side.way * (1.0 if axis == 0 else -1.0)  # below 0 between two stems
    if axis != following.axis or side.way == following.way or not 0.0 < width <= LETTERING.end_width_max:
        return None
    tip = loop[[side.rows[-1], *_between(loop, side, following), following.rows[0]]]
    start = tip[[0, -1], 1 - axis].mean()
    beyond = (tip[:, 1 - axis] - start) * side.way
    aside = np.abs(tip[:, axis] - (side.place + following.place) / 2.0) - width / 2.0
    if aside.max() > LETTERING.end_error or np.abs(beyond).max() > LETTERING.end_length_max:
        return None
    across = np.concatenate([[side.place], tip[1:-1, axis], [following.place]])
    area = abs(float(((beyond[1:] + beyond[:-1]) / 2.0 * np.diff(across)).sum()))
    end = float(start + side.way * area / width)
    is_beyond = ((end - loop[[side.rows[0], following.rows[-1]], 1 - axis]) * side.way > 0.0).all()
    return end if is_beyond else None


def _between(loop: Floats, side: _Side, following: _Side) -> Integers:
    first = int(side.rows[-1]) + 1
    return (first + np.arange((int(following.rows[0]) - first) % len(loop))) % len(loop)


def _make_square(loop: Floats, stays: Mask, side: _Side, following: _Side, end: float) -> None:
    """Move the corners of ``loop`` [n, 2] between two sides to the ``end``, and mark what no longer ``stays`` [n]."""
    along = 1 - side.axis
    stays[_between(loop, side, following)] = False
    for rows, corner in ((side.rows, side.rows[-1]), (following.rows, following.rows[0])):
        stays[rows[(loop[rows, along] - end) * side.way >= 0.0]] = False
        stays[corner] = True
        loop[corner, along] = end
