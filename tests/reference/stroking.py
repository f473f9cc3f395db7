"""The outline of a stroke as polygons: plain torch, differentiated by autograd, with complex numbers as points.

A point x + iy is turned from x to y by a positive angle. The kernels use vectors and their own derivatives.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import torch
from torch import Tensor

from warpvec.geometry.strokes import BEVEL, BUTT, MITER, ROUND, SQUARE
from warpvec.kernels.constants import CHORD_TOLERANCE


class Look(NamedTuple):
    """Width in pixels, cap, join and miter limit of a stroke."""

    width: Tensor
    cap: int
    join: int
    miter_limit: float


def stroke_polygons(rows: Tensor, is_open: bool, look: Look, chords: list[int]) -> list[Tensor]:
    """Return the closed polygons [V, 2] of one loop of a stroke; one if it is open, two if it is closed.

    Args:
        rows: control points [S, 3, 2] of its rows; the last row of an open loop is its end.
        is_open, look: how it is stroked.
        chords: chords on each side of each row, but for the end of an open loop.
    """
    p = torch.view_as_complex(rows.contiguous())
    ends = torch.cat([p[1:, 0], p[:1, 0]])
    count = len(rows) - 1 if is_open else len(rows)
    curves = [torch.cat([p[row], ends[row : row + 1]]) for row in range(count)]
    left, right = [], []
    for row, curve in enumerate(curves):
        if row or not is_open:
            on_left, on_right = _join(curves[row - 1], curve, look)
            left += on_left
            right += on_right
        points, normals = _side(curve, chords[row])
        left += list(_moved_out(points + look.width / 2 * normals))
        right += list(_moved_out(points - look.width / 2 * normals))
    if not is_open:
        return [_polygon(left), _polygon(right[::-1])]
    end, start = _cap(curves[-1], look, True), _cap(curves[0], look, False)
    return [_polygon([*left, *end, *right[::-1], *start])]


def _polygon(points: list[Tensor]) -> Tensor:
    return torch.view_as_real(torch.stack(points))


def _side(curve: Tensor, count: int) -> tuple[Tensor, Tensor]:
    """Return the points of a curve [n + 1] at equal steps of t, and its unit normals there."""
    t = torch.arange(count + 1, dtype=torch.float64) / count
    u = 1 - t
    points = u**3 * curve[0] + 3 * u**2 * t * curve[1] + 3 * u * t**2 * curve[2] + t**3 * curve[3]
    legs = curve.diff()
    inner = 3 * (u**2 * legs[0] + 2 * u * t * legs[1] + t**2 * legs[2])
    tangents = torch.cat([_first_leg(curve)[None], inner[1:-1], -_first_leg(curve.flip(0))[None]])
    return points, 1j * tangents / tangents.abs()


def _first_leg(curve: Tensor) -> Tensor:
    """Return the direction from the start to the next control point that lies apart; along x if none does."""
    for point in curve[1:]:
        if (point - curve[0]).abs() >= 1e-2:
            return point - curve[0]
    return torch.tensor(1.0 + 0.0j, dtype=curve.dtype)


def _moved_out(points: Tensor) -> Tensor:
    """Return a polyline with its inner vertices farther out by n / (n - 1) twelfths of the second difference."""
    count = len(points) - 1
    if count < 2:
        return points
    inner = points[1:-1] - (points[:-2] - 2 * points[1:-1] + points[2:]) * count / (12 * (count - 1))
    return torch.cat([points[:1], inner, points[-1:]])


def _arc(angle: float, radius: float) -> int:
    return max(1, math.ceil(abs(angle) * math.sqrt(radius / (8 * CHORD_TOLERANCE))))


def _turned(direction: Tensor, angle: Tensor) -> Tensor:
    return direction * torch.exp(1j * angle)


def _round(center: Tensor, first: Tensor, angle: Tensor, radius: Tensor) -> list[Tensor]:
    """Return the inner vertices of an arc about ``center`` from the direction ``first`` on, with the arc's area."""
    count = _arc(angle.item(), radius.item())
    far = radius * (1 + angle**2 / (12 * count * max(count - 1, 1)))
    return [center + far * _turned(first, angle * i / count) for i in range(1, count)]


def _join(before: Tensor, after: Tensor, look: Look) -> tuple[list[Tensor], list[Tensor]]:
    """Return the vertices of a join on the left, and on the right, both in the direction of the line."""
    arriving, leaving = -_first_leg(before.flip(0)), _first_leg(after)
    normal, radius, at = 1j * arriving / arriving.abs(), look.width / 2, after[0]
    angle = (leaving / arriving).angle()
    side = -1 if angle > 0 else 1
    outer: list[Tensor] = []
    if look.join == ROUND:
        outer = _round(at, side * normal, angle, radius)
    elif look.join == MITER and look.miter_limit * float(torch.cos(angle.detach() / 2)) >= 1:
        outer = [at + radius / torch.cos(angle / 2) * side * _turned(normal, angle / 2)]
    else:
        assert look.join in (MITER, BEVEL)
    return ([at], outer) if angle > 0 else (outer, [at])


def _cap(curve: Tensor, look: Look, is_end: bool) -> list[Tensor]:
    """Return the vertices between the two sides, in the order of the outline."""
    leg = -_first_leg(curve.flip(0)) if is_end else -_first_leg(curve)
    out, at, radius = leg / leg.abs(), curve[-1] if is_end else curve[0], look.width / 2
    if look.cap == ROUND:
        return _round(at, 1j * out, torch.tensor(-math.pi, dtype=torch.float64), radius)
    if look.cap == SQUARE:
        return [at + radius * (out + 1j * out), at + radius * (out - 1j * out)]
    assert look.cap == BUTT
    return []
