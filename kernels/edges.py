"""The pixel rows and columns that a straight edge crosses, and where it crosses them.

An edge runs from v0 to v1 with parameter s in [0, 1]. The crossing of a row by a horizontal edge, or of a column by a
vertical one, would divide by zero. FLAT_EDGE in the denominator puts that crossing far outside [0, 1] on the correct
side. Such an edge then belongs to exactly one row or column, as rows and columns are half-open intervals.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warpvec.kernels.constants import COLUMN_GUARD, COLUMN_GUARD_SLOPE, COORDINATE_MAX, FLAT_EDGE, TILE
from warpvec.kernels.lanes import Lanes


@cache
def make_functions(lanes: Lanes) -> SimpleNamespace:
    """Return the scalar and lane functions of an edge in the precision of ``lanes``."""
    dtype, vec2 = lanes.dtype, lanes.vec2
    minimum, maximum, mul, sub, spread, ramp_from = (
        lanes.minimum, lanes.maximum, lanes.mul, lanes.sub, lanes.spread, lanes.ramp_from
    )  # fmt: skip
    flat_edge = wp.constant(dtype(FLAT_EDGE))
    guard = wp.constant(dtype(COLUMN_GUARD))
    guard_per_length = wp.constant(dtype(COLUMN_GUARD_SLOPE))
    farthest = wp.constant(dtype(COORDINATE_MAX))
    side = wp.constant(dtype(TILE))
    zero, one = wp.constant(dtype(0.0)), wp.constant(dtype(1.0))

    @wp.func
    def inverse(difference: dtype):
        """Return 1 / difference, or 1 / FLAT_EDGE near zero: the inverse of a denormal would be infinite."""
        flat = wp.where(difference < zero, -flat_edge, flat_edge)
        return one / wp.where(wp.abs(difference) < flat_edge, flat, difference)

    @wp.func
    def column_range(v0: vec2, v1: vec2, top: dtype, bottom: dtype):
        """Return the first and last pixel column that the edge may touch between y = ``top`` and y = ``bottom``."""
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
        """Return the first and last tile row in [first_row, end_row) that the edge touches; none if first > last."""
        low = wp.floor(wp.min(v0[1], v1[1]) / side)
        high = wp.floor(wp.max(v0[1], v1[1]) / side)
        return wp.vec2i(wp.max(int(low), first_row), wp.min(int(high), end_row - 1))

    @wp.func
    def row_crossing(row: dtype, y0: dtype, inv_dy: dtype):
        """Return s in [0, 1] where the edge meets the upper border of each lane's row; lane 0 is ``row``."""
        s = mul(sub(ramp_from(row), spread(y0)), spread(inv_dy))
        return minimum(maximum(s, spread(zero)), spread(one))

    return SimpleNamespace(inverse=inverse, column_range=column_range, row_range=row_range, row_crossing=row_crossing)
