"""Thin lines that go on over shapes of other colours than the paper on which they were found.

The ink of a line in a row is its width times the difference of its colour from the ground. On one ground, nobody can
tell a dark thin line from a lighter one that is wider. On two, both are known.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from warpvec.arrays import Floats, Mask
from warpvec.flat.constants.thin_lines import THIN_LINES
from warpvec.flat.thin_lines.following import ThinLine, profile_of
from warpvec.flat.thin_lines.grounds import Grounds
from warpvec.flat.thin_lines.looks import EqualLines


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
    lines = [_extended(line, levels, own + width * paper, width, grounds) for line in equal.lines]
    longer = replace(equal, lines=lines)
    return Standing(_with_look(longer, paper + own / width, width), False, rows.place[is_seen])


def _with_look(equal: EqualLines, color: Floats, width: float) -> EqualLines:
    """Return ``equal`` lines with the ``color`` [3] and the ``width`` in a row that two grounds tell."""
    room = 255.0 * THIN_LINES.explained
    is_known = np.abs(color - equal.color).max() <= room or color.min() < -room or color.max() > 255.0 + room
    if is_known or all(line.is_crisp for line in equal.lines):
        return equal
    # Renderers draw lines of at most a pixel as opaque as they are wide, in rows and columns.
    across = width if width <= 1.0 else max(width / float(np.hypot(1.0, equal.lines[0].slope)), 1.0)
    return replace(equal, color=np.rint(color).clip(0.0, 255.0), width=across)


def _extended(line: ThinLine, levels: Floats, ink: Floats, width: float, grounds: Grounds) -> ThinLine:
    """Return ``line`` with the rows beyond its ends that have its ``ink`` [3], less ``width`` times their ground."""
    part, color, is_even = _turned(line, levels, grounds)
    residual, y = part - color, np.arange(len(part))
    x = np.floor(line.start + line.slope * (y + 0.5)).astype(np.int64)
    is_in = (x >= 0) & (x < part.shape[1])
    x = x.clip(0, part.shape[1] - 1)
    total = profile_of(residual, np.abs(residual).sum(2), line.start, line.slope).total
    expected = ink - width * color[y, x]
    limit = THIN_LINES.clean_difference * np.linalg.norm(expected, axis=1)
    is_there = is_in & is_even[y, x] & (np.linalg.norm(total - expected, axis=1) <= limit)
    gaps = np.flatnonzero(~is_there & (is_even[y, x] | ~is_in))
    first, last = round(line.top), round(line.bottom)
    before, after = gaps[gaps < first - 1], gaps[gaps > last]
    above = np.flatnonzero(is_there & (y > before.max(initial=-1)) & (y < first - 1))
    below = np.flatnonzero(is_there & (y < after.min(initial=len(y))) & (y > last))
    top, bottom = float(above.min(initial=len(y))), float(below.max(initial=-1) + 1)
    return line._replace(top=min(line.top, top), bottom=max(line.bottom, bottom))


def _rows(line: ThinLine, levels: Floats, paper: Floats, grounds: Grounds) -> _Rows:
    """Return the rows in which ``line`` lies on other grounds than ``paper``."""
    part, color, is_even = _turned(line, levels, grounds)
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


def _turned(line: ThinLine, levels: Floats, grounds: Grounds) -> tuple[Floats, Floats, Mask]:
    """Return ``levels``, and the colours and even pixels of ``grounds``, with x and y exchanged for level lines."""
    if not line.is_level:
        return levels, grounds.color, grounds.is_even
    return levels.swapaxes(0, 1), grounds.color.swapaxes(0, 1), grounds.is_even.T
