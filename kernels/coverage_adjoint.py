"""Adjoint of stage 3: dL/d(winding) of the pixels -> dL/d(vertices), by a boundary integral along each edge.

Moving an edge's points by (u, v) changes the winding of a pixel that it crosses by the integral of (dx v - dy u) ds
over the part of the edge in that pixel. The edge's start has the weight 1 - s, its end s. A pixel that no edge crosses
has no derivative with respect to positions.

A lane is an edge, which walks through the pixels that it crosses (``edges.py``).
"""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels import edges
from warpvec.kernels.constants import COLUMNS, PARTIAL, TILE
from warpvec.kernels.lanes import Lanes, bundle, stage_module
from warpvec.kernels.making import made_once

FETCHED_SLOTS = 32
"""Slots of the next path that are brought to the cache: 35 KB, less than a core's first cache has."""


@made_once
def make_kernels(lanes: Lanes) -> SimpleNamespace:
    """Return ``integrate_edges``."""
    dtype, vec2, vec4, vector = lanes.dtype, lanes.vec2, lanes.vec4, lanes.vector
    v = lanes.functions
    walk = edges.make_functions(lanes)
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
                    v.prefetch(adj_winding, ahead * COLUMNS)

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
        edge = v.whole_min(v.lane_numbers(edge0), v.spread_whole(edge_count - 1))
        path = v.gather_whole(edge_path, edge)
        none, minus = v.spread_whole(0), v.spread_whole(-1)
        side, partial = v.spread_whole(TILE), v.spread_whole(PARTIAL)
        left, top = v.gather_box(path_tile_box, path, 0), v.gather_box(path_tile_box, path, 1)
        right, bottom = v.gather_box(path_tile_box, path, 2), v.gather_box(path_tile_box, path, 3)
        row_pairs = v.whole_fma(left, minus, right)
        origin = v.whole_fma(v.whole_fma(top, row_pairs, left), minus, v.gather_whole(path_first_pair, path))
        left, top = v.whole_fma(left, side, none), v.whole_fma(top, side, none)
        right, bottom = v.whole_fma(right, side, none), v.whole_fma(bottom, side, none)

        x0, y0, x1, y1 = walk.end_points(vertices, edge_end, edge)
        # The edges of a path without pairs may not be finite.
        x0 = v.where_index_less(left, right, x0, v.spread(zero))
        y0 = v.where_index_less(left, right, y0, v.spread(zero))
        x1 = v.where_index_less(left, right, x1, v.spread(zero))
        y1 = v.where_index_less(left, right, y1, v.spread(zero))
        x, y, dx, dy = walk.left_end(x0, y0, x1, y1)
        inv_dx, inv_dy = walk.inverse(dx), walk.inverse(dy)
        low, end = walk.between(top, bottom, y, inv_dy)
        low, end = v.maximum(low, walk.crossing(left, x, inv_dx)), v.minimum(end, walk.crossing(right, x, inv_dx))
        column, row = walk.pixel_at(low, x, dx, left, right), walk.pixel_at(low, y, dy, top, bottom)
        ahead = walk.row_ahead(dy)
        sum0, sum1 = v.spread(zero), v.spread(zero)
        while v.any_less(low, end):
            across, down = walk.step_ends(column, row, ahead, x, y, inv_dx, inv_dy)
            high = v.maximum(low, v.minimum(end, v.minimum(across, down)))
            # A lane that has arrived looks at pair 0, and so at a place that exists.
            pair = v.whole_where_less(low, end, walk.pair_of(column, row, row_pairs, origin), none)
            kind = v.gather_whole(pair_class, pair)
            place = walk.place_in(v.gather_whole(pair_slot, pair), column, row)
            value = v.gather_value(adj_winding, v.where_whole_less(kind, partial, none, place))
            value = v.where_index_less(kind, partial, v.spread(zero), value)
            adj = v.where_less(low, high, v.mul(v.sub(high, low), value), v.spread(zero))
            sum0 = v.add(sum0, adj)
            sum1 = v.fma(adj, v.mul(v.add(low, high), v.spread(half)), sum1)
            column, row = walk.next_pixel(column, row, ahead, across, down)
            low = high
        at_left, at_right = v.sub(sum0, sum1), sum1
        w0 = v.where_less(x1, x0, at_right, at_left)
        w1 = v.where_less(x1, x0, at_left, at_right)
        dx, dy = v.sub(x1, x0), v.sub(y0, y1)
        v.scatter_vec4(adj_edges, edge, v.mul(dy, w0), v.mul(dx, w0), v.mul(dy, w1), v.mul(dx, w1))

    return bundle(integrate_edges)
