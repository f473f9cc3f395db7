"""Ask about loops through the polygons that they are close to."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from warpvec.svg.foreign.shapes import Loop, curves_of

_SAMPLES = 8
"""Straight pieces per cubic in which loops are compared. Loops that come closer than a thousandth of a curve's size
count as crossing."""

_CHUNK = 2**20
"""Pairs of pieces that are compared at a time: some 50 MB."""

Points = NDArray[np.float64]


def polygon_of(loop: Loop) -> Points:
    """Return points [K, 2] along the loop, without repeated ones."""
    t = (np.arange(_SAMPLES) / _SAMPLES)[:, None]
    weights = np.hstack([(1 - t) ** 3, 3 * (1 - t) ** 2 * t, 3 * (1 - t) * t**2, t**3])
    places = weights @ curves_of(loop)
    is_inner = np.arange(_SAMPLES) > 0
    kept = ~(loop.is_line[:, None] & is_inner)  # a line is one piece
    points: Points = places[kept]
    is_repeated = (points == np.roll(points, 1, axis=0)).all(1)
    return points[~is_repeated] if (~is_repeated).sum() > 2 else points


def area(polygon: Points) -> float:
    """Return twice the area, positive if the polygon runs clockwise on the screen."""
    x, y = polygon.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def winding(polygon: Points, point: Points) -> int:
    """Return how often ``polygon`` runs around ``point`` [2]."""
    return int(windings([polygon], point[None])[0])


def windings(polygons: list[Points], points: Points) -> NDArray[np.int64]:
    """Return how often ``polygons`` together run around each of ``points`` [P, 2]."""
    start, end = _edges(polygons)
    (x0, y0), (x1, y1) = (np.moveaxis(ends - points[:, None], -1, 0) for ends in (start, end))
    side = x0 * y1 - x1 * y0
    turns: NDArray[np.int64] = ((y0 <= 0) & (y1 > 0) & (side > 0)).sum(1) - ((y0 > 0) & (y1 <= 0) & (side < 0)).sum(1)
    return turns


def distance(polygon: Points, point: Points) -> float:
    """Return the distance of ``point`` from the edges of ``polygon``."""
    along, away = np.roll(polygon, -1, axis=0) - polygon, point - polygon
    length = (along**2).sum(1)
    share = np.clip((away * along).sum(1) / np.where(length > 0.0, length, 1.0), 0.0, 1.0)
    return float(np.hypot(*(away - share[:, None] * along).T).min())


def crossing_count(polygons: list[Points]) -> int:
    """Return how many pairs of edges cross. Those that only touch do not count."""
    start, end = _edges(polygons)
    rows = max(_CHUNK // len(start), 1)
    count = 0
    for first in range(0, len(start), rows):
        a, b = start[first : first + rows, None], end[first : first + rows, None]
        splits = _side(a, b, start[None]) * _side(a, b, end[None]) < 0.0
        is_split = _side(start[None], end[None], a) * _side(start[None], end[None], b) < 0.0
        count += int((splits & is_split).sum())
    return count // 2


def _edges(polygons: list[Points]) -> tuple[Points, Points]:
    """Return the starts and the ends of all edges [K, 2]."""
    return np.concatenate(polygons), np.concatenate([np.roll(polygon, -1, axis=0) for polygon in polygons])


def _side(a: Points, b: Points, point: Points) -> Points:
    """Return the sign of the turn from a to b to ``point``; 0 for points on the line, up to rounding."""
    ab, ap = b - a, point - a
    one, two = ab[..., 0] * ap[..., 1], ab[..., 1] * ap[..., 0]
    turn = one - two
    signs: Points = np.where(np.abs(turn) <= 1e-9 * (np.abs(one) + np.abs(two)), 0.0, np.sign(turn))
    return signs
