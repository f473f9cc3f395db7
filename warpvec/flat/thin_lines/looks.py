"""The colours, widths and directions of thin lines: those of equal lines are exactly equal.

Skia and resvg draw a line of a width of at most one pixel as one of one pixel, as opaque as it is wide, measured along
rows or columns. So its ink in a row tells its width if its colour is known, at any angle.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from warpvec.arrays import Floats
from warpvec.flat.constants.thin_lines import THIN_LINES
from warpvec.flat.price import PRECISION
from warpvec.flat.thin_lines.following import ThinLine

_DRIFT = 2.0 * PRECISION
"""A line that moves by less in pixels over its length is a level or a plumb line: each end may be off by half of it."""


@dataclass(frozen=True, eq=False)
class EqualLines:
    """Equal lines of one direction.

    Attributes:
        lines: the lines.
        color: their colour [3], in levels.
        width: their width in pixels.
    """

    lines: list[ThinLine]
    color: Floats
    width: float


class _Look(NamedTuple):
    """The colour [3] of a line in levels, and its width in pixels."""

    color: Floats
    width: float


def equal_lines(lines: list[ThinLine], paper: Floats, inks: Floats) -> list[EqualLines]:
    """Return the ``lines`` that have equals on ``paper`` [3], by the colours ``inks`` [n, 3] of the picture.

    There must be a few equal parallel lines, or a long one that is not clean for a part, as an axis below bars is.
    Longer lines of the same look belong to them.
    """
    looks = [_look(line.ink, line.slope, paper, inks) for line in lines]
    thin = [k for k in range(len(lines)) if looks[k].width <= THIN_LINES.width_max]
    found: list[EqualLines] = []
    for members in _alike([lines[k] for k in thin], [looks[k] for k in thin]):
        group = [lines[thin[k]] for k in members]
        lengths = [line.length for line in group]
        total = np.average([line.ink for line in group], axis=0, weights=lengths)
        if all(line.is_crisp for line in group):  # as pixels are: somebody has placed them so
            color, width = paper + total, 1.0
        else:
            color = _look(total, 0.0, paper, inks).color
            width = float(np.average([_width(line.ink, line.slope, color - paper) for line in group], weights=lengths))
        found += [EqualLines(part, color, width) for part in _chosen(_parallel(group))]
    return found


def _look(total: Floats, slope: float, paper: Floats, inks: Floats) -> _Look:
    """Return the look of a line by its ink in a row [3]: the strongest ink of the picture that it may have.

    It is as light as it seems if there is none, unless no colour is so strong.
    """
    size, steps = float(np.linalg.norm(total)), inks - paper
    sizes = np.maximum(np.linalg.norm(steps, axis=1), 1e-9)
    widths = size / sizes
    is_ink = (steps @ total >= THIN_LINES.ink_cosine * sizes * size) & (widths >= THIN_LINES.width_min)
    is_ink &= widths <= np.sqrt(2.0) * THIN_LINES.width_max
    if is_ink.any():
        color = inks[np.where(is_ink, sizes, 0.0).argmax()]
    else:
        room = np.where(total < 0.0, paper, np.maximum(255.0 - paper, 1e-9))
        color = paper + total / max(float(np.abs(total / np.maximum(room, 1e-9)).max()), 1.0)
    return _Look(color, _width(total, slope, color - paper))


def _width(total: Floats, slope: float, step: Floats) -> float:
    """Return the width of a line by its ink in a row and by its colour less the paper, ``step`` [3]."""
    across = float(total @ step) / max(float(step @ step), 1e-9)
    return min(across, 1.0) if across <= 1.0 + THIN_LINES.explained else across / float(np.hypot(1.0, slope))


def _alike(lines: list[ThinLine], looks: list[_Look]) -> list[list[int]]:
    """Return the groups of lines of about the same colour and width, the longest lines first."""
    groups: list[list[int]] = []
    for k in sorted(range(len(lines)), key=lambda k: -lines[k].length):
        for group in groups:
            first = looks[group[0]]
            is_color = np.abs(looks[k].color - first.color).max() <= THIN_LINES.alike * 255.0
            if is_color and abs(looks[k].width - first.width) <= THIN_LINES.alike * max(looks[k].width, first.width):
                group.append(k)
                break
        else:
            groups.append([k])
    return groups


def _parallel(group: list[ThinLine]) -> list[list[ThinLine]]:
    """Return the lines of a group by their direction, which the lines of each then share."""
    parts: list[list[ThinLine]] = []
    for line in group:
        for part in parts:
            first = part[0]
            limit = THIN_LINES.parallel + _DRIFT / line.length
            if first.is_level == line.is_level and abs(first.slope - line.slope) <= limit:
                part.append(line)
                break
        else:
            parts.append([line])
    return [_turned(part) for part in parts]


def _turned(part: list[ThinLine]) -> list[ThinLine]:
    """Return parallel lines with the very same direction, around their middles."""
    lengths = np.array([line.length for line in part])
    slope = float(np.average([line.slope for line in part], weights=lengths**3))
    if abs(slope) * lengths.max() <= _DRIFT:
        slope = 0.0
    return [_with_slope(line, slope) for line in part]


def _with_slope(line: ThinLine, slope: float) -> ThinLine:
    """Return ``line`` with another slope, turned around its middle."""
    middle = (line.top + line.bottom) / 2.0
    return line._replace(start=line.start + (line.slope - slope) * middle, slope=slope)


def _chosen(parts: list[list[ThinLine]]) -> list[list[ThinLine]]:
    """Return the parts with enough lines, and of others their longer lines, if some have enough."""

    def is_many(part: list[ThinLine]) -> bool:
        return len(part) >= THIN_LINES.equals_min and part[0].length >= THIN_LINES.seed_length

    def is_axis(line: ThinLine) -> bool:
        # As long as `equals_min` lines of `seed_length` together.
        is_long = line.length >= THIN_LINES.equals_min * THIN_LINES.seed_length
        return is_long and line.unclean >= THIN_LINES.axis_unclean_min

    if not any(is_many(part) or any(map(is_axis, part)) for part in parts):
        return []
    kept = [
        part if is_many(part) else [line for line in part if line.length >= THIN_LINES.seed_length] for part in parts
    ]
    return [part for part in kept if part]
