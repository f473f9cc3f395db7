"""Cubic Bezier segments: the Bernstein weights, in which points are linear, and the bound on a chord's error."""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warpvec.kernels.constants import CHORD_TOLERANCE, SEGMENT_CHORDS_MAX
from warpvec.kernels.lanes import Lanes


@cache
def make_functions(lanes: Lanes) -> SimpleNamespace:
    """``weights(t)`` and ``chord_count(p0, p1, p2, p3)`` for the precision of ``lanes``."""
    dtype, vec2, vec4 = lanes.dtype, lanes.vec2, lanes.vec4
    chords_per_root = wp.constant(dtype((0.75 / CHORD_TOLERANCE) ** 0.5))

    half, one, two, three = (wp.constant(dtype(value)) for value in (0.5, 1.0, 2.0, 3.0))
    most_chords = wp.constant(dtype(SEGMENT_CHORDS_MAX))

    @wp.func
    def weights(t: dtype):
        """Bernstein weights of the four control points at t; also d(point)/d(control point)."""
        u = dtype(1.0) - t
        return vec4(u * u * u, dtype(3.0) * u * u * t, dtype(3.0) * u * t * t, t * t * t)

    @wp.func
    def chord_count(p0: vec2, p1: vec2, p2: vec2, p3: vec2):
        """Chords of equal parameter length within CHORD_TOLERANCE of the cubic (Wang's bound).

        2 if that is not finite: the vertex between then shows that the path is not, or lies out of range.
        """
        bend = wp.max(wp.length(p0 - dtype(2.0) * p1 + p2), wp.length(p1 - dtype(2.0) * p2 + p3))
        chords = chords_per_root * wp.sqrt(bend)
        if not wp.isfinite(chords):
            return 2
        return int(wp.clamp(wp.ceil(chords), dtype(1.0), most_chords))

    @wp.func
    def vertex_weights(j: int, count: int):
        """Weights of vertex j of ``count`` chords: the point at t = j / n less P''(t) / (12 n^2), joints as they are.

        A chord lies P'' / (8 n^2) inside its arc at its middle and 2/3 of that in the mean. Shifting the vertices out
        by that mean makes the polygon's area that of the curve: no bias for an optimizer to absorb.
        """
        step = one / dtype(count)
        t = dtype(j) * step
        w = weights(t)
        if j > 0 and j < count:
            shift = step * step * half
            w -= shift * vec4(one - t, three * t - two, one - three * t, t)
        return w

    return SimpleNamespace(vertex_weights=vertex_weights, weights=weights, chord_count=chord_count)
