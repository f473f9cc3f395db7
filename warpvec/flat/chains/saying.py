"""Say chains as rows of lines and cubics, with their relations or without."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import torch

from warpvec.arrays import Floats, Integers, Mask
from warpvec.flat.chains.chain import Chain
from warpvec.flat.chains.choice import Part, numbers_of
from warpvec.flat.chains.folded import Words, hold_folds, image_of, unfolded, words_of
from warpvec.flat.chains.grid import HANDLE_ERROR, Grid, hold_grid
from warpvec.flat.chains.joined_ends import join_ends, with_met_ends
from warpvec.flat.chains.parts import LINE, rows_of
from warpvec.flat.chains.relations import find_relations
from warpvec.flat.chains.sketch import parted, sketch_of
from warpvec.flat.chains.solve import Sketch, solved
from warpvec.flat.chains.symmetry import Fold, folds_of
from warpvec.geometry.quarter import QUARTER_HANDLE
from warpvec.geometry.regrouping import with_loops
from warpvec.geometry.scene import Scene

LoopRows = tuple[Floats, Mask]
"""The rows [S, 3, 2] of a loop, and which are lines [S]."""

FIRST_ROUNDS = 3
"""Steps of solutions without relations: the first one is fitted to the picture, and others begin near their end."""

NEAR, NEAR_MIN, NEAR_MAX = 2.0, 0.05, 0.1
"""Moves of numbers that a relation may cause, in deviations of places, and bounds of them in pixels. The picture
judges afterwards."""

SIZE_MIN = 1e-6
"""Size of a curve in pixels below which it is a point."""


class Sheet(NamedTuple):
    """What chains have relations with, beside each other.

    Attributes:
        middle: of the canvas.
        widths: that of the stroke of each loop [L]; 0 for an outline.
        looks: the number of the look of each loop [L]: its paint and its width.
        fixed: points [K, 2] of outlines that stay.
        forms: the centre lines of stroked forms, by their loops.
    """

    middle: tuple[float, float]
    widths: Floats
    looks: Integers
    fixed: Floats
    forms: dict[int, Chain]


def move_allowed(spread: float) -> float:
    """Return by how many pixels numbers may move for a relation, in a drawing with this ``spread`` of its outlines."""
    return min(max(NEAR * spread, NEAR_MIN), NEAR_MAX)


class Sketched(NamedTuple):
    """Chains as a sketch.

    Attributes:
        sketch: the sketch.
        loops: the loop of each of its chains.
        folds: the folds of some of them, by their numbers.
        is_closed: whether each loop is closed.
    """

    sketch: Sketch
    loops: list[int]
    folds: dict[int, Fold]
    is_closed: dict[int, bool]

    def rows(self) -> dict[int, LoopRows]:
        """Return the rows of each loop as the sketch says them, also of mirror images."""
        sketch, rows = self.sketch, dict[int, LoopRows]()
        for number, loop in enumerate(self.loops):
            fold, is_open = self.folds.get(number), not self.is_closed[loop]
            has_half = fold is not None and fold.twin is None
            words = unfolded(sketch, number, fold) if fold and has_half else words_of(sketch, number)
            rows[loop] = _rows(words, is_open)
            if fold is not None and fold.twin is not None:
                place = float(sketch.numbers[sketch.axes[number]])
                rows[fold.twin] = _rows(image_of(words, fold.axis, place), is_open)
        return rows


def said_rows(
    chains: dict[int, Chain], spread: float, nats: float, sheet: Sheet | None = None, grid: Grid | None = None
) -> dict[int, LoopRows]:
    """Return the rows [S, 3, 2] of each of ``chains``, and which are lines [S]; as `sketched`.

    Numbers are put on the ``grid`` of the drawing; None for none.
    """
    if not chains:
        return {}
    found = sketched(chains, spread, nats, sheet)
    if grid is not None:
        hold_grid(found.sketch, grid)
    return found.rows()


def sketched(chains: dict[int, Chain], spread: float, nats: float, sheet: Sheet | None = None) -> Sketched:
    """Return ``chains`` as a solved sketch.

    Args:
        chains: the chains by their loops.
        spread: deviation of places in pixels.
        nats: of a number.
        sheet: what they are on; None for no relations.
    """
    if sheet is None:
        loops = list(chains)
        sketch = sketch_of([parted(chain, spread, nats) for chain in chains.values()], spread)
        solved(sketch, FIRST_ROUNDS)
        return Sketched(sketch, loops, {}, {loop: chain.is_closed for loop, chain in chains.items()})
    chains, move = with_met_ends(chains, sheet.widths, sheet.looks, sheet.forms), move_allowed(spread)
    folds = folds_of(chains, sheet.fixed, move)
    twins = {each[0].twin for each in folds.values()}
    loops = [loop for loop in chains if loop not in twins]
    found, chosen = list[tuple[Chain, list[Part]]](), {}
    for number, loop in enumerate(loops):
        halves = [fold.chain for fold in folds.get(loop, [])] or [chains[loop]]
        offers = [parted(each, spread, nats) for each in halves]
        best = min(range(len(offers)), key=lambda k: numbers_of(offers[k][1]))
        found.append(offers[best])
        if loop in folds:
            chosen[number] = folds[loop][best]
    sketch = sketch_of(found, spread)
    hold_folds(sketch, chosen, move, sheet.middle)
    join_ends(sketch)
    solved(sketch)
    find_relations(sketch, move)
    solved(sketch)
    return Sketched(sketch, loops, chosen, {loop: chain.is_closed for loop, chain in chains.items()})


def _rows(words: Words, is_open: bool) -> LoopRows:
    """Return the rows of the parts of a loop, and which are lines."""
    rows = [rows_of(*word) for word in words]
    is_line = [np.full(len(own), kind == LINE) for own, (kind, _) in zip(rows, words, strict=True)]
    if is_open:
        rows.append(np.repeat(words[-1][1][2:4][None, None], 3, 1))
        is_line.append(np.array([True]))
    return np.concatenate(rows), np.concatenate(is_line)


def has_size(rows: Floats, is_closed: bool) -> bool:
    """Return whether ``rows`` [S, 3, 2] show something: the numbers of a sliver may be nearly equal."""
    extent = np.ptp(rows, axis=(0, 1))
    return bool((extent.min() if is_closed else extent.max()) > HANDLE_ERROR)


def with_rows(scene: Scene, loops: dict[int, LoopRows]) -> Scene:
    """Return ``scene`` with other rows [S, 3, 2] for some loops, of which some are lines [S]."""
    return with_loops(
        scene, {loop: (torch.from_numpy(rows), torch.from_numpy(lines)) for loop, (rows, lines) in loops.items()}
    )


def are_curves(curves: Floats) -> Mask:
    """Return which of ``curves`` [S, 4, 2] are more than a point."""
    found: Mask = np.abs(np.diff(curves, axis=1)).max((1, 2), initial=0.0) > SIZE_MIN
    return found


def are_ellipse(curves: Floats) -> bool:
    """Return whether ``curves`` [S, 4, 2] are the quarters of an ellipse: the image of a circle's by a linear map."""
    if len(curves) != 4:
        return False
    center = curves[:, 0].mean(0)
    begin = curves[:, 0] - center
    end = np.roll(begin, -1, axis=0)
    exact = center + np.stack([begin, begin + QUARTER_HANDLE * end, end + QUARTER_HANDLE * begin, end], 1)
    off = max(np.abs(curves - exact).max(), np.abs(begin[:2] + begin[2:]).max())
    return bool(off <= HANDLE_ERROR)
