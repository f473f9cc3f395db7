"""Relations between the numbers of a sketch: what a designer says once, and a fit says many times.

Each is a candidate that clustering finds among the numbers of a first solution. The next solution holds it exactly, and
the picture judges that.
"""

from __future__ import annotations

import numpy as np

from warpvec.arrays import Floats, Integers
from warpvec.flat.chains.parts import ARC, LINE, radius_of
from warpvec.flat.chains.solve import Sketch

LEVEL_DEGREES = 3.0
"""Largest angle by which a line turns to be level, upright or diagonal."""

GAP = 2.0
SPREAD = 4.0
"""Numbers are one if neighbours among them differ by so many details, and all of them by so many. A coordinate between
two others is off by a detail on both sides."""


def find_relations(sketch: Sketch, detail: float) -> None:
    """Add to ``sketch`` what nearly holds among its numbers: by moves of ``detail`` pixels at both ends of a line."""
    lines = sketch.rows_of_kind(LINE)
    numbers = np.array([sketch.of(part) for part in lines]).reshape(-1, 4)
    columns = np.array([sketch.columns[part] for part in lines]).reshape(-1, 4)
    for axis in (0, 1):
        off, along = (
            np.abs(numbers[:, axis + 2] - numbers[:, axis]),
            np.abs(numbers[:, 3 - axis] - numbers[:, 1 - axis]),
        )
        is_level = (off <= GAP * detail) & (off <= np.tan(np.radians(LEVEL_DEGREES)) * along)
        sketch.equal += columns[is_level][:, [axis, axis + 2]].tolist()
        axes = np.array([sketch.axes[n] for n, fold in sketch.folded.items() if fold == axis], np.int64)
        own = np.concatenate([columns[is_level, axis], np.unique(axes)]).astype(np.int64)
        sketch.equal += _pairs(sketch.numbers[own], own, detail)
    rise = np.abs(numbers[:, 2:] - numbers[:, :2])
    off = np.abs(rise[:, 0] - rise[:, 1])
    is_diagonal = (off <= GAP * detail) & (off <= np.tan(np.radians(LEVEL_DEGREES)) * rise.max(1, initial=0.0))
    sketch.diagonal = lines[is_diagonal]
    arcs = sketch.rows_of_kind(ARC)
    radii = np.array([abs(float(radius_of(sketch.of(part)[None])[0])) for part in arcs])
    for part in arcs.tolist():
        _hold_half_turn(sketch, part, detail)
    sketch.radii = [arcs[group] for group in groups(radii, detail) if len(group) > 1]


def _hold_half_turn(sketch: Sketch, part: int, detail: float) -> None:
    """Let an arc turn by exactly half if its ends are that near: no radius of a few decimals tells its centre else."""
    numbers, column = sketch.of(part), int(sketch.columns[part][4])
    off = (4.0 * np.arctan(abs(numbers[4])) - np.pi) * abs(radius_of(numbers[None])[0]) / 2.0
    if abs(off) <= SPREAD * detail:
        sketch.numbers[column] = np.sign(numbers[4])
        sketch.fixed.append(column)


def _pairs(values: Floats, columns: Integers, detail: float) -> list[list[int]]:
    """Return pairs of ``columns`` [K] whose ``values`` [K] are one."""
    return [
        [int(columns[group[0]]), int(columns[other])]
        for group in groups(values, detail)
        for other in group[1:].tolist()
    ]


def groups(values: Floats, detail: float) -> list[Integers]:
    """Return the indices of ``values`` [K] in groups that are one number each."""
    found: list[list[int]] = []
    for index in np.argsort(values, kind="stable").tolist():
        group = found[-1] if found else []
        near = group and values[index] - values[group[-1]] <= GAP * detail
        if near and values[index] - values[group[0]] <= SPREAD * detail:
            group.append(index)
        else:
            found.append([index])
    return [np.array(group) for group in found]
