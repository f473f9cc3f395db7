"""Fit smooth closed curves to dense points, by Schneider's method: least squares, and a node more where that misses.

P. J. Schneider, "An algorithm for automatically fitting digitized curves", Graphics Gems, 1990.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from warpvec.arrays import Floats

_PARTS = 3
"""Cubics that a closed curve has at least."""

_ROUNDS = 3
"""Times that places along a cubic are found anew for its points."""


def smooth_curve(points: Floats, tolerance: float) -> Floats:
    """Return the cubics [3 k, 2], an anchor and two handles each, of a smooth closed curve through ``points`` [K, 2].

    Args:
        points: dense points along the curve, without the first one at the end.
        tolerance: largest distance of a point from the curve.
    """
    count = len(points)
    tangent = np.roll(points, -2, axis=0) - np.roll(points, 2, axis=0)
    tangent = tangent / np.maximum(np.hypot(*tangent.T), 1e-12)[:, None]
    closed, tangents = np.concatenate([points, points[:1]]), np.concatenate([tangent, tangent[:1]])
    ends = sorted({round(part * count / _PARTS) for part in range(_PARTS + 1)})
    rows: list[Floats] = []
    waiting = list(pairwise(ends))[::-1]
    while waiting:
        first, last = waiting.pop()
        cubic, miss, worst = _fitted(closed[first : last + 1], tangents[first], tangents[last])
        if miss <= tolerance or last - first < 2:
            rows.append(cubic[:3])
        else:
            middle = min(max(first + worst, first + 1), last - 1)
            waiting += [(middle, last), (first, middle)]
    return np.concatenate(rows)


def _fitted(points: Floats, leaving: Floats, arriving: Floats) -> tuple[Floats, float, int]:
    """Return the cubic [4, 2] with these directions at its ends, the largest miss of ``points``, and where that is."""
    length = np.concatenate([[0.0], np.hypot(*np.diff(points, axis=0).T).cumsum()])
    t = length / max(length[-1], 1e-12)
    for number in range(_ROUNDS):
        cubic = _least_squares(points, t, leaving, arriving, length[-1])
        off = _at(cubic, t) - points
        if number + 1 < _ROUNDS:
            t = _nearer(cubic, t, off)
    misses = np.hypot(*off.T)
    worst = int(misses.argmax())
    return cubic, float(misses[worst]), worst


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
