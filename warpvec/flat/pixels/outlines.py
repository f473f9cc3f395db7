"""Exact outlines of areas of whole pixels: a compound path of level and upright lines for each colour."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray

from warpvec.arrays import Floats, Integers, Mask
from warpvec.flat.pixels.cells import Cells
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure
from warpvec.geometry.walks import simple_walks

_RIGHT, _DOWN, _LEFT, _UP = range(4)
_STEPS = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])
"""Directions along the sides of pixels, as steps in x and y. A quarter turn to the right adds 1."""


def scene_of_cells(cells: Cells, is_opaque: bool) -> Scene:
    """Return the scene of ``cells``, in pixels: a path for each visible colour, the most frequent first.

    If the picture ``is_opaque``, the most frequent colour is the canvas, and has no path.
    """
    order = np.argsort(-cells.counts, kind="stable")
    ground = int(order[0]) if is_opaque else None
    shown = [int(color) for color in order if color != ground and cells.colors[color, 3] > 0]
    paths = [rectilinear_loops(cells.label == color) for color in shown]
    colors = cells.colors[shown].reshape(-1, 4) / 255.0
    segments = np.concatenate([np.zeros((0, 3, 2)), *(lines_through(loop) for path in paths for loop in path)])
    background = np.zeros(3) if ground is None else cells.colors[ground, :3] / 255.0
    return Scene(
        torch.from_numpy(segments).float(),
        Structure.of_loops([list(map(len, path)) for path in paths], torch.ones(len(segments), dtype=torch.bool)),
        color=torch.from_numpy(np.ascontiguousarray(colors[:, :3])).float(),
        opacity=torch.from_numpy(np.ascontiguousarray(colors[:, 3])).float(),
        background=torch.from_numpy(background).float(),
        generation=torch.arange(len(shown)),
        transparent=ground is None,
    )


class Touching(NamedTuple):
    """Corners of pixels [h + 1, w + 1] that outlines may pass twice, and those of them where pixels are joined."""

    is_double: Mask
    is_joined: Mask


def rectilinear_loops(mask: Mask, touching: Touching | None = None) -> list[Integers]:
    """Return the corners [n, 2], as x and y, of the closed outlines of ``mask`` [h, w].

    Outlines run clockwise on a page, holes the other way. Pixels that touch at a corner only are apart, and no outline
    passes a corner twice, unless ``touching`` says so.
    """
    height, width = mask.shape
    touching = touching or Touching(*np.zeros((2, height + 1, width + 1), bool))
    sides = _sides(mask)
    directions = np.zeros((height + 1, width + 1, 4), bool)  # sides that begin at a corner of pixels, by direction
    for direction, (rows, columns) in enumerate(sides):
        directions[rows, columns, direction] = True
    loops: list[Integers] = []
    for row, column in zip(*np.nonzero(directions[..., _RIGHT]), strict=True):
        if directions[row, column, _RIGHT]:
            corners = _walked(directions, touching.is_joined, int(column), int(row))
            keys = [(x, y, k * touching.is_double[y, x]) for k, (x, y) in enumerate(corners.tolist(), 1)]
            loops += [corners[walk] for walk in simple_walks(keys)]
    return loops


def _sides(mask: Mask) -> list[tuple[NDArray[np.intp], NDArray[np.intp]]]:
    """Return the rows and columns of the corners at which sides of ``mask`` [h, w] begin, for each direction.

    The mask lies to the right of its sides: a top side runs to the right, a right side down.
    """
    padded = np.pad(mask, 1)
    inside = padded[1:-1, 1:-1]
    beside = (padded[:-2, 1:-1], padded[1:-1, 2:], padded[2:, 1:-1], padded[1:-1, :-2])
    begins = ((0, 0), (0, 1), (1, 1), (1, 0))  # corner of a pixel, clockwise, as row and column
    found: list[tuple[NDArray[np.intp], NDArray[np.intp]]] = []
    for other, (down, across) in zip(beside, begins, strict=True):
        rows, columns = np.nonzero(inside & ~other)
        found.append((rows + down, columns + across))
    return found


def _walked(directions: Mask, is_joined: Mask, x: int, y: int) -> Integers:
    """Return the corners [n, 2] of the outline that runs right from (x, y), and take its sides out of ``directions``.

    Where two outlines touch, it turns right, so that each stays around its own pixels; left if these are joined.
    """
    corners: list[tuple[int, int]] = []
    heading = last = _RIGHT
    directions[y, x, heading] = False
    first = (x, y)
    while True:
        x, y = x + int(_STEPS[heading, 0]), y + int(_STEPS[heading, 1])
        turns = (3, 0, 1) if is_joined[y, x] else (1, 0, 3)  # right is 1, straight on 0, left 3
        if (x, y) == first and not directions[y, x, (heading + turns[0]) % 4]:
            break
        for turn in turns:
            if directions[y, x, (heading + turn) % 4]:
                heading = (heading + turn) % 4
                break
        directions[y, x, heading] = False
        if heading != last:
            corners.append((x, y))
            last = heading
    return np.array(([first] if heading != _RIGHT else []) + corners, np.int64)


def lines_through(corners: Integers | Floats) -> Floats:
    """Return the rows [n, 3, 2] of a closed loop of lines through ``corners`` [n, 2]."""
    start = corners.astype(np.float64)
    step = np.roll(start, -1, axis=0) - start
    return np.stack([start, start + step / 3.0, start + step * (2.0 / 3.0)], 1)
