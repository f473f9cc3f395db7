"""Marks beside the drawing: for laying sheets on each other, for weeding, and for checking the size."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from warpvec.making.curves import Piece
from warpvec.making.parts import Circle, Outline, Part, Shape, Sheet, Stroke

MARKS = "marks"
"""Name of their layer."""

_LINE = Stroke(0.1, "butt", "miter", 4.0)

_RADIUS = 2.5
"""Radius in millimetres of a registration mark, whose cross is twice as wide."""

_GAP = 2.0
"""Distance in millimetres of marks from the drawing and from the edge."""

SQUARE = 20.0
"""Side of the square in millimetres by which the size is checked with a ruler."""


def with_marks(sheet: Sheet, registration: bool, weeding: bool, size_check: bool) -> Sheet:
    """Return ``sheet`` with a margin that holds the marks that are asked for.

    Args:
        sheet: the drawing.
        registration: three circles with a cross, in the corners but the lower right one, which tells how it lies.
        weeding: a rectangle around the drawing.
        size_check: a square of 20 mm below the drawing.
    """
    if not (registration or weeding or size_check):
        return sheet
    margin = 4.0 * _RADIUS + 2.0 * _GAP if registration else 2.0 * _GAP
    below = SQUARE + 2.0 * _GAP if size_check else 0.0
    width, height = sheet.width + 2.0 * margin, sheet.height + 2.0 * margin
    shapes: list[Shape] = []
    if weeding:
        shapes.append(_rect(margin - _GAP, margin - _GAP, sheet.width + 2.0 * _GAP, sheet.height + 2.0 * _GAP))
    if registration:
        near = _GAP + 2.0 * _RADIUS
        for x, y in ((near, near), (width - near, near), (near, height - near)):
            shapes += [Circle(x, y, _RADIUS), _line(x - 2 * _RADIUS, y, x + 2 * _RADIUS, y)]
            shapes.append(_line(x, y - 2 * _RADIUS, x, y + 2 * _RADIUS))
    if size_check:
        shapes.append(_rect(margin, height, SQUARE, SQUARE))
    moved = tuple(part.mapped(lambda shape: shape.moved(margin, margin)) for part in sheet.parts)
    marks = Part("#000000", tuple(shapes), _LINE, layer=MARKS)
    return replace(sheet, parts=(*moved, marks), width=max(width, margin + SQUARE + _GAP), height=height + below)


def _rect(x: float, y: float, width: float, height: float) -> Outline:
    corners = np.array([[x, y], [x + width, y], [x + width, y + height], [x, y + height]])
    sides = zip(corners, np.roll(corners, -1, axis=0), strict=True)
    return Outline(tuple(Piece(np.stack(side)) for side in sides), True)


def _line(x: float, y: float, to_x: float, to_y: float) -> Outline:
    return Outline((Piece(np.array([[x, y], [to_x, to_y]])),), False)
