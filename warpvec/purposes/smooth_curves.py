"""Fit smooth closed curves to dense points, by Schneider's least squares, from each node as far as one piece reaches.

P. J. Schneider, "An algorithm for automatically fitting digitized curves", Graphics Gems, 1990.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from warpvec.arrays import Floats
from warpvec.svg.foreign.shapes import Loop

_LINE_PRICE, _CUBIC_PRICE = 6, 17
"""Bytes of a line and of a cubic in path data, in numbers of two digits."""

_SHARE_OF_LINE = 0.5
"""Largest distance of a point from a line, as a share of that from a cubic: a line does not bend with the points."""

_ROUNDS = 3
"""Times that places along a cubic are found anew for its points."""


def smooth_curve(points: Floats, tolerance: float) -> Loop:
    """Return a closed line of cubics and lines near ``points`` [K, 2], in few bytes.

    From each node on, the piece is next that goes farthest for its bytes; the first node begins the longest line.

    Args:
        points: dense points along the curve, without the first one at the end.
        tolerance: largest distance of a point from the curve.
    """
    points = np.roll(points, -_start_of_longest_line(points, _SHARE_OF_LINE * tolerance), axis=0)
    tangent = np.roll(points, -2, axis=0) - np.roll(points, 2, axis=0)
    tangent = tangent / np.maximum(np.hypot(*tangent.T), 1e-12)[:, None]
    closed, tangents = np.concatenate([points, points[:1]]), np.concatenate([tangent, tangent[:1]])
    rows, is_line, first = list[Floats](), list[bool](), 0
    while first < len(points):
        line = _longest_line(closed, first, _SHARE_OF_LINE * tolerance)
        last, cubic = _longest_cubic(closed, tangents, first, tolerance)
        is_line.append((line - first) * _CUBIC_PRICE >= (last - first) * _LINE_PRICE)
        if is_line[-1]:
            last, (start, end) = line, (closed[first], closed[line])
            cubic = np.stack([start, (2 * start + end) / 3, (start + 2 * end) / 3])
        rows.append(cubic[:3])
        first = last
    return Loop(np.concatenate(rows), np.array(is_line))


def _start_of_longest_line(points: Floats, tolerance: float) -> int:
    closed, first, longest, found = np.concatenate([points, points[:1]]), 0, 0, 0
    while first < len(points):
        last = _longest_line(closed, first, tolerance)
        if last - first > longest:
            longest, found = last - first, first
        first = last
    return found


def _longest_line(closed: Floats, first: int, tolerance: float) -> int:
    """Return the last point to which a line from the point ``first`` on is near all points between."""

    def is_near(last: int) -> bool:
        away, chord = closed[first : last + 1] - closed[first], closed[last] - closed[first]
        length = float(np.hypot(*chord))
        distance = np.abs(away[:, 0] * chord[1] - away[:, 1] * chord[0]).max()
        return bool(length > 0.0 and distance <= tolerance * length)

    return _farthest(first, len(closed) - 1, is_near)


def _longest_cubic(closed: Floats, tangents: Floats, first: int, tolerance: float) -> tuple[int, Floats]:
    """Return the last point to which a cubic from the point ``first`` on is near all points, and the cubic [4, 2]."""
    found: dict[int, Floats] = {}

    def is_near(last: int) -> bool:
        found[last], miss = _fitted(closed[first : last + 1], tangents[first], tangents[last])
        return miss <= tolerance

    last = _farthest(first, len(closed) - 1, is_near)
    if last not in found:
        is_near(last)
    return last, found[last]


def _farthest(first: int, end: int, is_near: Callable[[int], bool]) -> int:
    """Return the farthest place up to ``end`` that is near: steps are doubled, and then halved."""
    low, step = min(first + 2, end), 4
    while low < end and is_near(min(first + step, end)):
        low, step = min(first + step, end), 2 * step
    high = min(first + step, end)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if is_near(middle) else (low, middle)
    return low


def _fitted(points: Floats, leaving: Floats, arriving: Floats) -> tuple[Floats, float]:
    """Return the cubic [4, 2] with these directions at its ends, and the largest miss of ``points``."""
    length = np.concatenate([[0.0], np.hypot(*np.diff(points, axis=0).T).cumsum()])
    t = length / max(length[-1], 1e-12)
    for number in range(_ROUNDS):
        cubic = _least_squares(points, t, leaving, arriving, length[-1])
        off = _at(cubic, t) - points
        if number + 1 < _ROUNDS:
            t = _nearer(cubic, t, off)
    return cubic, float(np.hypot(*off.T).max())


def _least_squares(points: Floats, t: Floats, leaving: Floats, arriving: Floats, length: float) -> Floats:
    """Return the cubic between the outer ``points`` whose handles have the lengths of least squares."""
    start, end = points[0], points[-1]
    a, b, c, d = (1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3
    wanted = points - np.outer(a + b, start) - np.outer(c + d, end)
    columns = np.stack([np.outer(b, leaving).ravel(), -np.outer(c, arriving).ravel()], 1)
    lengths = np.linalg.lstsq(columns, wanted.ravel(), rcond=None)[0]
    if not (1e-3 * length < lengths.min() and lengths.max() < length):
        lengths = np.full(2, length / 3.0)
    return np.stack([start, start + lengths[0] * leaving, end - lengths[1] * arriving, end])


def _nearer(cubic: Floats, t: Floats, off: Floats) -> Floats:
    """Return places ``t`` after a step of Newton's method to the nearest points of the cubic."""
    first = 3.0 * np.diff(cubic, axis=0)
    second = 2.0 * np.diff(first, axis=0)
    u = t[:, None]
    slope = (1 - u) ** 2 * first[0] + 2 * u * (1 - u) * first[1] + u**2 * first[2]
    bend = (1 - u) * second[0] + u * second[1]
    divisor = (slope**2 + off * bend).sum(1)
    step = np.where(np.abs(divisor) > 1e-12, (off * slope).sum(1) / np.where(divisor == 0.0, 1.0, divisor), 0.0)
    moved: Floats = np.clip(t - step, 0.0, 1.0)
    return np.maximum.accumulate(moved)


def _at(cubic: Floats, t: Floats) -> Floats:
    """Return the points [K, 2] of a cubic [4, 2] at ``t`` [K]."""
    u = t[:, None]
    points: Floats = (
        (1 - u) ** 3 * cubic[0] + 3 * u * (1 - u) ** 2 * cubic[1] + 3 * u**2 * (1 - u) * cubic[2] + u**3 * cubic[3]
    )
    return points
