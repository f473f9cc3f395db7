"""Cubic Bezier segments: the Bernstein weights, in which points are linear, and the bound on a chord's error."""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warpvec.kernels.constants import CHORD_TOLERANCE, SEGMENT_CHORDS_MAX
from warpvec.kernels.lanes import Lanes


@cache
def make_functions(lanes: Lanes) -> SimpleNamespace:
    """``weights``, ``vertex_weights`` and ``chord_count`` for the precision of ``lanes``."""
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

        3 if that is not finite: a vertex at a third, off any symmetry, then shows that the path is not, or is too far.
        """
        bend = wp.max(wp.length(p0 - dtype(2.0) * p1 + p2), wp.length(p1 - dtype(2.0) * p2 + p3))
        chords = chords_per_root * wp.sqrt(bend)
        if not wp.isfinite(chords):
            return 3
        return int(wp.clamp(wp.ceil(chords), dtype(1.0), most_chords))

    @wp.func
    def vertex_weights(j: int, count: int):
        """Weights of vertex j of n = ``count`` chords: the point at t = j / n less P''(t) / (12 n (n - 1)).

        A chord lies P'' / (8 n^2) inside its arc at its middle and 2/3 of that in the mean. The n - 1 vertices between
        the joints, which stay, are moved out by n / (n - 1) times that mean, so that a parabola's polygon has its area:
        chords that lie inside would be a bias for an optimizer to absorb and for the file to show.
        """
        t = dtype(j) / dtype(count)
        w = weights(t)
        if j > 0 and j < count:
            shift = half / dtype(count * (count - 1))
            w -= shift * vec4(one - t, three * t - two, one - three * t, t)
        return w

    return SimpleNamespace(vertex_weights=vertex_weights, weights=weights, chord_count=chord_count)
