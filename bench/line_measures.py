"""Measures of drawings of lines: how far centre lines lie from the original's, and which lines were found once."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from flat_corners import Points, scene_of
from scipy.spatial import cKDTree

from warpvec.geometry.bezier import whole_curves

STEP = 0.5
"""Distance in pixels of the points along a line."""

REACH = 2.0
"""Distance in pixels within which a line of the tracing counts as one of the original."""

PARALLEL = 0.5
"""Least cosine between a line and the one that it is found by."""


class Trail(NamedTuple):
    """Short pieces of lines: their middles [K, 2] in pixels, their unit directions [K, 2], and their lengths [K]."""

    middles: Points
    directions: Points
    lengths: Points


class Found(NamedTuple):
    """How a tracing's lines compare with the original's.

    Attributes:
        off: mean distance in pixels of the tracing's lines from those of the original.
        once: share of the original's length that exactly one line of the tracing follows.
        missed: share that none follows.
    """

    off: float
    once: float
    missed: float


def trail_of(svg: str, width: int, height: int) -> Trail:
    """Return the pieces of the strokes of ``svg`` as it is drawn with ``width`` x ``height`` pixels."""
    scene = scene_of(svg, width, height)
    structure, curves = scene.structure, whole_curves(scene).double().numpy()
    is_open = [False] * structure.loop_count if structure.is_open is None else structure.is_open.tolist()
    path = structure.segment_path.tolist()
    pieces = []
    for (start, stop), opened in zip(pairwise(structure.loop_first_segment.tolist()), is_open, strict=True):
        if scene.strokes is not None and scene.strokes.is_stroked[path[start]]:
            pieces += [_chords(curve) for curve in curves[start : stop - opened]]
    chords = np.concatenate([np.zeros((0, 2, 2)), *pieces])
    steps = chords[:, 1] - chords[:, 0]
    lengths = np.hypot(*steps.T)
    kept = lengths > 1e-6
    return Trail(chords[kept].mean(1), steps[kept] / lengths[kept, None], lengths[kept])


def _chords(curve: Points) -> Points:
    """Return the chords [n, 2, 2] of a cubic [4, 2]."""
    count = max(int(np.ceil(np.hypot(*np.diff(curve, axis=0).T).sum() / STEP)), 1)
    t = np.linspace(0.0, 1.0, count + 1)[:, None]
    a, b, c, d = curve
    points = (1 - t) ** 3 * a + 3 * (1 - t) ** 2 * t * b + 3 * (1 - t) * t**2 * c + t**3 * d
    return np.stack([points[:-1], points[1:]], 1)


def compare(tracing: Trail, original: Trail) -> Found:
    """Return how the lines of a ``tracing`` compare with those of the ``original``."""
    if not len(tracing.lengths):
        return Found(float("inf"), 0.0, 1.0)
    follows, wanted = _followers(tracing, original), _followers(original, original)
    weights = original.lengths / original.lengths.sum()
    # Where the original draws a line twice, one is enough.
    once = (follows >= 1) & (follows <= np.maximum(wanted, 1))
    return Found(_off(tracing, original), float(weights[once].sum()), float(weights[follows == 0].sum()))


def _off(some: Trail, others: Trail) -> float:
    """Return the mean distance of the pieces of ``some`` from those of ``others``, which are straight."""
    count = min(8, len(others.lengths))
    _, near = cKDTree(others.middles).query(some.middles, count)
    near = near.reshape(len(some.lengths), count)
    away = some.middles[:, None] - others.middles[near]
    along = (away * others.directions[near]).sum(2)
    half = others.lengths[near] / 2.0
    rest = away - along.clip(-half, half)[..., None] * others.directions[near]
    distance = np.hypot(rest[..., 0], rest[..., 1]).min(1)
    return float((distance * some.lengths).sum() / some.lengths.sum())


def _followers(tracing: Trail, original: Trail) -> Points:
    """Return how many lines of the ``tracing`` pass each piece of the ``original`` in its direction [K]."""
    tree = cKDTree(tracing.middles)
    found = np.zeros(len(original.lengths))
    for k, near in enumerate(tree.query_ball_point(original.middles, REACH + STEP)):
        away = tracing.middles[near] - original.middles[k]
        cosine = tracing.directions[near] @ original.directions[k]
        along = away @ original.directions[k]
        half = tracing.lengths[near] * np.abs(cosine) / 2.0
        # A piece passes if it crosses the line that is square to the original.
        passes = (np.abs(cosine) >= PARALLEL) & (along - half <= 0.0) & (along + half > 0.0)
        found[k] = passes.sum()
    return found
