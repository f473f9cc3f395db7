"""Areas of ink that are wider than a line: their outlines are drawn instead."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats, Mask
from warpvec.flat.constants.lines import LINES
from warpvec.flat.lines.local_skeleton import Grid
from warpvec.flat.strokes.line_fitting import Line


class WideAreas(NamedTuple):
    """The wide areas of ink.

    Attributes:
        number: how many there are.
        outlines: closed lines half a line width inside of their edges.
        rest: the ink without them.
        hidden: the grid of what lies inside of these outlines' ink.
    """

    number: int
    outlines: list[Line]
    rest: Grid
    hidden: Grid


def find_wide_areas(grid: Grid, width: float) -> WideAreas:
    """Return the areas of the ink in ``grid`` in which a disk of several line ``width`` px fits, and that are no lines.

    A bold line is as long as several of its disks.
    """
    reach = LINES.wide_radius * width * grid.scale
    depth = ndimage.distance_transform_edt(np.pad(grid.mask, 1))[1:-1, 1:-1]
    core = depth > reach
    if not core.any():
        return WideAreas(0, [], grid, grid._replace(mask=core))
    opened = ndimage.distance_transform_edt(~core) <= reach
    labels, count = ndimage.label(opened, np.ones((3, 3)))
    areas = np.bincount(labels.ravel(), minlength=count + 1)
    deepest = ndimage.maximum(depth, labels, np.arange(count + 1))
    is_wide = areas <= LINES.wide_disks * np.pi * np.square(deepest)
    is_wide[0] = False
    wide = is_wide[labels]
    inside = ndimage.distance_transform_edt(np.pad(wide, 1))[1:-1, 1:-1]
    half = width * grid.scale / 2.0
    outlines = _contours(inside, half, grid)
    hidden = grid._replace(mask=inside > 2.0 * half)
    return WideAreas(int(is_wide.sum()), outlines, grid._replace(mask=grid.mask & ~wide), hidden)


def _contours(depth: Floats, level: float, grid: Grid) -> list[Line]:
    """Return the closed lines along which ``depth`` [rows, columns] has a ``level``."""
    from contourpy import contour_generator

    # A cell's distance from the nearest one outside is half a cell more than that from the edge.
    lines: list[Any] = list(contour_generator(z=depth).lines(level + 0.5))
    return [Line(grid.places(line[:-1, ::-1]), True) for line in lines if len(line) > LINES.outline_points]


def without(image: Floats, hidden: Grid) -> Floats:
    """Return ``image`` [h, w] in [0, 1] with paper in place of the ``hidden`` ink."""
    if not hidden.mask.any():
        return image
    rows, columns = np.indices(image.shape)
    places: Floats = np.stack([columns, rows], -1).reshape(-1, 2).astype(np.float64) + 0.5
    cells = hidden.cells(places)
    found: Mask = hidden.mask[cells[:, 0], cells[:, 1]].reshape(image.shape)
    return np.where(found, 1.0, image)
