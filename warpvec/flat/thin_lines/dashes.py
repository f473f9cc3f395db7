"""Find dashed lines: marks of one width that follow each other at equal distances, along lines and curves.

A dash is a few pixels of ink. Traced alone, each has an outline of its own, and those of thin ones are crumbs. But the
sum of its ink tells the length and width of a dash. The mean place of its ink is its middle. Its neighbours tell where
the line turns.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats, Mask, reached
from warpvec.flat.constants.lines import LINES
from warpvec.flat.constants.thin_lines import THIN_LINES
from warpvec.flat.lines.line import DrawnLine
from warpvec.flat.price import PRECISION
from warpvec.flat.strokes.line_fitting import Rows
from warpvec.flat.thin_lines.dash_marks import Look, Mark, find_marks
from warpvec.flat.thin_lines.dash_runs import (
    EDGE,
    alike_some_long,
    chains_of,
    even_runs,
    followed,
    off_line,
    with_between,
    with_ends,
)
from warpvec.geometry.strokes import BUTT, ROUND

_LOOKED_AT = 16
"""Dashes of a line that tell its look."""


class DashedLine(NamedTuple):
    """The n dashes of a line, all of one width and colour, and whether each lies in other ink [n]."""

    dashes: list[DrawnLine]
    is_hidden: Mask


def without_dashes(levels: Floats, paper: Floats, inks: Floats) -> tuple[Floats, list[DashedLine]]:
    """Return a picture without its dashed lines, but for the dashes in other ink, and the lines from bottom to top.

    Args:
        levels: the picture [h, w, 3].
        paper: the colour [3] that it lies on.
        inks: the colours [n, 3] that the picture has.
    """
    residual = levels - paper
    labels, _ = ndimage.label(np.abs(residual).sum(2) >= THIN_LINES.contrast_min, np.ones((3, 3)))
    marks = find_marks(residual, labels)
    runs = [run for chain in chains_of(marks) for run in even_runs(chain)]
    found: list[list[Mark]] = []
    taken: set[int] = set()
    for run in sorted(alike_some_long(runs), key=len, reverse=True):
        left = [mark for mark in run if mark.label not in taken]
        if len(left) == len(run):
            free = [mark for mark in marks if mark.label not in taken]
            found.append(with_ends(followed(with_between(run, free), free, residual), free))
            taken.update(mark.label for mark in found[-1])
    levels = np.where(np.isin(labels, [*taken - {0}])[..., None], paper, levels)
    # Of lines that cross, the stronger one is seen.
    looks = zip(found, _looks(found, inks - paper), strict=True)
    ordered = sorted(looks, key=lambda each: float(np.linalg.norm(each[1].color)))
    return levels, [_drawn(run, look, paper) for run, look in ordered]


def _drawn(run: list[Mark], look: Look, paper: Floats) -> DashedLine:
    """Return a dashed line. The dashes of a straight one lie on it at equal distances."""
    is_closed = run[0] is run[-1]
    lengths = _lengths(run, look)
    centers = np.array([mark.center for mark in run])
    places = reached(centers)
    straight = None if is_closed else _straight(centers, lengths)
    from scipy.interpolate import CubicSpline  # pictures without dashes need not load it

    curve = CubicSpline(places, centers, bc_type="periodic" if is_closed else "natural")
    dashes = []
    for k in range(len(run) - is_closed):
        ends = places[k] + lengths[k] * np.array([-0.5, 0.5])
        if straight is not None:
            start, end = straight[k]
            handles = (end - start) / 3.0
            is_line, turns = True, (handles, handles)
        else:
            (start, end), turns = curve(ends), tuple(curve(ends, 1) * lengths[k] / 3.0)
            is_line = False
        control = np.array([[start, start + turns[0], end - turns[1]], [end, end, end]])
        red, green, blue = (np.rint(paper + look.color).clip(0.0, 255.0) / 255.0).tolist()
        rows = Rows(control, np.array([is_line, True]), True)
        dashes.append(DrawnLine(rows, look.width, look.cap, color=(red, green, blue)))
    return DashedLine(dashes, np.array([mark.label == 0 for mark in run])[: len(dashes)])


def _lengths(run: list[Mark], look: Look) -> Floats:
    """Return the lengths [n] of the centre lines of a run's dashes: one for all, but for those at its ends."""
    own = np.array([mark.size(look.color, look.cap)[0] if mark.label else look.length for mark in run])
    is_usual = np.abs(own - look.length) <= 3.0 * EDGE
    rest = np.median(own[~is_usual][1:-1]) if (~is_usual).sum() > 2 else 0.0
    own[~is_usual] = np.where(np.abs(own[~is_usual] - rest) <= 3.0 * EDGE, rest, own[~is_usual])
    own[is_usual] = look.length
    return np.maximum(own, LINES.dot)


def _straight(centers: Floats, lengths: Floats) -> Floats | None:
    """Return the ends [n, 2, 2] of dashes on the line through their ``centers`` [n, 2]; None if they lie on a curve."""
    if off_line(centers) > 2.0 * PRECISION:
        return None
    middle = centers.mean(0)
    along = np.linalg.svd(centers - middle, full_matrices=False)[2][0]
    along = along * np.sign(along @ (centers[-1] - centers[0]))
    if np.abs(along).min() * np.linalg.norm(centers[-1] - centers[0]) <= 2.0 * PRECISION:
        along = np.rint(along)
    at = (centers - middle) @ along
    # Dashes of one length have one distance, and a cut one at an end begins or ends where a whole one would.
    number, whole = np.arange(len(at)), lengths.max()
    is_whole = whole - lengths < 1e-9
    step, start = np.polyfit(number[is_whole], at[is_whole], 1)
    usual = start + step * number
    is_usual = is_whole | (np.abs(at - usual) <= 2.0 * EDGE)
    ends = np.where(is_usual, usual, at)[:, None] + lengths[:, None] * np.array([-0.5, 0.5])
    for row, beside, side in ((0, 1, 1), (-1, -2, 0)):
        if not is_whole[row] and is_whole[beside]:
            ends[row, 1 - side] = at[row] - lengths[row] * (side - 0.5)
            ends[row, side] = usual[row] + whole * (side - 0.5)
    return np.asarray(middle + ends[..., None] * along)


def _looks(runs: list[list[Mark]], steps: Floats) -> list[Look]:
    """Return the look of the dashes of each run. Runs that are alike share one object."""
    known: list[tuple[Floats, float, Look]] = []
    for run in runs:
        usual = _usual(run)
        length = float(np.median([mark.length for mark in usual]))
        ink = np.median([mark.ink.sum((0, 1)) for mark in usual], 0)
        size = float(np.linalg.norm(ink))
        alike = [
            look
            for other, other_length, look in known
            if abs(length - other_length) <= EDGE and np.linalg.norm(ink - other) <= THIN_LINES.alike * size
        ]
        known.append((ink, length, alike[0] if alike else _look(usual, steps)))
    return [look for _, _, look in known]


def _usual(run: list[Mark]) -> list[Mark]:
    """Return some marks of a run with its usual length."""
    seen = [mark for mark in run if mark.label]
    length = float(np.median([mark.length for mark in seen]))
    return [mark for mark in seen if abs(mark.length - length) <= 2.0 * EDGE][:_LOOKED_AT]


def _look(usual: list[Mark], steps: Floats) -> Look:
    """Return the look of dashes: the ink of ``steps`` [n, 3] and the ends that explain them best."""
    total = np.sum([mark.ink.sum((0, 1)) for mark in usual], 0)
    peak = total * max(float(np.linalg.norm(mark.ink, axis=2).max()) for mark in usual) / np.linalg.norm(total)
    sizes = np.linalg.norm(steps, axis=1) * np.linalg.norm(total)
    some = steps[steps @ total >= THIN_LINES.ink_cosine * np.maximum(sizes, 1e-9)]

    def misfit(look: Look) -> float:
        return sum(mark.off(look) for mark in usual)

    looks = [_usual_look(usual, color, cap) for color in [*some, peak] for cap in (BUTT, ROUND)]
    color = min(looks, key=misfit).color
    flat, rounded = (_with_best_length(_usual_look(usual, color, cap), misfit) for cap in (BUTT, ROUND))
    # Of thin dashes nobody can tell the ends.
    is_round = misfit(rounded) < (1.0 - THIN_LINES.alike) * misfit(flat)
    return _drawn_width(rounded if is_round else flat, usual)


def _drawn_width(look: Look, marks: list[Mark]) -> Look:
    """Return ``look`` with the width by which renderers draw thin lines: as opaque as wide in rows or columns."""
    share = float(np.mean([np.abs(mark.along).max() for mark in marks]))
    across = look.width / share
    return look._replace(width=min(across, 1.0)) if across <= 1.0 + THIN_LINES.explained else look


def _usual_look(marks: list[Mark], color: Floats, cap: int) -> Look:
    """Return the look of ``marks`` with an ink and a cap, by what their ink tells."""
    length, width = np.median([mark.size(color, cap) for mark in marks], 0).tolist()
    return Look(color, width, length, cap)


def _with_best_length(look: Look, misfit: Callable[[Look], float]) -> Look:
    """Return ``look`` with the length that fits best: whole pixels tell the spread of ink less well."""
    area = look.width * (look.length + (look.cap == ROUND) * math.pi * look.width / 4.0)

    def stretched(length: float) -> Look:
        if look.cap == BUTT:
            return look._replace(length=length, width=area / length)
        width = (math.sqrt(length**2 + math.pi * area) - length) * 2.0 / math.pi
        return look._replace(length=length, width=width)

    tick, count = PRECISION / 4.0, round(8.0 * EDGE / PRECISION)
    lengths = tick * (round(look.length / tick) + np.arange(-count, count + 1))
    return min((stretched(float(length)) for length in lengths if length > 0.0), key=misfit)
