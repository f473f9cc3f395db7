"""Adjoint of stage 3: dL/d(winding) of the pixels -> dL/d(vertices), by a boundary integral along each edge.

Moving an edge's points by (u, v) changes the winding of a pixel that it crosses by the integral of (dx v - dy u) ds
over the part of the edge in that pixel. The edge's start has the weight 1 - s, its end s. A pixel that no edge crosses
has no derivative with respect to positions.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warpvec.kernels import edges
from warpvec.kernels.constants import COLUMNS, PARTIAL, TILE
from warpvec.kernels.lanes import Lanes, stage_module


@cache
def make_kernels(lanes: Lanes) -> SimpleNamespace:
    """Return ``integrate_edges``."""
    dtype, vec2, vec4, vector = lanes.dtype, lanes.vec2, lanes.vec4, lanes.vector
    add, mul, fma, sub = lanes.add, lanes.mul, lanes.fma, lanes.sub
    minimum, maximum, spread, total = lanes.minimum, lanes.maximum, lanes.spread, lanes.total
    functions = edges.make_functions(lanes)
    inverse, column_range, row_range = functions.inverse, functions.column_range, functions.row_range
    row_crossing = functions.row_crossing
    blocks = wp.constant(lanes.blocks)
    width = wp.constant(lanes.width)
    height = wp.constant(dtype(lanes.width))
    zero, half, one = wp.constant(dtype(0.0)), wp.constant(dtype(0.5)), wp.constant(dtype(1.0))
    module = stage_module("coverage_adjoint", lanes)

    @wp.func
    def edge_moments(
        v0: vec2,
        v1: vec2,
        box: wp.vec4i,
        first_pair: int,
        pair_class: wp.array(dtype=int),
        pair_slot: wp.array(dtype=int),
        adj_winding: wp.array(dtype=vector),
    ):
        """Return the integrals of adj_winding and of s adj_winding along the edge, over its partial pairs."""
        inv_dx = inverse(v1[0] - v0[0])
        inv_dy = inverse(v1[1] - v0[1])
        sum0 = spread(zero)
        sum1 = spread(zero)
        rows = row_range(v0, v1, box[1], box[3])
        for strip in range(rows[0] * blocks, (rows[1] + 1) * blocks):
            tile_row = strip // blocks
            block = strip % blocks
            top = dtype(tile_row * TILE + block * width)
            upper = row_crossing(top, v0[1], inv_dy)
            lower = row_crossing(top + one, v0[1], inv_dy)
            row_low = minimum(upper, lower)
            row_high = maximum(upper, lower)
            touched = column_range(v0, v1, top, top + height)
            column = wp.max(touched[0], box[0] * TILE)
            last = wp.min(touched[1], box[2] * TILE - 1)
            pair0 = first_pair + (tile_row - box[1]) * (box[2] - box[0]) - box[0]
            cross = (dtype(column) - v0[0]) * inv_dx
            while column <= last:
                following = (dtype(column + 1) - v0[0]) * inv_dx
                pair = pair0 + column // TILE
                if pair_class[pair] == PARTIAL:
                    low = maximum(row_low, spread(wp.min(cross, following)))
                    high = minimum(row_high, spread(wp.max(cross, following)))
                    part = maximum(sub(high, low), spread(zero))
                    adj = mul(part, adj_winding[(pair_slot[pair] * COLUMNS + column % TILE) * blocks + block])
                    sum0 = add(sum0, adj)
                    sum1 = fma(adj, mul(add(low, high), spread(half)), sum1)
                cross = following
                column += 1
        return vec2(total(sum0), total(sum1))

    @wp.kernel(module=module)
    def integrate_edges(
        first: int,
        vertices: wp.array(dtype=vec2),  # [V] px
        segment_first_vertex: wp.array(dtype=int),  # [R + 1]
        segment_path: wp.array(dtype=int),  # [R]
        segment_next: wp.array(dtype=int),  # [R]
        path_tile_box: wp.array(dtype=wp.vec4i),  # [N]
        path_first_pair: wp.array(dtype=int),  # [N + 1]
        pair_class: wp.array(dtype=int),  # [K]
        pair_slot: wp.array(dtype=int),  # [K + 1]
        adj_winding: wp.array(dtype=vector),  # [slots, COLUMNS, TILE / width]
        # outputs
        adj_edges: wp.array(dtype=vec4),  # [V] dL/d(start), dL/d(end)
    ):
        """Write dL/d(start) and dL/d(end) of each edge of one segment."""
        segment = first + wp.tid()
        path = segment_path[segment]
        box = path_tile_box[path]
        start = segment_first_vertex[segment]
        end = segment_first_vertex[segment + 1]
        for v in range(start, end):
            following = v + 1
            if following == end:
                following = segment_first_vertex[segment_next[segment]]
            adjoint = vec4()
            if box[2] > box[0]:
                v0 = vertices[v]
                v1 = vertices[following]
                moments = edge_moments(v0, v1, box, path_first_pair[path], pair_class, pair_slot, adj_winding)
                w0 = moments[0] - moments[1]
                w1 = moments[1]
                dx = v1[0] - v0[0]
                dy = v1[1] - v0[1]
                adjoint = vec4(-dy * w0, dx * w0, -dy * w1, dx * w1)
            adj_edges[v] = adjoint

    return SimpleNamespace(integrate_edges=integrate_edges)
