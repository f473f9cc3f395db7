"""Ends of thin strokes: two corners so near to one another that neither sees its own sides.

They look like one sharp tip, or like two corners whose places are far off. Here they are found from the two sides of
the stroke, which are parallel.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warpvec.arrays import Floats, Integers, Mask
from warpvec.flat.constants.curves import CURVES


class StrokeEnds(NamedTuple):
    """Corners of m ends.

    Attributes:
        is_kept: which of the corners that were found before do not belong to an end [n].
        sample: samples at the two corners of each end [m, 2].
        point: those corners [m, 2, 2].
        direction: unit vectors along the outline at the corners [m, 2, 2]: the mean of both sides.
    """

    is_kept: Mask
    sample: Integers
    point: Floats
    direction: Floats


def stroke_ends(xy: Floats, step: float, corner: Integers, turn: Floats) -> StrokeEnds:
    """Find the ends of strokes among the corners of a loop ``xy`` [k, 2].

    Args:
        step: distance between samples in pixels.
        corner: samples at the corners, in order [n].
        turn: change of direction at each of them in radians [n].
    """
    middle, first, second = _candidates(len(xy), step, corner, turn)
    near, far = round(CURVES.stroke_near / step), round(CURVES.stroke_far / step)
    across, far_across = (_ring(xy, middle + k) - _ring(xy, middle - k) for k in (near, far))
    width = np.hypot(*across.T)
    is_end = np.abs(np.hypot(*far_across.T) - width) < CURVES.stroke_growth
    is_end &= (width < CURVES.stroke_width_max) & (len(xy) > 4 * far)
    is_kept = np.ones(len(corner), bool)
    is_kept[first[is_end]] = is_kept[second[is_end]] = False
    return StrokeEnds(is_kept, *_corners_of(xy, step, middle[is_end]))


def _candidates(count: int, step: float, corner: Integers, turn: Floats) -> tuple[Integers, Integers, Integers]:
    """Return the middles of what may be ends [c], and their first and second corner, which are one if it is a tip."""
    rows = np.arange(len(corner))
    after = np.roll(rows, -1)
    gap = (corner[after] - corner) % max(count, 1)
    is_pair = (
        (gap > 0)
        & (gap * step < CURVES.stroke_width_max)
        & (turn + turn[after] > CURVES.stroke_turn_min)
        & (len(corner) > 2)
    )
    is_pair &= ~(is_pair & np.roll(is_pair, 1))  # each corner belongs to one pair
    in_pair = is_pair | np.roll(is_pair, 1)
    tips = rows[(turn > CURVES.stroke_turn_min) & ~in_pair]
    pairs = rows[is_pair]
    middle = np.concatenate([corner[tips], corner[pairs] + gap[pairs] // 2])
    return middle, np.concatenate([tips, pairs]), np.concatenate([tips, after[pairs]])


def _corners_of(xy: Floats, step: float, middle: Integers) -> tuple[Integers, Floats, Floats]:
    """Return samples, places and directions of the two corners of the ends around the samples ``middle`` [m]."""
    near, far = round(CURVES.stroke_near / step), round(CURVES.stroke_far / step)
    across = _ring(xy, middle + near) - _ring(xy, middle - near)
    width = np.hypot(*across.T)[:, None]
    across = across / np.maximum(width, 1e-9)
    near_middle, far_middle = ((_ring(xy, middle + k) + _ring(xy, middle - k)) / 2 for k in (near, far))
    along = near_middle - far_middle
    along /= np.maximum(np.hypot(*along.T), 1e-9)[:, None]
    around = _ring(xy, middle[:, None] + np.arange(-near, near + 1))
    reach = ((around - near_middle[:, None]) * along[:, None]).sum(-1).max(1, initial=0.0)
    sides = np.array([-0.5, 0.5])
    tip = near_middle + reach[:, None] * along
    point = tip[:, None] + (sides * width)[..., None] * across[:, None]
    sample = (middle[:, None] + np.rint(sides * width / step).astype(np.int64)) % len(xy)
    direction = across[:, None] - 2 * sides[:, None] * along[:, None]
    return sample, point, direction / np.sqrt(2.0)


def _ring(xy: Floats, rows: Integers) -> Floats:
    """Return the samples ``rows`` of a loop, counted around it."""
    return xy[rows % len(xy)]
