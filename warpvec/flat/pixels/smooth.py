"""Pixel art as the curves that its pixels mean. Source: Kopf and Lischinski, Depixelizing Pixel Art, 2011.

Where pixels of two colours meet, a line runs along their sides. Its curve is the quadratic spline whose control points
are the corners of pixels, said by few lines and cubics. It is found once, for the colours on both of its sides, so that
no gap shows. Two pixels that touch by a corner alone may be meant as one stroke. Then their corner becomes two points,
a quarter of a pixel to each side.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import torch
from scipy import ndimage

from warpvec.arrays import Floats, Integers, Mask, counted
from warpvec.flat.constants.mono import MONO
from warpvec.flat.pixels.cells import Cells
from warpvec.flat.pixels.outlines import Touching, rectilinear_loops
from warpvec.flat.pixels.touching import APART, FALLING, RISING, joined_corners
from warpvec.flat.staircases import square_corners
from warpvec.flat.strokes.line_fitting import Line, curves_of, fit_line
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure

_SPLIT = 0.25
"""Distance along each axis, in pixels, of the two points of a corner at which two pixels are one stroke."""

_SAMPLES = 4
"""Points of each piece of a spline that the fit gets."""

_SPREAD = 0.024
"""Deviation of the places of a spline in pixels. Curves are off by five deviations at most: the spline of a slope of
one pixel in two is 0.1 from its line."""

_FITTED_MIN, _FITTED_MAX = 16, 96
"""Fewest and most nodes of the cubics by which a spline is drawn first."""


class _Side(NamedTuple):
    """Where a side between two pixels lies: its chain, the number in it, and whether the chain runs that way."""

    chain: int
    number: int
    is_forward: bool


class _Corners(NamedTuple):
    """The corners of pixels [h + 1, w + 1].

    Attributes:
        joins: which diagonal is one stroke, as of `joined_corners`; ``APART`` along the border.
        degree: how many sides between colours meet there.
        is_sharp: which must stay corners.
    """

    joins: Integers
    degree: Integers
    is_sharp: Mask

    def is_end(self, x: int, y: int) -> bool:
        """Return whether chains end at a corner."""
        return bool(self.joins[y, x] == APART and self.degree[y, x] != 2)


def smooth_scene(cells: Cells, is_opaque: bool) -> Scene:
    """Return the scene of smooth outlines of ``cells``, in pixels: a path for each colour, the most frequent first.

    Each goes on beneath those above it. If the picture ``is_opaque``, the most frequent colour is the canvas.
    """
    order = np.argsort(-cells.counts, kind="stable")
    is_shown = cells.colors[order, 3] > 0
    is_shown[0] &= not is_opaque
    corners = _corners_of(cells.label)
    masks = [_with_what_lies_above(cells, order, rank) for rank in np.flatnonzero(is_shown).tolist()]
    outlines = [rectilinear_loops(mask, Touching(corners.joins != APART, _is_joined(mask, corners))) for mask in masks]
    fitter = _Chains(corners, [loop for path in outlines for loop in path])
    paths = [[fitter.rows_of(loop) for loop in path] for path in outlines]
    loops = [loop for path in paths for loop in path]
    colors = torch.from_numpy(cells.colors[order[is_shown]].reshape(-1, 4) / 255.0).float()
    lines = torch.from_numpy(np.concatenate([np.zeros(0, bool), *(is_line for _, is_line in loops)]))
    ground = cells.colors[order[0], :3] / 255.0 if is_opaque else np.zeros(3)
    return Scene(
        torch.from_numpy(np.concatenate([np.zeros((0, 3, 2)), *(rows for rows, _ in loops)])).float(),
        Structure.of_loops([[len(rows) for rows, _ in path] for path in paths], lines),
        color=colors[:, :3].contiguous(), opacity=colors[:, 3].contiguous(),
        background=torch.from_numpy(ground).float(), generation=torch.arange(len(paths)), transparent=not is_opaque,
    )  # fmt: skip


def _corners_of(label: Integers) -> _Corners:
    padded = np.pad(label + 1, 1)
    level, upright = padded[1:] != padded[:-1], padded[:, 1:] != padded[:, :-1]
    degree = (level[:, 1:].astype(np.int64) + level[:, :-1] + upright[1:] + upright[:-1]).astype(np.int64)
    is_sharp = np.zeros(degree.shape, bool)
    for color in range(int(label.max()) + 1):
        is_sharp |= square_corners(label == color)
    is_sharp[[0, -1]] = is_sharp[:, [0, -1]] = True
    return _Corners(np.pad(joined_corners(label), 1), degree, is_sharp)


def _with_what_lies_above(cells: Cells, order: Integers, rank: int) -> Mask:
    """Return the pixels [h, w] of the colour of a ``rank``, with those of rarer opaque colours that touch it."""
    ranks = np.argsort(order)[cells.label]
    is_own = np.asarray(ranks == rank)
    if cells.colors[order[rank], 3] < 255:
        return is_own
    areas, _ = ndimage.label(is_own | ((ranks > rank) & (cells.colors[cells.label, 3] == 255)))
    return np.isin(areas, np.unique(areas[is_own]))


def _is_joined(mask: Mask, corners: _Corners) -> Mask:
    """Return the corners [h + 1, w + 1] at which two pixels of ``mask`` [h, w], and no others, are one stroke."""
    a, b, c, d = mask[:-1, :-1], mask[:-1, 1:], mask[1:, :-1], mask[1:, 1:]
    joins = corners.joins[1:-1, 1:-1]
    is_joined = (a & d & ~b & ~c & (joins == FALLING)) | (b & c & ~a & ~d & (joins == RISING))
    return np.pad(is_joined, 1)


class _Chains:
    """The lines between colours, from one place where they meet to the next: each is fitted once."""

    def __init__(self, corners: _Corners, loops: list[Integers]) -> None:
        self._corners = corners
        self._known: dict[tuple[tuple[int, int], tuple[int, int]], _Side] = {}
        self._rows: list[tuple[Floats, Mask, int]] = []  # curves, which are lines, and the number of sides
        for loop in map(_unit_steps, loops):
            ends = [k for k, (x, y) in enumerate(loop.tolist()) if corners.is_end(x, y)]
            for start, stop in zip(ends, [*ends[1:], *(end + len(loop) for end in ends[:1])], strict=True):
                self._add(loop.take(np.arange(start, stop + 1), 0, mode="wrap"), is_closed=False)
            if not ends:
                self._add(loop, is_closed=True)

    def rows_of(self, corners: Integers) -> tuple[Floats, Mask]:
        """Return the rows [n, 3, 2] of the smooth outline along ``corners``, and which are lines [n]."""
        loop = _unit_steps(corners)
        sides = [self._known[key] for key in _keys(loop, is_closed=True)]
        parts = []
        for side in sides:
            curves, is_line, count = self._rows[side.chain]
            if side.number == (0 if side.is_forward else count - 1):
                parts.append((curves, is_line) if side.is_forward else (curves[::-1, ::-1], is_line[::-1]))
        return np.concatenate([curves[:, :3] for curves, _ in parts]), np.concatenate([lines for _, lines in parts])

    def _add(self, chain: Integers, *, is_closed: bool) -> None:
        keys = _keys(chain, is_closed=is_closed)
        if keys[0] in self._known:
            return
        for number, (start, end) in enumerate(keys):
            self._known[start, end] = _Side(len(self._rows), number, True)
            self._known[end, start] = _Side(len(self._rows), number, False)
        points = MONO.staircase_scale * self._spline(chain, is_closed)
        count = min(max(2 * len(chain), _FITTED_MIN), _FITTED_MAX)  # a feature of a pixel must not be passed over
        spread = MONO.staircase_scale * _SPREAD
        rows = fit_line(Line(points, is_closed), MONO.staircase_scale, spread, count)
        curves = curves_of(rows) / MONO.staircase_scale
        self._rows.append((curves, rows.is_line[: len(curves)], len(keys)))

    def _spline(self, chain: Integers, is_closed: bool) -> Floats:
        """Return points [n, 2] of the quadratic spline along a ``chain`` [m, 2] of corners; sharp ones stay."""
        before, after = np.roll(chain, 1, axis=0) - chain, np.roll(chain, -1, axis=0) - chain
        column, row = chain.T
        is_split = self._corners.joins[row, column] != APART
        # Where two pixels are joined, the line keeps to the outside of its turn.
        control = chain + np.where(is_split[:, None], _SPLIT * (before + after), 0.0)
        is_sharp = self._corners.is_sharp[row, column] & ~is_split
        start, end = (control + np.roll(control, 1, axis=0)) / 2.0, (control + np.roll(control, -1, axis=0)) / 2.0
        t = np.arange(_SAMPLES)[:, None, None] / _SAMPLES
        curve = (1 - t) ** 2 * start + 2 * t * (1 - t) * control + t**2 * end
        sharp = np.where(t < 0.5, start + 2 * t * (control - start), control + (2 * t - 1) * (end - control))
        points: Floats = np.where(is_sharp[:, None], sharp, curve).swapaxes(0, 1)
        if is_closed:
            return points.reshape(-1, 2)
        return np.concatenate([control[:1], points[1:-1].reshape(-1, 2), end[-2:-1], control[-1:]])


def _unit_steps(corners: Integers) -> Integers:
    """Return all corners of pixels [n, 2] along a closed outline with ``corners`` [m, 2]."""
    steps = np.roll(corners, -1, axis=0) - corners
    counts = np.abs(steps).max(1)
    owner = np.repeat(np.arange(len(corners)), counts)
    along = counted(counts)
    found: Integers = corners[owner] + along[:, None] * np.sign(steps)[owner]
    return found


def _keys(chain: Integers, *, is_closed: bool) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    """Return the start and end of each step of a ``chain`` [n, 2]."""
    places = list(map(tuple, chain.tolist()))
    return list(zip(places, [*places[1:], *places[:1]], strict=True))[: len(places) - (not is_closed)]
