"""Dots: parts of ink that are hardly longer than wide."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats
from warpvec.flat.constants.lines import LINES
from warpvec.flat.lines.line import DrawnLine
from warpvec.flat.lines.local_skeleton import Grid
from warpvec.flat.strokes.line_fitting import Rows


def find_dots(grid: Grid, width: float) -> tuple[list[DrawnLine], Grid]:
    """Return the dots of the ink in ``grid``, and the ink without them. Most lines have the ``width`` in pixels."""
    labels, count = ndimage.label(grid.mask, np.ones((3, 3)))
    boxes = ndimage.find_objects(labels)
    areas = np.bincount(labels.ravel(), minlength=count + 1)[1:] / grid.scale**2
    dots, is_dot = [], np.zeros(count + 1, bool)
    for k, box in enumerate(boxes):
        side = max(part.stop - part.start for part in box)
        own = 2.0 * np.sqrt(areas[k] / np.pi)
        if side / grid.scale > LINES.dot_width * width or own > LINES.dot_width * width:
            continue
        inner = 2.0 * ndimage.distance_transform_edt(np.pad(labels[box] == k + 1, 1)).max() - 1.0
        if inner >= LINES.dot_share * side:
            rows, columns = np.nonzero(labels[box] == k + 1)
            cells = np.array([[rows.mean() + box[0].start, columns.mean() + box[1].start]])
            dots.append(dot(grid.places(cells)[0], own))
            is_dot[k + 1] = True
    return dots, grid._replace(mask=grid.mask & ~is_dot[labels])


def dot(place: Floats, width: float, color: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> DrawnLine:
    """Return a dot of a ``width`` at a ``place`` [2], in pixels: a short line with round caps."""
    half = np.array([LINES.dot / 2.0, 0.0])
    start, end = place - half, place + half
    control = np.array([[start, start + (end - start) / 3.0, start + (end - start) * 2.0 / 3.0], [end, end, end]])
    return DrawnLine(Rows(control, np.array([True, True]), True), width, is_dot=True, color=color)
