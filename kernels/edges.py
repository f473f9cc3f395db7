"""One straight edge against pixel rows and columns: which it crosses, and the part of it inside each cell.

An edge runs from v0 to v1 with parameter s in [0, 1]. A horizontal or vertical edge has no quotient for the crossing
of a row or a column; FLAT_EDGE in the denominator sends the crossing far outside [0, 1] on the correct side, so that
such an edge belongs to exactly one row or column, the one that holds it half-open.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warpvec.kernels.constants import COLUMN_GUARD, COLUMN_GUARD_SLOPE, COORDINATE_MAX, FLAT_EDGE, TILE
from warpvec.kernels.lanes import Lanes


@cache
def make_functions(lanes: Lanes) -> SimpleNamespace:
    """Scalar and lane functions of an edge for the precision of ``lanes``."""
    dtype, vec2 = lanes.dtype, lanes.vec2
    least, most, mul, sub, spread, ramp_from = (
        lanes.least, lanes.most, lanes.mul, lanes.sub, lanes.spread, lanes.ramp_from
    )  # fmt: skip
    flat_edge = wp.constant(dtype(FLAT_EDGE))
    guard = wp.constant(dtype(COLUMN_GUARD))
    guard_per_length = wp.constant(dtype(COLUMN_GUARD_SLOPE))
    farthest = wp.constant(dtype(COORDINATE_MAX))
    side = wp.constant(dtype(TILE))
    zero, one = wp.constant(dtype(0.0)), wp.constant(dtype(1.0))

    @wp.func
    def inverse(difference: dtype):
        """1 / difference, or a huge number for a difference of nearly zero: a denormal's quotient would be infinite."""
        flat = wp.where(difference < zero, -flat_edge, flat_edge)
        return one / wp.where(wp.abs(difference) < flat_edge, flat, difference)

    @wp.func
    def column_range(v0: vec2, v1: vec2, top: dtype, bottom: dtype):
        """First and last pixel column that the edge may touch between the rows' borders ``top`` and ``bottom``."""
        inv_dy = inverse(v1[1] - v0[1])
        dx = v1[0] - v0[0]
        xa = v0[0] + dx * wp.clamp((top - v0[1]) * inv_dy, zero, one)
        xb = v0[0] + dx * wp.clamp((bottom - v0[1]) * inv_dy, zero, one)
        margin = guard + guard_per_length * wp.abs(dx)
        low = wp.max(wp.min(xa, xb) - margin, -farthest)
        high = wp.min(wp.max(xa, xb) + margin, farthest)
        return wp.vec2i(int(wp.floor(low)), int(wp.floor(high)))

    @wp.func
    def row_range(v0: vec2, v1: vec2, first_row: int, end_row: int):
        """First and last tile row in [first_row, end_row) that the edge touches; empty if first > last."""
        low = wp.floor(wp.min(v0[1], v1[1]) / side)
        high = wp.floor(wp.max(v0[1], v1[1]) / side)
        return wp.vec2i(wp.max(int(low), first_row), wp.min(int(high), end_row - 1))

    @wp.func
    def row_crossing(row: dtype, y0: dtype, inv_dy: dtype):
        """s in [0, 1] at which the edge meets the upper border of each lane's row, the first being ``row``."""
        s = mul(sub(ramp_from(row), spread(y0)), spread(inv_dy))
        return least(most(s, spread(zero)), spread(one))

    return SimpleNamespace(inverse=inverse, column_range=column_range, row_range=row_range, row_crossing=row_crossing)
