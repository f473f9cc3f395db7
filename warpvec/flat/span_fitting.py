"""Fit one line or one cubic to several segments that follow each other, for many such spans at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warpvec.flat.outline_samples import Floats, OutlineSamples, cubic_points, cubic_slopes, cubic_weights

ROUNDS = 4
"""Times that the handles are found anew. Later ones change the distance by less than a hundredth."""

ALONG = 0.02
"""Weight of a squared distance along the cubic, where that across it has 1."""

HIDDEN_WEIGHT = 1e-3
"""Weight of hidden points in the fit. They decide only where no visible ones do."""

TURN_PRICE = 0.1
"""Price of the part of a handle that leaves the tangent of a smooth node, squared, in lengths of the span: the outline
moves by 0.44 of it along a third of the span."""

HANDLE_MAX = 1.5
"""Longest handle, in lengths of the span."""

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
class Fits:
    """Cubics for K spans.

    Attributes:
        handles: the two handles [K, 2, 2].
        error: integral of the squared visible distance along the span [K], in cubic pixels.
        distance: largest visible distance [K], in pixels.
        hidden_distance: largest distance of hidden points [K], in pixels.
    """

    handles: Floats
    error: Floats
    distance: Floats
    hidden_distance: Floats


def spans_of(samples: OutlineSamples, rows: NDArray[np.int64]) -> tuple[Floats, Floats, Floats]:
    """Return points [K, M, 2], lengths and visibility [K, M] of the spans of the segments ``rows`` [K, k]."""
    count = len(rows)
    points = samples.points[rows].reshape(count, -1, 2)
    return points, samples.lengths[rows].reshape(count, -1), samples.visibility[rows].reshape(count, -1)


def fit_cubics(points: Floats, lengths: Floats, visibility: Floats, ends: Ends) -> Fits:
    """Return the cubics closest to ``points`` [K, M, 2], each of which stands for so much length [K, M]."""
    weights = lengths * np.maximum(visibility, HIDDEN_WEIGHT) + _TINY
    total = lengths.sum(1)
    along = np.cumsum(lengths, 1) - lengths / 2.0
    u = along / (total[:, None] + _TINY)
    share, normal = np.ones_like(u), np.zeros_like(points)
    for _ in range(ROUNDS):
        handles = _handles(points, weights, u, normal, share, ends)
        control = np.stack([ends.start, handles[:, 0], handles[:, 1], ends.end], 1)
        u = _closer(control, u, points)
        slope = cubic_slopes(control, u)
        normal = np.stack([-slope[..., 1], slope[..., 0]], -1)
        normal /= np.linalg.norm(normal, axis=-1, keepdims=True) + _TINY
        share = np.full_like(u, ALONG)
    distance = np.linalg.norm(cubic_points(control, u) - points, axis=-1)
    fits = _fits(handles, distance, lengths, visibility)
    return _with_turns(fits, ends, weights.sum(1), total)


def fit_lines(points: Floats, lengths: Floats, visibility: Floats, ends: Ends) -> Fits:
    """Return the lines between the ends."""
    chord = ends.end - ends.start
    reach = np.linalg.norm(chord, axis=1)
    unit = chord / (reach + _TINY)[:, None]
    offset = points - ends.start[:, None]
    across = np.abs(offset[..., 0] * unit[:, None, 1] - offset[..., 1] * unit[:, None, 0])
    along = (offset * unit[:, None]).sum(-1)
    beyond = np.maximum(np.maximum(-along, along - reach[:, None]), 0.0)
    handles = np.stack([ends.start + chord / 3.0, ends.start + chord * (2.0 / 3.0)], 1)
    return _fits(handles, np.hypot(across, beyond), lengths, visibility)


def _fits(handles: Floats, distance: Floats, lengths: Floats, visibility: Floats) -> Fits:
    error = (np.square(distance) * visibility * lengths).sum(1)
    visible = (distance * np.sqrt(visibility)).max(1)
    hidden = (distance * (1.0 - visibility)).max(1)
    return Fits(handles, error, visible, hidden)


def _with_turns(fits: Fits, ends: Ends, weight: Floats, total: Floats) -> Fits:
    """Add the price of turned tangents; refuse cubics whose handles are too long or point backwards."""
    leaving, arriving = fits.handles[:, 0] - ends.start, ends.end - fits.handles[:, 1]
    error, is_wrong = fits.error.copy(), np.zeros(len(total), np.bool_)
    for handle, tangent in ((leaving, ends.leaving), (arriving, ends.arriving)):
        off = handle[:, 0] * tangent[:, 1] - handle[:, 1] * tangent[:, 0]
        error += TURN_PRICE * weight * np.square(off)
        is_wrong |= (handle * tangent).sum(1) < 0.0
        is_wrong |= np.linalg.norm(handle, axis=1) > HANDLE_MAX * total
    error[is_wrong] = np.inf
    return Fits(fits.handles, error, fits.distance, fits.hidden_distance)


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
        matrix[:, place : place + 2, place : place + 2] += (TURN_PRICE * total)[:, None, None] * (
            across[:, :, None] * across[:, None, :]
        )
    third = (ends.end - ends.start) / 3.0
    ridge = 1e-7 * total + _TINY
    matrix += ridge[:, None, None] * np.eye(4)
    right += ridge[:, None] * np.concatenate([third, -third], 1)
    found: Floats = np.linalg.solve(matrix, right[..., None]).reshape(-1, 2, 2)
    return found + np.stack([ends.start, ends.end], 1)


def _closer(control: Floats, u: Floats, points: Floats) -> Floats:
    """Move the parameters ``u`` [K, M] to where the cubics are closest to the points; they keep rising."""
    for _ in range(2):
        offset, slope = cubic_points(control, u) - points, cubic_slopes(control, u)
        step = (offset * slope).sum(-1) / (np.square(slope).sum(-1) + _TINY)
        u = np.maximum.accumulate(np.clip(u - step, 0.0, 1.0), 1)
    return u


_PAIRS = np.array([[0, 1], [1, 2]])
