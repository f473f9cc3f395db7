"""The gaps between the boxes of marks: which are as close as letters of a line."""

from __future__ import annotations

import numpy as np

from warpvec.arrays import Floats32, Mask
from warpvec.flat.constants.lettering import LETTERING


def gaps_between(boxes: Floats32, others: Floats32) -> Floats32:
    """Return the pixels between ``boxes`` [..., 4] and ``others`` [..., 4], in rows and in columns [..., 2].

    They are negative where two boxes overlap. A box is its first row, first column, and the last ones.
    """
    return np.maximum(boxes[..., :2] - others[..., 2:], others[..., :2] - boxes[..., 2:]) - 1


def are_close(boxes: Floats32, others: Floats32) -> Mask:
    """Return which of ``boxes`` [..., 4] are as close to ``others`` [..., 4] as letters of a line [...]."""
    tall = np.maximum(boxes[..., 2] - boxes[..., 0], others[..., 2] - others[..., 0]) + 1
    reach = np.array([LETTERING.reach_down, LETTERING.reach_across], np.float32)
    limit = np.maximum(reach * tall[..., None], LETTERING.reach_min)
    return np.asarray((gaps_between(boxes, others) <= limit).all(-1))


def are_dots_between(boxes: Floats32, others: Floats32) -> Mask:
    """Return which of ``boxes`` [..., 4] are small dots in the line of ``others`` [..., 4], a space away [...]."""
    is_dot = (boxes[..., 2:] - boxes[..., :2]).max(-1) < LETTERING.weak_side_max
    tall = others[..., 2] - others[..., 0] + 1
    limit = np.stack([np.zeros_like(tall), LETTERING.reach_of_dots * tall], -1)
    return np.asarray(is_dot & (gaps_between(boxes, others) <= limit).all(-1))
