"""Thin lines that go on over shapes of other colours than the paper on which they were found.

The ink of a line in a row is its width times the difference of its colour from the ground. On one ground, nobody can
tell a dark thin line from a lighter one that is wider. On two, both are known.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats, Mask
from warpvec.flat.constants.thin_lines import THIN_LINES
from warpvec.flat.thin_lines.following import ThinLine, profile_of
from warpvec.flat.thin_lines.looks import EqualLines

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


class _Rows(NamedTuple):
    """The n rows in which lines lie on other grounds: their ink [n, 3], the ground [n, 3], and their x and y [n, 2]."""

    ink: Floats
    ground: Floats
    place: Floats


class Standing(NamedTuple):
    """Equal lines, and what other grounds than their paper say of them.

    Attributes:
        equal: the lines.
        is_hidden: whether shapes of other colours hide them.
        places: x and y [n, 2] in pixels where they are seen on shapes of other colours.
    """

    equal: EqualLines
    is_hidden: bool
    places: Floats


def grounds_of(levels: Floats) -> Grounds | None:
    """Return the grounds of a picture ``levels`` [h, w, 3]; None if no part of it is even."""
    is_area = (ndimage.maximum_filter(levels, (3, 3, 1)) == ndimage.minimum_filter(levels, (3, 3, 1))).all(2)
    if not is_area.any():
        return None
    rows, columns = ndimage.distance_transform_edt(~is_area, return_distances=False, return_indices=True)
    color, side = levels[rows, columns], (_SIDE, _SIDE, 1)
    return Grounds(color, (ndimage.maximum_filter(color, side) == ndimage.minimum_filter(color, side)).all(2))


def standing(equal: EqualLines, levels: Floats, paper: Floats, grounds: Grounds) -> Standing:
    """Return how ``equal`` lines of a picture ``levels`` [h, w, 3], found on ``paper`` [3], stand to other grounds."""
    parts = [_rows(line, levels, paper, grounds) for line in equal.lines]
    rows = _Rows(*(np.concatenate(each) for each in zip(*parts, strict=True)))
    if not len(rows.ink):
        return Standing(equal, False, np.zeros((0, 2)))
    own = np.average([line.ink for line in equal.lines], axis=0, weights=[line.length for line in equal.lines])
    # The ink is w (c - paper) there, and w (c - ground) here.
    step = rows.ground - paper
    widths = ((own - rows.ink) * step).sum(1) / (step * step).sum(1)
    is_seen = np.linalg.norm(rows.ink, axis=1) * np.sqrt(3.0) >= THIN_LINES.contrast_min
    is_seen &= (widths > 0.0) & (widths <= np.sqrt(2.0) * THIN_LINES.width_max)
    width = float(np.median(widths[is_seen])) if is_seen.any() else 0.0
    expected = own - width * step
    sizes = np.maximum(np.linalg.norm(own), np.linalg.norm(expected, axis=1))
    is_seen &= np.linalg.norm(rows.ink - expected, axis=1) <= THIN_LINES.clean_difference * sizes
    if 2 * is_seen.sum() <= len(rows.ink):
        return Standing(equal, True, np.zeros((0, 2)))
    return Standing(_with_look(equal, paper + own / width, width), False, rows.place[is_seen])


def _with_look(equal: EqualLines, color: Floats, width: float) -> EqualLines:
    """Return ``equal`` lines with the ``color`` [3] and the ``width`` in a row that two grounds tell."""
    room = 255.0 * THIN_LINES.explained
    is_known = np.abs(color - equal.color).max() <= room or color.min() < -room or color.max() > 255.0 + room
    if is_known or all(line.is_crisp for line in equal.lines):
        return equal
    # Renderers draw lines of at most a pixel as opaque as they are wide, in rows and columns.
    across = width if width <= 1.0 else max(width / float(np.hypot(1.0, equal.lines[0].slope)), 1.0)
    return replace(equal, color=np.rint(color).clip(0.0, 255.0), width=across)


def _rows(line: ThinLine, levels: Floats, paper: Floats, grounds: Grounds) -> _Rows:
    """Return the rows in which ``line`` lies on other grounds than ``paper``."""
    given = (levels, grounds.color, grounds.is_even)
    part, color, is_even = (each.swapaxes(0, 1) if line.is_level else each for each in given)
    residual = part - color
    total = profile_of(residual, np.abs(residual).sum(2), line.start, line.slope).total
    y = np.arange(max(int(np.ceil(line.top)), 0), min(int(line.bottom), len(part)))
    x = np.floor(line.start + line.slope * (y + 0.5)).astype(np.int64).clip(0, part.shape[1] - 1)
    is_other = is_even[y, x] & (np.abs(color[y, x] - paper).sum(1) >= THIN_LINES.contrast_min)
    y, x = y[is_other], x[is_other]
    return _Rows(total[y], color[y, x], np.stack([y, x] if line.is_level else [x, y], 1) + 0.5)


def places_of(equal: EqualLines, levels: Floats, paper: Floats, grounds: Grounds) -> Floats:
    """Return x and y [n, 2] in pixels where ``equal`` lines lie on other grounds than ``paper`` [3]."""
    return np.concatenate([_rows(line, levels, paper, grounds).place for line in equal.lines])


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
