"""Adjoint of stage 3: dL/d(winding) of the pixels -> dL/d(vertices), by a boundary integral along each edge.

Moving an edge's points by (u, v) changes the winding of a pixel that it crosses by the integral of (dx v - dy u) ds
over the part of the edge in that pixel. The edge's start has the weight 1 - s, its end s. A pixel that no edge crosses
has no derivative with respect to positions.

A lane is an edge, which walks through the pixels that it crosses (``edges.py``).
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warpvec.kernels import edges
from warpvec.kernels.constants import COLUMNS, PARTIAL, TILE
from warpvec.kernels.index_lanes import make_index_lanes
from warpvec.kernels.lanes import Lanes, stage_module

FETCHED_SLOTS = 32
"""Slots of the next path that are brought to the cache: 35 KB, less than a core's first cache has."""


@cache
def make_kernels(lanes: Lanes) -> SimpleNamespace:
    """Return ``integrate_edges``."""
    dtype, vec2, vec4, vector = lanes.dtype, lanes.vec2, lanes.vec4, lanes.vector
    add, mul, fma, sub = lanes.add, lanes.mul, lanes.fma, lanes.sub
    minimum, maximum, spread, where_less = lanes.minimum, lanes.maximum, lanes.spread, lanes.where_less
    ints = make_index_lanes(lanes)
    lane_numbers, spread_whole, whole_fma, whole_min = (
        ints.lane_numbers, ints.spread_whole, ints.whole_fma, ints.whole_min
    )  # fmt: skip
    where_whole_less, whole_where_less, where_index_less = (
        ints.where_whole_less, ints.whole_where_less, ints.where_index_less
    )  # fmt: skip
    any_less, gather_whole, gather_box, gather_value = (
        ints.any_less, ints.gather_whole, ints.gather_box, ints.gather_value
    )  # fmt: skip
    scatter_vec4 = ints.scatter_vec4
    walk = edges.make_functions(lanes)
    end_points, left_end, inverse, crossing, between = (
        walk.end_points, walk.left_end, walk.inverse, walk.crossing, walk.between
    )  # fmt: skip
    pixel_at, row_ahead, step_ends, next_pixel = walk.pixel_at, walk.row_ahead, walk.step_ends, walk.next_pixel
    pair_of, place_in = walk.pair_of, walk.place_in
    prefetch = lanes.prefetch
    width, fetched_slots = wp.constant(lanes.width), wp.constant(FETCHED_SLOTS)
    zero, half = wp.constant(dtype(0.0)), wp.constant(dtype(0.5))
    module = stage_module("coverage_adjoint", lanes)

    @wp.func
    def fetch_next_path(
        edge0: int,
        edge_count: int,
        edge_path: wp.array(dtype=int),
        path_first_pair: wp.array(dtype=int),
        pair_slot: wp.array(dtype=int),
        adj_winding: wp.array(dtype=vector),
    ):
        """Bring the slots of a path that begins in the next two groups of edges to the cache (CPU)."""
        if wp.static(lanes.width > 1):
            soon = wp.min(edge0 + 3 * width, edge_count - 1)
            path = edge_path[soon]
            if edge_path[wp.min(edge0 + 2 * width, edge_count - 1)] != path:
                slot = pair_slot[path_first_pair[path]]
                end = wp.min(pair_slot[path_first_pair[path + 1]], slot + fetched_slots)
                for ahead in range(slot, end):
                    prefetch(adj_winding, ahead * COLUMNS)

    @wp.kernel(module=module)
    def integrate_edges(
        first: int,
        vertices: wp.array(dtype=vec2),  # [V] px
        edge_end: wp.array(dtype=int),  # [V]
        edge_path: wp.array(dtype=int),  # [V]
        segment_first_vertex: wp.array(dtype=int),  # [R + 1]
        segment_count: int,  # R
        path_tile_box: wp.array(dtype=wp.vec4i),  # [N]
        path_first_pair: wp.array(dtype=int),  # [N + 1]
        pair_class: wp.array(dtype=int),  # [K]
        pair_slot: wp.array(dtype=int),  # [K + 1]
        adj_winding: wp.array(dtype=vector),  # [slots, COLUMNS, TILE / width]
        # outputs
        adj_edges: wp.array(dtype=vec4),  # [V] dL/d(start), dL/d(end)
    ):
        """Write dL/d(start) and dL/d(end) of as many edges as there are lanes; lanes beyond the last edge repeat it."""
        edge0 = (first + wp.tid()) * width
        edge_count = segment_first_vertex[segment_count]
        if edge0 >= edge_count:
            return
        fetch_next_path(edge0, edge_count, edge_path, path_first_pair, pair_slot, adj_winding)
        edge = whole_min(lane_numbers(edge0), spread_whole(edge_count - 1))
        path = gather_whole(edge_path, edge)
        none, minus, side, partial = spread_whole(0), spread_whole(-1), spread_whole(TILE), spread_whole(PARTIAL)
        left, top = gather_box(path_tile_box, path, 0), gather_box(path_tile_box, path, 1)
        right, bottom = gather_box(path_tile_box, path, 2), gather_box(path_tile_box, path, 3)
        row_pairs = whole_fma(left, minus, right)
        origin = whole_fma(whole_fma(top, row_pairs, left), minus, gather_whole(path_first_pair, path))
        left, top = whole_fma(left, side, none), whole_fma(top, side, none)
        right, bottom = whole_fma(right, side, none), whole_fma(bottom, side, none)

        x0, y0, x1, y1 = end_points(vertices, edge_end, edge)
        # The edges of a path without pairs may not be finite.
        x0, y0 = where_index_less(left, right, x0, spread(zero)), where_index_less(left, right, y0, spread(zero))
        x1, y1 = where_index_less(left, right, x1, spread(zero)), where_index_less(left, right, y1, spread(zero))
        x, y, dx, dy = left_end(x0, y0, x1, y1)
        inv_dx, inv_dy = inverse(dx), inverse(dy)
        low, end = between(top, bottom, y, inv_dy)
        low, end = maximum(low, crossing(left, x, inv_dx)), minimum(end, crossing(right, x, inv_dx))
        column, row, ahead = pixel_at(low, x, dx, left, right), pixel_at(low, y, dy, top, bottom), row_ahead(dy)
        sum0, sum1 = spread(zero), spread(zero)
        while any_less(low, end):
            across, down = step_ends(column, row, ahead, x, y, inv_dx, inv_dy)
            high = maximum(low, minimum(end, minimum(across, down)))
            # A lane that has arrived looks at pair 0, and so at a place that exists.
            pair = whole_where_less(low, end, pair_of(column, row, row_pairs, origin), none)
            kind = gather_whole(pair_class, pair)
            place = place_in(gather_whole(pair_slot, pair), column, row)
            value = gather_value(adj_winding, where_whole_less(kind, partial, none, place))
            value = where_index_less(kind, partial, spread(zero), value)
            adj = where_less(low, high, mul(sub(high, low), value), spread(zero))
            sum0 = add(sum0, adj)
            sum1 = fma(adj, mul(add(low, high), spread(half)), sum1)
            column, row = next_pixel(column, row, ahead, across, down)
            low = high
        at_left, at_right = sub(sum0, sum1), sum1
        w0 = where_less(x1, x0, at_right, at_left)
        w1 = where_less(x1, x0, at_left, at_right)
        dx, dy = sub(x1, x0), sub(y0, y1)
        scatter_vec4(adj_edges, edge, mul(dy, w0), mul(dx, w0), mul(dy, w1), mul(dx, w1))

    return SimpleNamespace(integrate_edges=integrate_edges)
