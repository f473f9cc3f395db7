"""Straight edges: the pixel columns that one may touch, and the walk through the pixels that it crosses.

A lane is an edge. An edge runs from (x0, y0) to (x1, y1) with parameter s in [0, 1]. The crossing of a row by a
horizontal edge, or of a column by a vertical one, would divide by zero. FLAT_EDGE in the denominator puts that crossing
far outside [0, 1] on the correct side. Such an edge then belongs to exactly one row or column, as rows and columns are
half-open intervals.

A walk starts at the edge's left end and goes right, so its parameter t is s or 1 - s. A step ends at the nearer of two
borders: the right border of the pixel, and the border of the row that lies ahead. What the step passes is the part of
the edge in that pixel.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warpvec.kernels.constants import COLUMN_GUARD, COLUMN_GUARD_SLOPE, COLUMNS, COORDINATE_MAX, FLAT_EDGE, TILE
from warpvec.kernels.index_lanes import make_index_lanes
from warpvec.kernels.lanes import Lanes

TILE_BITS = TILE.bit_length() - 1
"""A pixel's tile is its row or column shifted right by this."""


@cache
def make_functions(lanes: Lanes) -> SimpleNamespace:
    """Return the functions of edges: ``inverse``, ``column_range``, ``end_points``, and those of the walk."""
    dtype, vec2, vector = lanes.dtype, lanes.vec2, lanes.vector
    add, sub, mul, fma, quotient = lanes.add, lanes.sub, lanes.mul, lanes.fma, lanes.quotient
    minimum, maximum, spread, where_less = lanes.minimum, lanes.maximum, lanes.spread, lanes.where_less
    ints = make_index_lanes(lanes)
    whole, spread_whole, floor_whole, real_of = ints.whole, ints.spread_whole, ints.floor_whole, ints.real_of
    whole_add, whole_fma, whole_min, whole_max = ints.whole_add, ints.whole_fma, ints.whole_min, ints.whole_max
    whole_shift, whole_and, whole_where_less = ints.whole_shift, ints.whole_and, ints.whole_where_less
    gather_whole, gather_x, gather_y = ints.gather_whole, ints.gather_x, ints.gather_y
    flat_edge, farthest = wp.constant(dtype(FLAT_EDGE)), wp.constant(dtype(COORDINATE_MAX))
    guard, guard_per_length = wp.constant(dtype(COLUMN_GUARD)), wp.constant(dtype(COLUMN_GUARD_SLOPE))
    zero, one = wp.constant(dtype(0.0)), wp.constant(dtype(1.0))
    bits, low_bits = wp.constant(TILE_BITS), wp.constant(TILE - 1)

    @wp.func
    def magnitude(value: vector):
        return maximum(value, sub(spread(zero), value))

    @wp.func
    def inverse(difference: vector):
        """Return 1 / difference, or 1 / FLAT_EDGE near zero: the inverse of a denormal would be infinite."""
        flat = where_less(difference, spread(zero), spread(-flat_edge), spread(flat_edge))
        return quotient(spread(one), where_less(magnitude(difference), spread(flat_edge), flat, difference))

    @wp.func
    def column_range(x0: vector, y0: vector, x1: vector, y1: vector, top: vector, bottom: vector):
        """Return the first and last pixel column that the edge may touch between y = ``top`` and y = ``bottom``."""
        inv_dy = inverse(sub(y1, y0))
        dx = sub(x1, x0)
        xa = fma(dx, minimum(maximum(mul(sub(top, y0), inv_dy), spread(zero)), spread(one)), x0)
        xb = fma(dx, minimum(maximum(mul(sub(bottom, y0), inv_dy), spread(zero)), spread(one)), x0)
        margin = fma(spread(guard_per_length), magnitude(dx), spread(guard))
        low = maximum(sub(minimum(xa, xb), margin), spread(-farthest))
        high = minimum(add(maximum(xa, xb), margin), spread(farthest))
        return floor_whole(low), floor_whole(high)

    @wp.func
    def end_points(vertices: wp.array(dtype=vec2), edge_end: wp.array(dtype=int), edge: whole):
        """Return x0, y0, x1, y1 of the edges that start at the vertices ``edge``."""
        end = gather_whole(edge_end, edge)
        return gather_x(vertices, edge), gather_y(vertices, edge), gather_x(vertices, end), gather_y(vertices, end)

    @wp.func
    def left_end(x0: vector, y0: vector, x1: vector, y1: vector):
        """Return x, y, dx and dy of the edge as it is walked."""
        x = minimum(x0, x1)
        y = where_less(x1, x0, y1, y0)
        return x, y, sub(maximum(x0, x1), x), sub(where_less(x1, x0, y0, y1), y)

    @wp.func
    def crossing(border: whole, start: vector, inv_difference: vector):
        """Return t where the edge crosses a border of rows or columns."""
        return mul(sub(real_of(border), start), inv_difference)

    @wp.func
    def between(first_row: whole, end_row: whole, y: vector, inv_dy: vector):
        """Return the range of t in which the edge lies in the rows [first_row, end_row); it may be empty."""
        upper, lower = crossing(first_row, y, inv_dy), crossing(end_row, y, inv_dy)
        return maximum(minimum(upper, lower), spread(zero)), minimum(maximum(upper, lower), spread(one))

    @wp.func
    def pixel_at(t: vector, start: vector, difference: vector, first: whole, end: whole):
        """Return the row or column in [first, end) where the edge is at t."""
        return whole_min(whole_max(floor_whole(fma(difference, t, start)), first), whole_add(end, spread_whole(-1)))

    @wp.func
    def row_ahead(dy: vector):
        """Return what to add to a row for the border that lies ahead: 1 on the way down, else 0."""
        return whole_where_less(dy, spread(zero), spread_whole(0), spread_whole(1))

    @wp.func
    def step_ends(column: whole, row: whole, ahead: whole, x: vector, y: vector, inv_dx: vector, inv_dy: vector):
        """Return t at the pixel's right border, and at the border of its row that lies ahead."""
        return (
            crossing(whole_add(column, spread_whole(1)), x, inv_dx),
            crossing(whole_add(row, ahead), y, inv_dy),
        )

    @wp.func
    def next_pixel(column: whole, row: whole, ahead: whole, across: vector, down: vector):
        """Return column and row of the pixel behind the nearer border."""
        row_step = whole_fma(ahead, spread_whole(2), spread_whole(-1))
        right = whole_add(column, whole_where_less(across, down, spread_whole(1), spread_whole(0)))
        return right, whole_add(row, whole_where_less(across, down, spread_whole(0), row_step))

    @wp.func
    def pair_of(column: whole, row: whole, row_pairs: whole, origin: whole):
        """Return the pair of a pixel's tile: ``row_pairs`` pairs a row of tiles; ``origin`` is that of tile (0, 0)."""
        tile_row = whole_fma(whole_shift(row, spread_whole(bits)), row_pairs, origin)
        return whole_add(tile_row, whole_shift(column, spread_whole(bits)))

    @wp.func
    def place_in(slot: whole, column: whole, row: whole):
        """Return the index of a pixel's value in the slots, which are [slots, COLUMNS, TILE]."""
        mask, side = spread_whole(low_bits), spread_whole(TILE)
        place = whole_fma(whole_and(column, mask), side, whole_and(row, mask))
        return whole_fma(slot, spread_whole(wp.static(COLUMNS * TILE)), place)

    functions = (inverse, column_range, end_points, left_end, crossing, between, pixel_at, row_ahead)
    functions += (step_ends, next_pixel, pair_of, place_in, magnitude)
    return SimpleNamespace(**{function.func.__name__: function for function in functions})
