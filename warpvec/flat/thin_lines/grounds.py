"""The grounds of a picture: its even areas, and what they are below thin lines."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats, Mask
from warpvec.flat.constants.thin_lines import THIN_LINES

_SIDE = 5
"""Side in pixels of a square that a thin line lies in with its ground on both sides."""


class Grounds(NamedTuple):
    """What lies below thin lines.

    Attributes:
        color: the colour [h, w, 3] of the nearest even area, in levels.
        is_even: pixels [h, w] around which there is one ground.
    """

    color: Floats
    is_even: Mask


def grounds_of(levels: Floats) -> Grounds | None:
    """Return the grounds of a picture ``levels`` [h, w, 3]; None if no part of it is even."""
    is_area = (ndimage.maximum_filter(levels, (3, 3, 1)) == ndimage.minimum_filter(levels, (3, 3, 1))).all(2)
    if not is_area.any():
        return None
    rows, columns = ndimage.distance_transform_edt(~is_area, return_distances=False, return_indices=True)
    color, side = levels[rows, columns], (_SIDE, _SIDE, 1)
    return Grounds(color, (ndimage.maximum_filter(color, side) == ndimage.minimum_filter(color, side)).all(2))


def without_lines(levels: Floats, layer: Floats, grounds: Grounds) -> Floats:
    """Return the picture ``levels`` [h, w, 3] without the lines of ``layer`` [h, w, 4], which are above all else."""
    opacity, line = layer[..., 3:] / 255.0, layer[..., :3]
    alpha, contrast = opacity[..., 0], np.abs(line - grounds.color).max(2)
    limit = THIN_LINES.explained * contrast + 2.0
    is_line, is_full = alpha > 0.0, alpha > 0.7
    is_plain = np.abs(levels - grounds.color - opacity * (line - grounds.color)).max(2) <= limit
    below = ((levels - opacity * line) / np.maximum(1.0 - opacity, 0.3)).clip(0.0, 255.0)
    rows, columns = ndimage.distance_transform_edt(is_line, return_distances=False, return_indices=True)
    result = np.where((is_line & ~is_full)[..., None], below, levels)
    # A full pixel of the line hides what is below: between two grounds, that is as beside it.
    is_hiding = is_full & (np.abs(levels - line).max(2) <= limit + 255.0 * (1.0 - alpha))
    result = np.where(is_hiding[..., None], levels[rows, columns], result)
    return np.asarray(np.where((is_line & is_plain & grounds.is_even)[..., None], grounds.color, result))
