"""Cubics with given ends that are closest to rows of points, many at a time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

REPARAMETRIZATIONS = 4
"""Times that the parameters of the points move to where the cubic is closest, after each of which it is fitted anew."""

THIRDS_WEIGHT = 1e-5
"""Weight of handles at thirds of the chord, where all points together have 1. It decides where points are too few."""

_TINY = 1e-30
"""Added to what is divided by, which vanishes where points coincide."""


class Cubics(NamedTuple):
    """B cubics: handles [B, 2, 2], and the largest and the mean squared distance [B] from points to the cubic."""

    handles: Floats
    distance: Floats
    square: Floats


def fit_cubics(start: Floats, end: Floats, points: Floats, parameters: Floats) -> Cubics:
    """Return the cubics from ``start`` to ``end`` [B, 2] that are closest to ``points`` [B, S, 2], in squares.

    Args:
        start, end: ends of the cubics.
        points: points along each of them, in order.
        parameters: where along the cubic each point is about [B, S], in (0, 1); lengths over the whole length do.
    """
    u = parameters
    for _ in range(REPARAMETRIZATIONS):
        handles = _least_squares(start, end, points, u)
        u = _closer(start, handles, end, points, u)
    handles = _least_squares(start, end, points, u)
    return measure_cubics(start, handles, end, points, u)


def fit_lengths(start: Floats, end: Floats, directions: Floats, points: Floats, parameters: Floats) -> Cubics:
    """Return the closest cubics as `fit_cubics`, with handles along given directions.

    Args:
        start, end, points, parameters: as in `fit_cubics`.
        directions: unit vectors [B, 2, 2] of the first handle from ``start`` and of the second one from ``end``.
    """
    u = parameters
    chord = np.linalg.norm(end - start, axis=1)
    for _ in range(REPARAMETRIZATIONS):
        handles = _along(start, end, directions, points, u, chord)
        u = _closer(start, handles, end, points, u)
    return measure_cubics(start, _along(start, end, directions, points, u, chord), end, points, u)


def measure_cubics(start: Floats, handles: Floats, end: Floats, points: Floats, parameters: Floats) -> Cubics:
    """Return the cubics with their distances from ``points`` [B, S, 2], which are near ``parameters`` [B, S]."""
    u = _closer(start, handles, end, points, parameters)
    offset = on_cubics(start, handles, end, u) - points
    square = offset[..., 0] ** 2 + offset[..., 1] ** 2
    return Cubics(handles, np.sqrt(square.max(1)), square.mean(1))


def on_cubics(start: Floats, handles: Floats, end: Floats, u: Floats) -> Floats:
    """Return the points [B, S, 2] of cubics at the parameters ``u`` [B, S]."""
    u, v = u[..., None], 1.0 - u[..., None]
    inner = v * handles[:, None, 0] + u * handles[:, None, 1]
    return v * v * v * start[:, None] + 3.0 * u * v * inner + u * u * u * end[:, None]


def _least_squares(start: Floats, end: Floats, points: Floats, u: Floats) -> Floats:
    v = 1.0 - u
    first, second = 3.0 * u * v * v, 3.0 * u * u * v
    rest = points - (v * v * v)[..., None] * start[:, None] - (u * u * u)[..., None] * end[:, None]
    weight = THIRDS_WEIGHT * points.shape[1]
    a, b, c = (first * first).sum(1) + weight, (first * second).sum(1), (second * second).sum(1) + weight
    chord = end - start
    p = np.einsum("bs,bsk->bk", first, rest) + weight * (start + chord / 3.0)
    q = np.einsum("bs,bsk->bk", second, rest) + weight * (start + chord * 2.0 / 3.0)
    scale = 1.0 / (a * c - b * b)
    a, b, c = a * scale, b * scale, c * scale
    return np.stack([c[:, None] * p - b[:, None] * q, a[:, None] * q - b[:, None] * p], 1)


def _along(start: Floats, end: Floats, directions: Floats, points: Floats, u: Floats, chord: Floats) -> Floats:
    v = 1.0 - u
    first, second = 3.0 * u * v * v, 3.0 * u * u * v
    base = (v * v * v + first)[..., None] * start[:, None] + (u * u * u + second)[..., None] * end[:, None]
    rest = points - base
    weight = THIRDS_WEIGHT * points.shape[1]
    cosine = (directions[:, 0] * directions[:, 1]).sum(1)
    a, c = (first * first).sum(1) + weight, (second * second).sum(1) + weight
    b = (first * second).sum(1) * cosine
    p = np.einsum("bs,bsk,bk->b", first, rest, directions[:, 0]) + weight * chord / 3.0
    q = np.einsum("bs,bsk,bk->b", second, rest, directions[:, 1]) + weight * chord / 3.0
    determinant = a * c - b * b
    lengths = np.stack([(c * p - b * q) / determinant, (a * q - b * p) / determinant], 1)
    lengths = np.maximum(lengths, 0.0)
    return np.stack([start, end], 1) + lengths[..., None] * directions


def _closer(start: Floats, handles: Floats, end: Floats, points: Floats, u: Floats) -> Floats:
    """Return the parameters after a step of Newton's method to where the cubics are closest to the points."""
    first = handles[:, 0] - start
    second = start - 2.0 * handles[:, 0] + handles[:, 1]
    third = end - 3.0 * handles[:, 1] + 3.0 * handles[:, 0] - start
    w = u[..., None]
    first, second, third = 3.0 * first[:, None], 3.0 * second[:, None], third[:, None]
    offset = ((third * w + second) * w + first) * w + start[:, None] - points
    slope = (3.0 * third * w + 2.0 * second) * w + first
    bend = 6.0 * third * w + 2.0 * second
    numerator = (offset * slope).sum(-1)
    denominator = (slope * slope).sum(-1)
    curved = denominator + (offset * bend).sum(-1)
    # Newton's method may run to where the distance is largest; Gauss and Newton's may not.
    denominator = np.where(curved > 0.3 * denominator, curved, denominator)
    return np.clip(u - numerator / (denominator + _TINY), 0.0, 1.0)
