"""Straight edges: find the pixel columns that an edge may touch, and walk through the pixels on its way.

A lane is an edge. An edge runs from (x0, y0) to (x1, y1) with parameter s in [0, 1]. The crossing of a row by a
horizontal edge, or of a column by a vertical one, would divide by zero. FLAT_EDGE in the denominator puts that crossing
far outside [0, 1] on the correct side. Such an edge then belongs to exactly one row or column, as rows and columns are
half-open intervals.

A walk starts at the edge's left end and goes right, so its parameter t is s or 1 - s. A step ends at the nearer of two
borders: the right border of the pixel, and the border of the row that lies ahead. What the step passes is the part of
the edge in that pixel.
"""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels.constants import COLUMN_GUARD, COLUMN_GUARD_SLOPE, COLUMNS, COORDINATE_MAX, FLAT_EDGE, TILE
from warpvec.kernels.lanes import Lanes, bundle
from warpvec.kernels.making import made_once

TILE_BITS = TILE.bit_length() - 1
"""A pixel's tile is its row or column shifted right by this."""


@made_once
def make_functions(lanes: Lanes) -> SimpleNamespace:
    """Return the functions of edges: ``inverse``, ``column_range``, ``end_points``, and those of the walk."""
    dtype, vec2, vector = lanes.dtype, lanes.vec2, lanes.vector
    v = lanes.functions
    whole = lanes.whole
    flat_edge, farthest = wp.constant(dtype(FLAT_EDGE)), wp.constant(dtype(COORDINATE_MAX))
    guard, guard_per_length = wp.constant(dtype(COLUMN_GUARD)), wp.constant(dtype(COLUMN_GUARD_SLOPE))
    zero, one = wp.constant(dtype(0.0)), wp.constant(dtype(1.0))
    bits, low_bits = wp.constant(TILE_BITS), wp.constant(TILE - 1)

    @wp.func
    def magnitude(value: vector):
        return v.maximum(value, v.sub(v.spread(zero), value))

    @wp.func
    def inverse(difference: vector):
        """Return 1 / difference, or 1 / FLAT_EDGE near zero: the inverse of a denormal would be infinite."""
        flat = v.where_less(difference, v.spread(zero), v.spread(-flat_edge), v.spread(flat_edge))
        return v.quotient(v.spread(one), v.where_less(magnitude(difference), v.spread(flat_edge), flat, difference))

    @wp.func
    def column_range(x0: vector, y0: vector, x1: vector, y1: vector, top: vector, bottom: vector):
        """Return the first and last pixel column that the edge may touch between y = ``top`` and y = ``bottom``."""
        inv_dy = inverse(v.sub(y1, y0))
        dx = v.sub(x1, x0)
        xa = v.fma(dx, v.minimum(v.maximum(v.mul(v.sub(top, y0), inv_dy), v.spread(zero)), v.spread(one)), x0)
        xb = v.fma(dx, v.minimum(v.maximum(v.mul(v.sub(bottom, y0), inv_dy), v.spread(zero)), v.spread(one)), x0)
        margin = v.fma(v.spread(guard_per_length), magnitude(dx), v.spread(guard))
        low = v.maximum(v.sub(v.minimum(xa, xb), margin), v.spread(-farthest))
        high = v.minimum(v.add(v.maximum(xa, xb), margin), v.spread(farthest))
        return v.floor_whole(low), v.floor_whole(high)

    @wp.func
    def end_points(vertices: wp.array(dtype=vec2), edge_end: wp.array(dtype=int), edge: whole):
        """Return x0, y0, x1, y1 of the edges that start at the vertices ``edge``."""
        end = v.gather_whole(edge_end, edge)
        return (
            v.gather_x(vertices, edge),
            v.gather_y(vertices, edge),
            v.gather_x(vertices, end),
            v.gather_y(vertices, end),
        )

    @wp.func
    def left_end(x0: vector, y0: vector, x1: vector, y1: vector):
        """Return x, y, dx and dy of the edge as it is walked."""
        x = v.minimum(x0, x1)
        y = v.where_less(x1, x0, y1, y0)
        return x, y, v.sub(v.maximum(x0, x1), x), v.sub(v.where_less(x1, x0, y0, y1), y)

    @wp.func
    def crossing(border: whole, start: vector, inv_difference: vector):
        """Return t where the edge crosses a border of rows or columns."""
        return v.mul(v.sub(v.real_of(border), start), inv_difference)

    @wp.func
    def between(first_row: whole, end_row: whole, y: vector, inv_dy: vector):
        """Return the range of t in which the edge lies in the rows [first_row, end_row); it may be empty."""
        upper, lower = crossing(first_row, y, inv_dy), crossing(end_row, y, inv_dy)
        return v.maximum(v.minimum(upper, lower), v.spread(zero)), v.minimum(v.maximum(upper, lower), v.spread(one))

    @wp.func
    def pixel_at(t: vector, start: vector, difference: vector, first: whole, end: whole):
        """Return the row or column in [first, end) where the edge is at t."""
        return v.whole_min(
            v.whole_max(v.floor_whole(v.fma(difference, t, start)), first), v.whole_add(end, v.spread_whole(-1))
        )

    @wp.func
    def row_ahead(dy: vector):
        """Return what to add to a row for the border that lies ahead: 1 on the way down, else 0."""
        return v.whole_where_less(dy, v.spread(zero), v.spread_whole(0), v.spread_whole(1))

    @wp.func
    def step_ends(column: whole, row: whole, ahead: whole, x: vector, y: vector, inv_dx: vector, inv_dy: vector):
        """Return t at the pixel's right border, and at the border of its row that lies ahead."""
        return (
            crossing(v.whole_add(column, v.spread_whole(1)), x, inv_dx),
            crossing(v.whole_add(row, ahead), y, inv_dy),
        )

    @wp.func
    def next_pixel(column: whole, row: whole, ahead: whole, across: vector, down: vector):
        """Return column and row of the pixel behind the nearer border."""
        row_step = v.whole_fma(ahead, v.spread_whole(2), v.spread_whole(-1))
        right = v.whole_add(column, v.whole_where_less(across, down, v.spread_whole(1), v.spread_whole(0)))
        return right, v.whole_add(row, v.whole_where_less(across, down, v.spread_whole(0), row_step))

    @wp.func
    def pair_of(column: whole, row: whole, row_pairs: whole, origin: whole):
        """Return the pair of a pixel's tile: ``row_pairs`` pairs a row of tiles; ``origin`` is that of tile (0, 0)."""
        tile_row = v.whole_fma(v.whole_shift(row, v.spread_whole(bits)), row_pairs, origin)
        return v.whole_add(tile_row, v.whole_shift(column, v.spread_whole(bits)))

    @wp.func
    def place_in(slot: whole, column: whole, row: whole):
        """Return the index of a pixel's value in the slots, which are [slots, COLUMNS, TILE]."""
        mask, side = v.spread_whole(low_bits), v.spread_whole(TILE)
        place = v.whole_fma(v.whole_and(column, mask), side, v.whole_and(row, mask))
        return v.whole_fma(slot, v.spread_whole(wp.static(COLUMNS * TILE)), place)

    walk = (left_end, crossing, between, pixel_at, row_ahead, step_ends, next_pixel, pair_of, place_in)
    return bundle(magnitude, inverse, column_range, end_points, *walk)
