"""Arcs of circles in path data: a short way to state rows of cubics that are the very ones an arc stands for.

An arc goes from a place to another in ticks, units of the last decimal. It stands for cubics whose points are rounded
to ticks, so a scene knows nothing of arcs: the writer states an arc where the cubics of a scene are those of one, and
the reader gives them back.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from warpvec.arrays import cross

Ticks = NDArray[np.int64]
Floats = NDArray[np.float64]

ROWS_MAX = 8
"""Most cubics of an arc that is looked for."""

RADIUS_MIN = 100
"""Smallest radius of an arc in ticks. Curves of a few ticks are those of an arc by chance."""

HANDLE_ERROR = 1.6
"""Ticks by which the handles of a cubic that is an arc by itself may be off: rounded ends turn and stretch it."""

HALF_MIN = math.radians(2.0)
"""Least half of the angle by which such a cubic turns. Less is a line for the eye, and no arc says it more clearly."""

ROUNDING = 0.75
"""Largest distance in ticks that rounding makes."""

_QUARTER = math.pi / 2
_MORE_THAN_QUARTER = 0.01
"""A cubic may turn by so many quarters more than one: ends at ticks make a quarter a little larger."""

_NEARLY_HALF = math.radians(15.0)
"""Within this, an arc may be a half: its radius is then half of the chord, as no radius in ticks gives its centre."""

BULGE = 2.8e-4
"""Largest distance of the cubic that stands for a quarter from its circle, in radii: 0.03 px at 100 px."""

_RADII = (0, 1, -1, 2, -2, 3, -3)
"""Differences in ticks that are tried from the radius through three points at ticks."""

_ZEROS = (1, 2, 3)
"""Last digits that are zeros in short radii, which are tried too."""


class Arc(NamedTuple):
    """An arc: its radius in ticks, and the two flags of SVG. A radius below half of the chord stands for that half."""

    radius: int
    is_large: bool
    is_clockwise: bool


class _Circle(NamedTuple):
    """The circle of an arc from 0 to a place: its centre, its radius, the first angle and the turn, signed."""

    x: float
    y: float
    radius: float
    start: float
    turn: float


def arc_rows(step: Ticks, arc: Arc) -> Ticks:
    """Return the cubics [n, 3, 2] of an ``arc`` from 0 to the place ``step`` [2]."""
    circle = _circle(step, arc)
    count = max(1, math.ceil(abs(circle.turn) / _QUARTER - _MORE_THAN_QUARTER))
    angle = circle.start + circle.turn / count * np.arange(count + 1)
    toward = np.stack([np.cos(angle), np.sin(angle)], 1)
    ends = np.array([circle.x, circle.y]) + circle.radius * toward
    ends[0], ends[-1] = 0.0, step
    handle = 4.0 / 3.0 * math.tan(circle.turn / count / 4.0) * circle.radius * toward[:, ::-1] * (-1.0, 1.0)
    rows = np.stack([ends[:-1], ends[:-1] + handle[:-1], ends[1:] - handle[1:]], 1)
    return np.rint(rows).astype(np.int64)


def turn_of(step: Ticks, arc: Arc) -> float:
    """Return by how many radians an ``arc`` from 0 to the place ``step`` [2] turns; above 0 if it is clockwise."""
    return _circle(step, arc).turn


def arc_of(rows: Ticks, step: Ticks) -> Arc | None:
    """Return the arc that stands for just the cubics ``rows`` [n, 3, 2] from 0 to ``step`` [2]; None if none does.

    Of several it is one whose radius has the fewest digits.
    """
    for arc in sorted(_near(rows.astype(np.float64), step), key=_length):
        found = arc_rows(step, arc)
        if found.shape == rows.shape and (found == rows).all():
            return arc
    return None


def nearest_arc(rows: Floats, step: Ticks, tolerance: float) -> Arc | None:
    """Return the arc from 0 to ``step`` [2] nearest to the cubics ``rows`` [n, 3, 2]; None if all are farther away.

    Of those that the rounding of ends does not tell apart, it is the one whose radius has the fewest digits.

    Args:
        rows: control points in ticks.
        step: the end of the last cubic.
        tolerance: largest distance in ticks, beside that of a quarter's cubic from its circle.
    """
    points, least, near = _points(rows, step), math.inf, list[tuple[float, Arc]]()
    for arc in _near(rows, step):
        circle, drawn = _circle(step, arc), _points(arc_rows(step, arc).astype(np.float64), step)
        away = np.hypot(points[:, 0] - circle.x, points[:, 1] - circle.y) - circle.radius
        # Cubics of an arc lie a little beyond it, and those of the same number alike.
        beyond = np.hypot(drawn[:, 0] - circle.x, drawn[:, 1] - circle.y) - circle.radius
        is_alike = len(drawn) == len(points)
        off = float(np.abs(away - beyond if is_alike else away).max())
        least = min(least, off)
        if off <= tolerance + (0.0 if is_alike else BULGE * arc.radius):
            near.append((off, arc))
    told = [each for each in near if each[0] <= max(least, 2.0 * ROUNDING)]  # both are rounded
    return min(told, key=lambda each: (_length(each[1]), each[0]), default=(math.inf, None))[1]


def _length(arc: Arc) -> int:
    """Return the digits of the radius of an ``arc`` in ticks but for its last zeros."""
    return len(str(arc.radius).rstrip("0"))


def runs(rows: Floats, is_line: NDArray[np.bool_], ends: Floats) -> Iterator[tuple[int, int]]:
    """Yield the ranges of consecutive cubics that may lie on one circle; one alone must have the handles of an arc.

    Args:
        rows: control points [S, 3, 2] in ticks.
        is_line: which are lines [S].
        ends: the end of each row [S, 2].
    """
    if is_line.all():
        return
    x, y, radius = own_circles(rows, ends)
    tolerance = 2.0 + 0.02 * radius
    alike = np.hypot(x[1:] - x[:-1], y[1:] - y[:-1]) + np.abs(radius[1:] - radius[:-1]) <= tolerance[1:]
    alike &= ~is_line[1:] & ~is_line[:-1] & (radius[1:] >= RADIUS_MIN)
    alone = ~is_line & are_arcs(rows, ends)
    start = 0
    for row in range(1, len(rows) + 1):
        if row == len(rows) or not alike[row - 1]:
            if row - start > 1 or alone[start]:
                yield start, row
            start = row


def are_arcs(
    rows: Floats, ends: Floats, error: float = HANDLE_ERROR, radius_min: float = RADIUS_MIN
) -> NDArray[np.bool_]:
    """Return which cubics [S] have the handles of an arc on their own circle of ``radius_min`` at least.

    ``error`` is the largest distance of handles; what is given is what rounding to ticks makes.
    """
    x, y, radius = own_circles(rows, ends)
    chord = np.hypot(*(ends - rows[:, 0]).T)
    is_arc = (radius >= radius_min) & (chord > 0.0) & np.isfinite(x + y)
    known = np.where(is_arc, radius, 1.0)
    half = np.arcsin(np.where(is_arc, chord / 2.0 / known, 0.0).clip(max=1.0))
    reach = 4.0 / 3.0 * np.tan(half / 2.0) * known
    side = np.sign(cross(ends - rows[:, 0], rows[:, 1] - rows[:, 0]))
    is_arc &= half >= HALF_MIN
    for place, handle, way in ((rows[:, 0], rows[:, 1], 1.0), (ends, rows[:, 2], -1.0)):
        out = (place - np.stack([x, y], 1)) / known[:, None]
        wanted = place + (way * side * reach)[:, None] * np.stack([out[:, 1], -out[:, 0]], 1)
        is_arc &= np.hypot(*(wanted - handle).T) <= error
    return is_arc


def own_circles(rows: Floats, ends: Floats) -> tuple[Floats, Floats, Floats]:
    """Return the circle through both ends and the middle of each cubic: x, y and radius [S], infinite for lines."""
    start = rows[:, 0]
    middle = (start + 3.0 * rows[:, 1] + 3.0 * rows[:, 2] + ends) / 8.0
    with np.errstate(all="ignore"):
        found = _through(start, middle, ends)
    x, y, radius = (np.where(np.isfinite(part), part, np.inf) for part in found)
    is_straight = np.isinf(radius)
    return np.where(is_straight, 0.0, x), np.where(is_straight, 0.0, y), np.where(is_straight, -1.0, radius)


def _through(a: Floats, b: Floats, c: Floats) -> tuple[Floats, Floats, Floats]:
    """Return x, y and radius of the circles through three points each [..., 2]."""
    u, v = b - a, c - a
    cross = 2.0 * (u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0])
    uu, vv = np.square(u).sum(-1), np.square(v).sum(-1)
    x = (v[..., 1] * uu - u[..., 1] * vv) / cross
    y = (u[..., 0] * vv - v[..., 0] * uu) / cross
    return a[..., 0] + x, a[..., 1] + y, np.hypot(x, y)


def _near(rows: Floats, step: Ticks) -> Iterator[Arc]:
    """Yield the arcs that may stand for ``rows``, the likeliest first."""
    points = _points(rows, step)
    middle = points[len(points) // 2]
    with np.errstate(all="ignore"):
        x, y, radius = _through(np.zeros(2), middle, step.astype(np.float64))
    if not math.isfinite(radius) or radius < RADIUS_MIN:
        return
    center = np.array([x, y])
    around = points - center
    turns = np.arctan2(
        around[:-1, 0] * around[1:, 1] - around[:-1, 1] * around[1:, 0], (around[:-1] * around[1:]).sum(1)
    )
    turn = float(turns.sum())
    if abs(turn) >= 2 * math.pi - _QUARTER / 8:
        return
    is_clockwise = turn > 0.0
    if abs(abs(turn) - math.pi) < _NEARLY_HALF:
        yield Arc(math.floor(math.hypot(*step.tolist()) / 2.0), False, is_clockwise)
    usual = round(float(radius))
    radii = dict.fromkeys([*(usual + more for more in _RADII), *(round(usual, -zeros) for zeros in _ZEROS)])
    for own in radii:
        if own > 0:
            yield Arc(own, abs(turn) > math.pi, is_clockwise)


def _circle(step: Ticks, arc: Arc) -> _Circle:
    x, y = (float(value) for value in step)
    chord = math.hypot(x, y)
    radius = max(float(arc.radius), chord / 2.0)
    half = math.asin(min(chord / 2.0 / radius, 1.0))
    if arc.radius <= chord / 2.0:
        half, depth = _QUARTER, 0.0
    else:
        depth = math.sqrt(radius * radius - chord * chord / 4.0)
    side = 1.0 if arc.is_large != arc.is_clockwise else -1.0  # of the chord on which the centre lies
    center = (x - side * 2.0 * depth * y / chord) / 2.0, (y + side * 2.0 * depth * x / chord) / 2.0
    turn = 2.0 * half if not arc.is_large else 2.0 * math.pi - 2.0 * half
    return _Circle(*center, radius, math.atan2(-center[1], -center[0]), turn if arc.is_clockwise else -turn)


def _points(rows: Floats, step: Ticks) -> Floats:
    """Return points along cubics [4 n + 1, 2]: their ends and three between."""
    ends = np.concatenate([rows[1:, 0], step[None]])
    t = np.arange(4)[:, None] / 4.0
    a, b, c, d = (part[:, None] for part in (rows[:, 0], rows[:, 1], rows[:, 2], ends))
    points = (1 - t) ** 3 * a + 3 * (1 - t) ** 2 * t * b + 3 * (1 - t) * t**2 * c + t**3 * d
    return np.concatenate([points.reshape(-1, 2), step[None]])
