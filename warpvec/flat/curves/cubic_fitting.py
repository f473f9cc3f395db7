"""Cubics with given ends that are closest to rows of points, many at a time.

Everything is computed in the dtype of the points: float32 is twice as fast, and its error is below 0.001 px if the
points are relative to one near them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from warpvec.flat.constants.curves import CURVES

Floats = NDArray[Any]

_TINY = 1e-20
"""Added to what is divided by, which vanishes where points coincide."""


class Cubics(NamedTuple):
    """B cubics: handles [B, 2, 2], and the largest and the mean squared distance [B] from points to the cubic."""

    handles: Floats
    distance: Floats
    square: Floats


def fit_cubics(
    start: Floats, end: Floats, points: Floats, parameters: Floats, plan: tuple[int, float] = CURVES.quick_plan
) -> Cubics:
    """Return the cubics from ``start`` to ``end`` [B, 2] that are closest to ``points`` [B, S, 2], in squares.

    Args:
        start, end: ends of the cubics.
        points: points along each of them, in order.
        parameters: where along the cubic each point is about [B, S], in (0, 1); lengths over the whole length do.
        plan: ``quick_plan`` or ``precise_plan``.
    """
    a, d, p = _columns(start), _columns(end), _rows(points)
    return _fitted(a, d, p, parameters, plan, lambda u: _least_squares(a, d, p, u))


def fit_lengths(start: Floats, end: Floats, directions: Floats, points: Floats, parameters: Floats) -> Cubics:
    """Return the closest cubics as `fit_cubics`, with handles along given directions.

    Args:
        start, end, points, parameters: as in `fit_cubics`.
        directions: unit vectors [B, 2, 2] of the first handle from ``start`` and of the second one from ``end``.
    """
    a, d, p = _columns(start), _columns(end), _rows(points)
    along = _columns(directions[:, 0]), _columns(directions[:, 1])
    return _fitted(a, d, p, parameters, CURVES.precise_plan, lambda u: _along(a, d, along, p, u))


def _fitted(
    a: Floats, d: Floats, points: Floats, u: Floats, plan: tuple[int, float],
    fit: Callable[[Floats], tuple[Floats, Floats]],
) -> Cubics:  # fmt: skip
    rounds, factor = plan
    for _ in range(rounds - 1):
        b, c = fit(u)
        u = _closer(a, b, c, d, points, u, factor)
    b, c = fit(u)
    u = _closer(a, b, c, d, points, u, 1.0)
    offset = _on_cubics(a, b, c, d, u)[0] - points
    square = offset[0] ** 2 + offset[1] ** 2
    return Cubics(np.stack([b[..., 0].T, c[..., 0].T], 1), np.sqrt(square.max(1)), square.mean(1))


def _columns(vectors: Floats) -> Floats:
    """Return [B, 2] as [2, B, 1]: operations on long rows are several times faster than on pairs."""
    return np.ascontiguousarray(vectors.T)[..., None]


def _rows(points: Floats) -> Floats:
    """Return [B, S, 2] as [2, B, S]."""
    return np.ascontiguousarray(np.moveaxis(points, -1, 0))


def _on_cubics(a: Floats, b: Floats, c: Floats, d: Floats, u: Floats) -> tuple[Floats, Floats]:
    """Return the points of cubics and their derivatives [2, B, S] at the parameters ``u`` [B, S]."""
    first, second = 3.0 * (b - a), 3.0 * (a - 2.0 * b + c)
    third = d - a - 3.0 * (c - b)
    return ((third * u + second) * u + first) * u + a, (3.0 * third * u + 2.0 * second) * u + first


def _least_squares(a: Floats, d: Floats, points: Floats, u: Floats) -> tuple[Floats, Floats]:
    """Return the handles [2, B, 1] closest to ``points`` [2, B, S] at the parameters ``u`` [B, S]."""
    v = 1.0 - u
    first, second = 3.0 * u * v * v, 3.0 * u * u * v
    rest = points - v * v * v * a - u * u * u * d
    weight = CURVES.thirds_weight * u.shape[1]
    xx, xy = (first * first).sum(1) + weight, (first * second).sum(1)
    yy = (second * second).sum(1) + weight
    chord = d[..., 0] - a[..., 0]
    p = (first * rest).sum(-1) + weight * (a[..., 0] + chord / 3.0)
    q = (second * rest).sum(-1) + weight * (a[..., 0] + chord * (2.0 / 3.0))
    determinant = xx * yy - xy * xy
    return ((yy * p - xy * q) / determinant)[..., None], ((xx * q - xy * p) / determinant)[..., None]


def _along(a: Floats, d: Floats, directions: tuple[Floats, Floats], points: Floats, u: Floats) -> tuple[Floats, Floats]:
    """Return the closest handles [2, B, 1] along ``directions``, not backwards."""
    v = 1.0 - u
    first, second = 3.0 * u * v * v, 3.0 * u * u * v
    rest = points - (v * v * v + first) * a - (u * u * u + second) * d
    weight = CURVES.thirds_weight * u.shape[1]
    third = weight * np.sqrt(((d - a) ** 2).sum(0))[:, 0] / 3.0
    forward, backward = directions
    xx, yy = (first * first).sum(1) + weight, (second * second).sum(1) + weight
    xy = (first * second).sum(1) * (forward * backward).sum(0)[:, 0]
    p = (first * (rest * forward).sum(0)).sum(1) + third
    q = (second * (rest * backward).sum(0)).sum(1) + third
    determinant = xx * yy - xy * xy
    lengths = np.maximum(np.stack([yy * p - xy * q, xx * q - xy * p]) / determinant, 0.0)[..., None]
    return a + lengths[0] * forward, d + lengths[1] * backward


def _closer(a: Floats, b: Floats, c: Floats, d: Floats, points: Floats, u: Floats, factor: float) -> Floats:
    """Return the parameters [B, S] after ``factor`` steps to where the cubics are closest."""
    place, slope = _on_cubics(a, b, c, d, u)
    offset = place - points
    step = (offset * slope).sum(0) / ((slope * slope).sum(0) + _TINY)
    return np.clip(u - factor * step, 0.0, 1.0)
