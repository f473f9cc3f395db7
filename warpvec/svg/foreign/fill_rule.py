"""Turn a path under the even-odd rule into one of the same area under the non-zero rule, by reversing loops.

That is possible if its loops do not cross themselves or one another. Then the loops that an odd number of others
surround must run against those around them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from warpvec.svg.foreign.shapes import Loop, reversed_loop

_SAMPLES = 8
"""Straight pieces per cubic in which loops are compared. Loops that touch within a thousandth of a curve's size are not
told apart from those that cross."""

_PIECES_MAX = 3000
"""Largest number of straight pieces of a path that is examined: every piece is compared with every other one."""

Points = NDArray[np.float64]


def to_nonzero(loops: list[Loop]) -> tuple[list[Loop], bool]:
    """Return the loops of an even-odd path so that the non-zero rule fills the same area, and whether that is sure."""
    polygons = [_polygon(loop) for loop in loops]
    if len(loops) == 1 and len(loops[0].points) <= 6:
        return loops, True
    if sum(map(len, polygons)) > _PIECES_MAX or _crosses(polygons):
        return loops, False
    depths = [
        sum(_contains(outer, polygon[0]) for j, outer in enumerate(polygons) if j != i)
        for i, polygon in enumerate(polygons)
    ]
    oriented = [
        loop if (_area(polygon) > 0.0) == (depth % 2 == 0) else reversed_loop(loop)
        for loop, polygon, depth in zip(loops, polygons, depths, strict=True)
    ]
    return oriented, True


def _polygon(loop: Loop) -> Points:
    """Return points [K, 2] along the loop."""
    rows = loop.points.reshape(-1, 3, 2)
    ends = np.roll(rows[:, :1], -1, axis=0)
    curves = np.concatenate([rows, ends], 1)
    t = (np.arange(_SAMPLES) / _SAMPLES)[:, None]
    weights = np.hstack([(1 - t) ** 3, 3 * (1 - t) ** 2 * t, 3 * (1 - t) * t**2, t**3])
    points: Points = (weights @ curves).reshape(-1, 2)
    is_repeated = (points == np.roll(points, 1, axis=0)).all(1)
    return points[~is_repeated] if (~is_repeated).sum() > 2 else points


def _area(polygon: Points) -> float:
    x, y = polygon.T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1))


def _contains(polygon: Points, point: Points) -> bool:
    """Return whether ``point`` is inside, by the even-odd rule."""
    (x0, y0), (x1, y1) = polygon.T, np.roll(polygon, -1, axis=0).T
    spans = (y0 <= point[1]) != (y1 <= point[1])
    with np.errstate(all="ignore"):
        at = x0 + (x1 - x0) * ((point[1] - y0) / (y1 - y0))
    return bool((spans & (at > point[0])).sum() % 2)


def _crosses(polygons: list[Points]) -> bool:
    """Return whether two pieces that are not neighbours cross each other."""
    start = np.concatenate(polygons)
    end = np.concatenate([np.roll(polygon, -1, axis=0) for polygon in polygons])
    side_of_start = _side(start[:, None], end[:, None], start[None])  # [of edge, of point]
    side_of_end = _side(start[:, None], end[:, None], end[None])
    splits = side_of_start * side_of_end < 0.0
    return bool((splits & splits.T).any())


def _side(a: Points, b: Points, point: Points) -> Points:
    """Return the sign of the turn from a to b to ``point``; 0 for points on the line, up to rounding."""
    ab, ap = b - a, point - a
    turn = ab[..., 0] * ap[..., 1] - ab[..., 1] * ap[..., 0]
    bound = 1e-9 * (np.abs(ab[..., 0] * ap[..., 1]) + np.abs(ab[..., 1] * ap[..., 0]))
    signs: Points = np.where(np.abs(turn) <= bound, 0.0, np.sign(turn))
    return signs
