"""Samples of the outlines of strokes: where they lie, and how they move with the centre line and the width.

A side moves across itself as its centre line does, and by half of what the width grows: that its normal turns moves it
along itself. Joins are left out. The matrix that is
made of these samples steers steps and need not be exact.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from warpvec.arrays import counted
from warpvec.geometry.bezier import whole_curves
from warpvec.geometry.scene import Scene
from warpvec.geometry.strokes import BUTT, END, FIRST, INNER, roles_of

Values = NDArray[np.float64]

GAP = 0.35
"""Largest distance of two samples in pixels, as of those of a fill."""

SAMPLES_MIN, SAMPLES_MAX = 4, 4096
"""Fewest samples of a side, and the most, which bound the work on one wild curve."""

_SPEED_MIN = 1e-9
"""Length of a tangent in pixels below which it has no direction."""


class StrokeSamples(NamedTuple):
    """Pieces of the outlines of strokes, in the order of the outline or against it.

    Attributes:
        row: the segment [M].
        weights: of its four points in the place [M, 4].
        place: [M, 2] px.
        along: the piece of the outline [M, 2] px.
        outward: the unit vector by which half of the width moves the place [M, 2].
    """

    row: NDArray[np.int64]
    weights: Values
    place: Values
    along: Values
    outward: Values


def stroke_samples(scene: Scene) -> StrokeSamples:
    """Return samples of the outlines of all strokes of the cubic ``scene``."""
    assert scene.strokes is not None
    role = roles_of(scene.strokes, scene.structure).cpu().numpy()
    curves = whole_curves(scene).double().cpu().numpy()
    path = scene.structure.segment_path.cpu().numpy()
    radius = scene.strokes.width.double().cpu().numpy()[path] / 2.0
    drawn = np.flatnonzero((role == INNER) | (role == FIRST))
    ends = np.flatnonzero(role == END)
    before = scene.structure.segment_previous.cpu().numpy()
    is_round = scene.strokes.cap.cpu().numpy()[path] != BUTT
    parts = [_sides(curves, radius, drawn)]
    parts.append(_caps(curves, radius, is_round, before[ends], is_end=True))
    parts.append(_caps(curves, radius, is_round, np.flatnonzero(role == FIRST), is_end=False))
    return StrokeSamples(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))


def _sides(curves: Values, radius: Values, drawn: NDArray[np.int64]) -> StrokeSamples:
    """Return samples of both sides of the rows ``drawn``; the right side runs back."""
    lengths = np.linalg.norm(np.diff(curves[drawn], axis=1), axis=2).sum(1)
    counts = np.clip(np.ceil(lengths / GAP), SAMPLES_MIN, SAMPLES_MAX).astype(np.int64)
    row, gap = np.repeat(drawn, counts), np.repeat(1.0 / counts, counts)
    t = (counted(counts) + 0.5) * gap
    weights, points, tangents = _at(curves[row], t)
    unit = _unit(tangents)
    normal = np.stack([-unit[:, 1], unit[:, 0]], 1)
    turned = _unit(_at(curves[row], t + 0.5 * gap)[2]) - _unit(_at(curves[row], t - 0.5 * gap)[2])
    bend = np.stack([-turned[:, 1], turned[:, 0]], 1) * radius[row][:, None]  # the change of the normal, times h
    offset = radius[row][:, None] * normal
    sides = [
        (points + side * offset, side * (gap[:, None] * tangents + side * bend), side * normal) for side in (1.0, -1.0)
    ]
    place, along, outward = (np.concatenate(arrays) for arrays in zip(*sides, strict=True))
    return StrokeSamples(np.tile(row, 2), np.tile(weights, (2, 1)), place, along, outward)


def _caps(
    curves: Values, radius: Values, is_round: NDArray[np.bool_], rows: NDArray[np.int64], *, is_end: bool
) -> StrokeSamples:
    """Return samples of the caps at the ends, or the starts, of the ``rows``: half circles, or straight lines."""
    counts = np.clip(np.ceil(np.pi * radius[rows] / GAP), SAMPLES_MIN, SAMPLES_MAX).astype(np.int64)
    row, gap = np.repeat(rows, counts), np.repeat(1.0 / counts, counts)
    share = (counted(counts) + 0.5) * gap
    tangent = _unit(_at(curves[row], np.full(len(row), 1.0 - 1e-3 if is_end else 1e-3))[2])
    out = tangent if is_end else -tangent
    first = np.stack([-out[:, 1], out[:, 0]], 1)
    angle, h = np.pi * share[:, None], radius[row][:, None]
    arc = np.cos(angle) * first + np.sin(angle) * out
    arc_along = h * np.pi * gap[:, None] * (np.cos(angle) * out - np.sin(angle) * first)
    straight, is_arc = 1.0 - 2.0 * share[:, None], is_round[row][:, None]
    weights = np.zeros((len(row), 4))
    weights[:, 3 if is_end else 0] = 1.0
    at = curves[row, 3 if is_end else 0]
    place = at + h * np.where(is_arc, arc, straight * first)
    along = np.where(is_arc, arc_along, -2.0 * h * gap[:, None] * first)
    return StrokeSamples(row, weights, place, along, np.where(is_arc, arc, straight * first))


def _at(curves: Values, t: Values) -> tuple[Values, Values, Values]:
    """Return the weights [M, 4], the points [M, 2] and the tangents [M, 2] of ``curves`` [M, 4, 2] at ``t`` [M]."""
    s = 1.0 - t
    weights = np.stack([s**3, 3 * s * s * t, 3 * s * t * t, t**3], 1)
    slopes = np.stack([s * s, 2 * s * t, t * t], 1)
    tangents = np.einsum("mk,mkd->md", slopes, 3 * np.diff(curves, axis=1))
    return weights, np.einsum("mk,mkd->md", weights, curves), tangents


def _unit(vectors: Values) -> Values:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), _SPEED_MIN)
