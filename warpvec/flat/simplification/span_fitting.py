"""Fit one line or one cubic to several segments that follow each other, for many such spans at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpvec.arrays import Floats, Integers
from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.flat.simplification.outline_samples import OutlineSamples, cubic_points, cubic_slopes, cubic_weights

_TINY = 1e-12


@dataclass(frozen=True, eq=False)
class Ends:
    """The ends of K spans.

    Attributes:
        start, end: the anchors [K, 2].
        leaving, arriving: the unit tangent of the outline at each [K, 2]; zero where it has a corner.
    """

    start: Floats
    end: Floats
    leaving: Floats
    arriving: Floats


@dataclass(frozen=True, eq=False)
class FittedSpans:
    """Cubics for K spans.

    Attributes:
        handles: the two handles [K, 2, 2].
        places: the closest point of the cubic to each point of the span [K, M, 2].
        price: what turned tangents cost [K], in cubic pixels; infinite for cubics that are no use.
    """

    handles: Floats
    places: Floats
    price: Floats


@dataclass(frozen=True, eq=False)
class Span:
    """The points of K spans: ``points`` [K, M, 2], ``lengths`` and ``visibility`` [K, M], and their ``path`` [K]."""

    points: Floats
    lengths: Floats
    visibility: Floats
    path: Integers


def spans_of(samples: OutlineSamples, rows: Integers) -> Span:
    """Return the spans of the segments ``rows`` [K, k]."""
    count = len(rows)
    points = samples.points[rows].reshape(count, -1, 2)
    lengths, visibility = (each[rows].reshape(count, -1) for each in (samples.lengths, samples.visibility))
    return Span(points, lengths, visibility, samples.path[rows[:, 0]])


def fit_cubics(span: Span, ends: Ends) -> FittedSpans:
    """Return the cubics closest to the points."""
    points, lengths = span.points, span.lengths
    weights = lengths * np.maximum(span.visibility, SIMPLIFICATION.hidden_weight) + _TINY
    total = lengths.sum(1)
    along = np.cumsum(lengths, 1) - lengths / 2.0
    u = along / (total[:, None] + _TINY)
    share, normal = np.ones_like(u), np.zeros_like(points)
    for _ in range(SIMPLIFICATION.handle_rounds):
        handles = _handles(points, weights, u, normal, share, ends)
        control = np.stack([ends.start, handles[:, 0], handles[:, 1], ends.end], 1)
        u = _closer(control, u, points)
        slope = cubic_slopes(control, u)
        normal = np.stack([-slope[..., 1], slope[..., 0]], -1)
        normal /= np.linalg.norm(normal, axis=-1, keepdims=True) + _TINY
        share = np.full_like(u, SIMPLIFICATION.along_weight)
    return FittedSpans(handles, cubic_points(control, u), _price(handles, ends, weights.sum(1), total))


def fit_lines(points: Floats, ends: Ends) -> FittedSpans:
    """Return the lines between the ends."""
    chord = ends.end - ends.start
    reach = np.linalg.norm(chord, axis=1)
    unit = chord / (reach + _TINY)[:, None]
    along = ((points - ends.start[:, None]) * unit[:, None]).sum(-1)
    along = np.clip(along, 0.0, reach[:, None])
    handles = np.stack([ends.start + chord / 3.0, ends.start + chord * (2.0 / 3.0)], 1)
    return FittedSpans(handles, ends.start[:, None] + along[..., None] * unit[:, None], np.zeros(len(chord)))


def _price(handles: Floats, ends: Ends, weight: Floats, total: Floats) -> Floats:
    """Return the price of turned tangents [K], infinite where a handle is too long or points backwards."""
    price, is_wrong = np.zeros(len(total)), np.zeros(len(total), np.bool_)
    for handle, tangent in ((handles[:, 0] - ends.start, ends.leaving), (ends.end - handles[:, 1], ends.arriving)):
        off = handle[:, 0] * tangent[:, 1] - handle[:, 1] * tangent[:, 0]
        price += SIMPLIFICATION.turn_price * weight * np.square(off)
        is_wrong |= (handle * tangent).sum(1) < 0.0
        is_wrong |= np.linalg.norm(handle, axis=1) > SIMPLIFICATION.handle_max * total
    return np.where(is_wrong, np.inf, price)


def _handles(points: Floats, weights: Floats, u: Floats, normal: Floats, share: Floats, ends: Ends) -> Floats:
    """Return the handles [K, 2, 2] by least squares at the parameters ``u`` [K, M].

    A distance along the ``normal`` counts in full, another one by ``share``.
    """
    basis = cubic_weights(u)
    fixed = basis[..., [0, 3]] @ np.stack([ends.start, ends.end], 1)
    fixed += basis[..., 1:2] * ends.start[:, None] + basis[..., 2:3] * ends.end[:, None]
    rest, inner = points - fixed, basis[..., 1:3]
    level, extra = weights * share, weights * (1.0 - share)
    xx, yy = level + extra * normal[..., 0] ** 2, level + extra * normal[..., 1] ** 2
    xy = extra * normal[..., 0] * normal[..., 1]
    products = np.stack([inner[..., 0] ** 2, inner[..., 0] * inner[..., 1], inner[..., 1] ** 2], 1)
    sums = products @ np.stack([xx, xy, yy], -1)  # [K, 3, 3]: products of weights, entries of the matrix
    matrix = sums[:, _PAIRS][..., _PAIRS].swapaxes(2, 3).reshape(-1, 4, 4)
    weighted = np.stack([xx * rest[..., 0] + xy * rest[..., 1], xy * rest[..., 0] + yy * rest[..., 1]], -1)
    right = (inner.swapaxes(1, 2) @ weighted).reshape(-1, 4)
    total = weights.sum(1)
    for place, tangent in ((0, ends.leaving), (2, ends.arriving)):
        across = np.stack([-tangent[:, 1], tangent[:, 0]], 1)
        matrix[:, place : place + 2, place : place + 2] += (SIMPLIFICATION.turn_price * total)[:, None, None] * (
            across[:, :, None] * across[:, None, :]
        )
    third = (ends.end - ends.start) / 3.0
    ridge = 1e-7 * total + _TINY
    matrix += ridge[:, None, None] * np.eye(4)
    right += ridge[:, None] * np.concatenate([third, -third], 1)
    found = np.linalg.solve(matrix, right[..., None]).reshape(-1, 2, 2).astype(np.float64)
    return found + np.stack([ends.start, ends.end], 1)


def _closer(control: Floats, u: Floats, points: Floats) -> Floats:
    """Move the parameters ``u`` [K, M] to where the cubics are closest to the points; they keep rising."""
    for _ in range(2):
        offset, slope = cubic_points(control, u) - points, cubic_slopes(control, u)
        step = (offset * slope).sum(-1) / (np.square(slope).sum(-1) + _TINY)
        u = np.maximum.accumulate(np.clip(u - step, 0.0, 1.0), 1)
    return u


_PAIRS = np.array([[0, 1], [1, 2]])
