"""The skeleton of ink whose lines may have different widths, on a grid finer or coarser than the picture."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warpvec.arrays import Floats, Integers, Mask, counted
from warpvec.flat.constants.lines import LINES
from warpvec.flat.simplification.outline_samples import cubic_points
from warpvec.flat.strokes.skeleton import Graph, graph_of
from warpvec.flat.strokes.thinning import thinned

_CURVE_SAMPLES = 8
"""Lines that stand for a curve where the grid is filled."""


class Grid(NamedTuple):
    """A grid over a picture.

    Attributes:
        mask: the cells whose centres have ink [rows, columns].
        origin: of the grid [2] in pixels of the picture.
        scale: cells per pixel.
    """

    mask: Mask
    origin: Floats
    scale: float

    def places(self, cells: Floats) -> Floats:
        """Return the centres [K, 2] px of ``cells`` [K, 2], rows and columns."""
        found: Floats = (cells[:, ::-1] + 0.5) / self.scale + self.origin
        return found

    def cells(self, places: Floats) -> Integers:
        """Return rows and columns [K, 2] of the cells at ``places`` [K, 2] px."""
        found = np.floor((places - self.origin) * self.scale).astype(np.int64)[:, ::-1]
        return found.clip(0, np.array(self.mask.shape) - 1)


def filled_grid(control: Floats, loop: Integers, width: float) -> Grid:
    """Return the grid of ink with lines of ``width`` px inside of cubics ``control`` [R, 4, 2], of ``loop`` [R]."""
    scale = float(np.clip(LINES.cells / width, LINES.scale_min, LINES.scale_max))
    low, high = control.min((0, 1)) - 2.0 / scale, control.max((0, 1)) + 2.0 / scale
    columns, rows = np.ceil((high - low) * scale).astype(int) + 1
    start = cubic_points(control, np.arange(_CURVE_SAMPLES) / _CURVE_SAMPLES).reshape(-1, 2)
    row_loop = np.repeat(loop, _CURVE_SAMPLES)
    first = np.flatnonzero(np.append(True, row_loop[1:] != row_loop[:-1]))
    after = np.arange(1, len(start) + 1)
    after[np.append(first[1:], len(start)) - 1] = first
    lines = ((np.stack([start, start[after]], 1) - low) * scale) - 0.5
    return Grid(_filled(lines, int(rows), int(columns)), low, scale)


def _filled(lines: Floats, rows: int, columns: int) -> Mask:
    """Return the cells inside of the polygons of ``lines`` [K, 2, 2], whose coordinates are those of cell centres."""
    low, high = lines[..., 1].min(1), lines[..., 1].max(1)
    first, stop = np.ceil(low).astype(np.int64), np.ceil(high).astype(np.int64)
    counts = np.maximum(stop - first, 0)
    owner = np.repeat(np.arange(len(lines)), counts)
    row = first[owner] + counted(counts)
    (x, y), (right, down) = lines[owner, 0].T, lines[owner, 1].T
    column = np.ceil(x + (row - y) / (down - y) * (right - x)).astype(np.int64).clip(0, columns)
    flips = np.bincount(row * (columns + 1) + column, minlength=rows * (columns + 1)).reshape(rows, -1)
    return (np.cumsum(flips[:, :-1], 1) & 1).astype(bool)


def skeleton_of(grid: Grid) -> tuple[Graph, list[Floats], Floats]:
    """Return the skeleton of a grid, the places along its branches [M, 2] px, and its junctions [J, 2] px."""
    graph = graph_of(thinned(grid.mask))
    return graph, [grid.places(branch.astype(np.float64)) for branch in graph.branches], grid.places(graph.junctions)
