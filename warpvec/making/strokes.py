"""The area of a stroke, whose edges are as far from the centre line as they should be.

Shapely's own buffers leave points of a line out that are within a hundredth of the distance, so that arcs are none.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import shapely
from shapely.geometry.base import BaseGeometry

from warpvec.arrays import Floats
from warpvec.making.curves import Piece, cubic_at
from warpvec.making.parts import Circle, Ellipse, Outline, Shape, Stroke

_STEP = 0.05
"""Most radians of a chord: edges are 0.003 mm off at a radius of 10 mm."""

_GRID = 1e-6
"""Distance in millimetres of coordinates, so that parts that touch have no gaps between them."""


def stroke_region(shape: Shape, stroke: Stroke, error: float) -> BaseGeometry:
    """Return the area of the stroke of one line, whose chords along it are at most ``error`` off."""
    half, is_closed = stroke.width / 2.0, not isinstance(shape, Outline) or shape.is_closed
    lines = [line for line in _lines(shape, error) if len(line[0]) > 1]
    if not lines:
        return _dot(shape, stroke)
    quads = np.concatenate([_quads(points, sides * half) for points, sides in lines])
    strips = shapely.polygons(quads)
    parts: list[BaseGeometry] = np.where(shapely.is_valid(strips), strips, shapely.convex_hull(strips)).tolist()
    meeting = list(pairwise(lines)) + ([(lines[-1], lines[0])] if is_closed else [])
    for (_, before), (points, after) in meeting:
        parts += _join(points[0], before[-1], after[0], stroke)
    if not is_closed:
        parts += _cap(lines[0][0][0], -lines[0][1][0], stroke) + _cap(lines[-1][0][-1], lines[-1][1][-1], stroke)
    return shapely.union_all(parts, grid_size=_GRID)


def _dot(shape: Shape, stroke: Stroke) -> BaseGeometry:
    assert isinstance(shape, Outline)
    (x, y), half = shape.pieces[0].points[0].tolist(), stroke.width / 2.0
    if stroke.cap == "square":
        return shapely.box(x - half, y - half, x + half, y + half)
    return shapely.Polygon(Circle(x, y, half).chords(half * _STEP**2 / 8.0))


def _lines(shape: Shape, error: float) -> Iterator[tuple[Floats, Floats]]:
    """Yield points [K, 2] along each piece of a line, with its end, and the unit vectors [K, 2] to its left there."""
    if isinstance(shape, Outline):
        for piece in shape.pieces:
            if piece.length or piece.is_cubic:
                yield _piece_line(piece, error)
        return
    points = shape.chords(error)
    if isinstance(shape, Circle):
        sides = (points - (shape.x, shape.y)) / shape.radius * -shape.turn
    else:
        sides = _ellipse_sides(shape, points)
    yield np.concatenate([points, points[:1]]), np.concatenate([sides, sides[:1]])


def _ellipse_sides(ellipse: Ellipse, points: Floats) -> Floats:
    u = np.array(ellipse.axis) / ellipse.first
    v = np.array([-u[1], u[0]])
    away = points - (ellipse.x, ellipse.y)
    slope = np.outer(away @ u / ellipse.first**2, u) + np.outer(away @ v / ellipse.second**2, v)
    sides: Floats = -slope / np.hypot(*slope.T)[:, None]
    return sides


def _piece_line(piece: Piece, error: float) -> tuple[Floats, Floats]:
    if piece.is_cubic:
        return _cubic_line(piece.points, len(piece.chords(error)))
    ends = piece.points
    if not piece.bulge:
        along = (ends[1] - ends[0]) / piece.length
        return ends, np.repeat([[-along[1], along[0]]], 2, 0)
    points = np.concatenate([piece.chords(error), ends[-1:]])
    x, y, radius = piece.circle
    return points, (points - (x, y)) / radius * -math.copysign(1.0, piece.bulge)


def _cubic_line(cubic: Floats, count: int) -> tuple[Floats, Floats]:
    legs = np.diff(cubic, axis=0)
    legs = legs[np.hypot(*legs.T) > 0.0]
    if not len(legs):
        return cubic[:1], cubic[:1]
    angles = np.arctan2(legs[:, 1], legs[:, 0])
    turn = np.abs((np.diff(angles) + math.pi) % (2.0 * math.pi) - math.pi).sum()
    t = np.linspace(0.0, 1.0, max(count, math.ceil(float(turn) / _STEP)) + 1)
    points = cubic_at(cubic, t)
    points[-1] = cubic[3]
    first, second, third = np.diff(cubic, axis=0)
    along = np.outer((1 - t) ** 2, first) + np.outer(2 * (1 - t) * t, second) + np.outer(t**2, third)
    along[0], along[-1] = legs[0], legs[-1]  # handles may have no length
    size = np.hypot(*along.T)
    still = size <= 1e-9 * size.max()
    along[still] = legs[0]
    along /= np.hypot(*along.T)[:, None]
    return points, np.stack([-along[:, 1], along[:, 0]], 1)


def _quads(points: Floats, sides: Floats) -> Floats:
    """Return the strip along each chord [K - 1, 6, 2]; points of the line are in it, so that strips share all ends."""
    left, right = points + sides, points - sides
    return np.stack([right[:-1], points[:-1], left[:-1], left[1:], points[1:], right[1:]], 1)


def _join(point: Floats, before: Floats, after: Floats, stroke: Stroke) -> list[BaseGeometry]:
    """Return what fills the outer side of a corner between sides [2] before and after it."""
    half = stroke.width / 2.0
    turn = float(before[0] * after[1] - before[1] * after[0])
    cosine = float(before @ after)
    if cosine > 0.0 and abs(turn) < 1e-9:
        return []
    outer = -math.copysign(half, turn)
    first, last = point + outer * before, point + outer * after
    if stroke.join == "round":
        return [shapely.Polygon([point, *_fan(point, outer * before, math.atan2(turn, cosine))[:-1], last])]
    # The tip of a miter is 1 / sin(angle / 2) half widths away.
    if stroke.join == "miter" and 1.0 + cosine > 0.0 and math.sqrt(2.0 / (1.0 + cosine)) <= stroke.miter_limit:
        return [shapely.Polygon([point, first, point + outer * (before + after) / (1.0 + cosine), last])]
    return [shapely.Polygon([point, first, last])] if turn else []


def _cap(point: Floats, side: Floats, stroke: Stroke) -> list[BaseGeometry]:
    """Return the cap of a line that ends at ``point``, with ``side`` [2] to its left."""
    half = stroke.width / 2.0
    left, right, along = point + half * side, point - half * side, half * np.array([side[1], -side[0]])
    if stroke.cap == "square":
        return [shapely.Polygon([point, left, left + along, right + along, right])]
    if stroke.cap == "round":
        return [shapely.Polygon([point, left, *_fan(point, half * side, -math.pi)[1:-1], right])]
    return []


def _fan(center: Floats, start: Floats, turn: float) -> Floats:
    """Return points [K, 2] on a circle from ``center + start`` on."""
    angles = math.atan2(start[1], start[0]) + np.linspace(0.0, turn, 2 + math.ceil(abs(turn) / _STEP))
    return center + float(np.hypot(*start)) * np.stack([np.cos(angles), np.sin(angles)], 1)
