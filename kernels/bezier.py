"""Cubic Bezier segments: Bernstein weights, and the number of chords that keeps within CHORD_TOLERANCE."""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels.constants import CHORD_TOLERANCE, SEGMENT_CHORDS_MAX
from warpvec.kernels.lanes import Lanes, bundle
from warpvec.kernels.making import made_once


@made_once
def make_functions(lanes: Lanes) -> SimpleNamespace:
    """Return ``weights``, ``vertex_weights`` and ``chord_count`` in the precision of ``lanes``."""
    dtype, vec2, vec4 = lanes.dtype, lanes.vec2, lanes.vec4
    chords_per_root = wp.constant(dtype((0.75 / CHORD_TOLERANCE) ** 0.5))

    half, one, two, three = (wp.constant(dtype(value)) for value in (0.5, 1.0, 2.0, 3.0))
    chords_max = wp.constant(dtype(SEGMENT_CHORDS_MAX))

    @wp.func
    def weights(t: dtype):
        """Return the Bernstein weights of the four control points at t, which are also d(point)/d(control point)."""
        u = dtype(1.0) - t
        return vec4(u * u * u, dtype(3.0) * u * u * t, dtype(3.0) * u * t * t, t * t * t)

    @wp.func
    def chord_count(p0: vec2, p1: vec2, p2: vec2, p3: vec2):
        """Return how many chords of equal parameter length stay within CHORD_TOLERANCE of the cubic (Wang's bound).

        The count is 3 if the bound is not finite. The vertices at thirds, which no symmetry can cancel, then show
        that the path is not finite or is too far out.
        """
        bend = wp.max(wp.length(p0 - dtype(2.0) * p1 + p2), wp.length(p1 - dtype(2.0) * p2 + p3))
        chords = chords_per_root * wp.sqrt(bend)
        if not wp.isfinite(chords):
            return 3
        return int(wp.clamp(wp.ceil(chords), dtype(1.0), chords_max))

    @wp.func
    def vertex_weights(j: int, count: int):
        """Return the weights of vertex j of n = ``count`` chords: the point at t = j / n minus P''(t) / (12 n (n - 1)).

        A chord lies P'' / (8 n^2) inside its arc at the middle, and 2/3 of that on average. The end vertices stay. The
        n - 1 vertices between them are moved out by n / (n - 1) times that average, so that the polygon of a parabola
        has the parabola's area. Chords that lie inside the curve would be a bias that the optimizer absorbs and the
        file then shows.
        """
        t = dtype(j) / dtype(count)
        w = weights(t)
        if j > 0 and j < count:
            shift = half / dtype(count * (count - 1))
            w -= shift * vec4(one - t, three * t - two, one - three * t, t)
        return w

    return bundle(vertex_weights, weights, chord_count)
