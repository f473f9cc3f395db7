"""Stage 2, binning: vertices -> (path, tile) pairs, their class, and each tile's pairs in z order. No gradient.

A path's bounding box, in tiles, is cut into strips, one per tile row. Pairs are numbered path by path, strip by strip,
left to right. A tile that an edge touches is partial. Any other tile has the same winding number everywhere: that of
its left neighbour, plus the edges that cross the middle of the strip between the two.

Sorting puts the pairs of each tile next to one another, lowest path first. A position in that sorted list is a *hit*.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warpvec.kernels import edges
from warpvec.kernels.constants import COORDINATE_MAX, EMPTY, FULL, PARTIAL, TILE
from warpvec.kernels.lanes import Lanes, stage_module


@cache
def make_kernels(lanes: Lanes) -> SimpleNamespace:
    """Return ``bound_paths``, ``list_strips``, ``classify_pairs`` and ``find_tile_ranges``."""
    dtype, vec2 = lanes.dtype, lanes.vec2
    column_range = edges.make_functions(lanes).column_range
    inverse = edges.make_functions(lanes).inverse
    farthest = wp.constant(dtype(COORDINATE_MAX))
    side = wp.constant(dtype(TILE))
    module = stage_module("binning", lanes)

    @wp.func
    def tile_of(coordinate: dtype, tile_count: int):
        """Return the tile of a coordinate, clamped to [0, tile_count]."""
        tile = wp.floor(coordinate / side)
        return int(wp.clamp(tile, dtype(0.0), dtype(tile_count)))

    @wp.kernel(module=module)
    def bound_paths(
        first: int,
        vertices: wp.array(dtype=vec2),  # [V] px
        segment_first_vertex: wp.array(dtype=int),  # [R + 1]
        loop_first_segment: wp.array(dtype=int),  # [L + 1]
        path_first_loop: wp.array(dtype=int),  # [N + 1]
        tile_rows: int,
        tile_columns: int,
        # outputs
        path_tile_box: wp.array(dtype=wp.vec4i),  # [N] left, top, right, bottom in tiles, the last two exclusive
        path_strip_count: wp.array(dtype=int),  # [N + 1]
        path_pair_count: wp.array(dtype=int),  # [N + 1]
    ):
        """Find the box of tiles of each path; it is empty if the path is off the canvas or not finite."""
        path = first + wp.tid()
        low = vec2(farthest, farthest)
        high = vec2(-farthest, -farthest)
        finite = bool(True)
        start = segment_first_vertex[loop_first_segment[path_first_loop[path]]]
        end = segment_first_vertex[loop_first_segment[path_first_loop[path + 1]]]
        for v in range(start, end):
            vertex = vertices[v]
            low = wp.min(low, vertex)
            high = wp.max(high, vertex)
            finite = finite and wp.abs(vertex[0]) < farthest and wp.abs(vertex[1]) < farthest
        left = tile_of(low[0], tile_columns)
        top = tile_of(low[1], tile_rows)
        right = wp.min(tile_of(high[0], tile_columns) + 1, tile_columns)
        bottom = wp.min(tile_of(high[1], tile_rows) + 1, tile_rows)
        off_canvas = high[0] <= dtype(0.0) or high[1] <= dtype(0.0) or left >= right or top >= bottom
        if off_canvas or not finite:
            right = left
            bottom = top
        path_tile_box[path] = wp.vec4i(left, top, right, bottom)
        path_strip_count[path] = bottom - top
        path_pair_count[path] = (bottom - top) * (right - left)

    @wp.kernel(module=module)
    def list_strips(
        first: int,
        path_first_strip: wp.array(dtype=int),  # [N + 1]
        # outputs
        strip_path: wp.array(dtype=int),  # [strips]
    ):
        """Write the path of each strip."""
        path = first + wp.tid()
        for strip in range(path_first_strip[path], path_first_strip[path + 1]):
            strip_path[strip] = path

    @wp.kernel(module=module)
    def classify_pairs(
        first: int,
        vertices: wp.array(dtype=vec2),  # [V] px
        segment_first_vertex: wp.array(dtype=int),  # [R + 1]
        loop_first_segment: wp.array(dtype=int),  # [L + 1]
        path_first_loop: wp.array(dtype=int),  # [N + 1]
        tile_columns: int,
        tile_count: int,
        path_tile_box: wp.array(dtype=wp.vec4i),  # [N]
        path_first_strip: wp.array(dtype=int),  # [N + 1]
        path_first_pair: wp.array(dtype=int),  # [N + 1]
        strip_path: wp.array(dtype=int),  # [strips] -1: no path
        # outputs
        pair_path: wp.array(dtype=int),  # [K]
        pair_class: wp.array(dtype=int),  # [K]
        pair_winding: wp.array(dtype=int),  # [K] scratch
        pair_is_partial: wp.array(dtype=int),  # [K + 1]
        pair_key: wp.array(dtype=int),  # [K] tile, or tile_count for an empty pair
        pair_index: wp.array(dtype=int),  # [K] the pair itself, to be sorted by key
    ):
        """Find the class and the sort key of each pair of a strip."""
        strip = first + wp.tid()
        path = strip_path[strip]
        if path < 0:
            return
        box = path_tile_box[path]
        tile_row = box[1] + strip - path_first_strip[path]
        columns = box[2] - box[0]
        pair0 = path_first_pair[path] + (strip - path_first_strip[path]) * columns
        for pair in range(pair0, pair0 + columns):
            pair_winding[pair] = 0
            pair_is_partial[pair] = 0
        top = dtype(tile_row * TILE)
        middle = top + dtype(0.5) * side
        bottom = top + side
        winding = int(0)
        for loop in range(path_first_loop[path], path_first_loop[path + 1]):
            start = segment_first_vertex[loop_first_segment[loop]]
            end = segment_first_vertex[loop_first_segment[loop + 1]]
            v0 = vertices[end - 1]
            for v in range(start, end):
                v1 = vertices[v]
                if wp.max(v0[1], v1[1]) >= top and wp.min(v0[1], v1[1]) <= bottom:
                    touched = column_range(v0, v1, top, bottom)
                    if touched[1] >= box[0] * TILE and touched[0] < box[2] * TILE:
                        for tile in range(
                            wp.max(touched[0], box[0] * TILE) // TILE, wp.min(touched[1], box[2] * TILE - 1) // TILE + 1
                        ):
                            pair_is_partial[pair0 + tile - box[0]] = 1
                    if (v0[1] <= middle) != (v1[1] <= middle):
                        step = wp.where(v1[1] > v0[1], 1, -1)
                        x = v0[0] + (v1[0] - v0[0]) * ((middle - v0[1]) * inverse(v1[1] - v0[1]))
                        tile = int(wp.floor(x / side)) + 1 - box[0]
                        if tile <= 0:
                            winding += step
                        elif tile < columns:
                            pair_winding[pair0 + tile] = pair_winding[pair0 + tile] + step
                v0 = v1
        for column in range(columns):
            pair = pair0 + column
            winding += pair_winding[pair]
            pair_class_here = wp.where(winding != 0, FULL, EMPTY)
            if pair_is_partial[pair] == 1:
                pair_class_here = PARTIAL
            pair_path[pair] = path
            pair_class[pair] = pair_class_here
            pair_key[pair] = wp.where(pair_class_here == EMPTY, tile_count, tile_row * tile_columns + box[0] + column)
            pair_index[pair] = pair

    @wp.kernel(module=module)
    def find_tile_ranges(
        first: int,
        hit_tile: wp.array(dtype=int),  # [K] sorted keys
        pair_count: int,  # K
        tile_count: int,
        # outputs
        tile_first_hit: wp.array(dtype=int),  # [tile_count + 1]
    ):
        """Write ``hit`` as the first hit of every tile after the previous hit's tile, up to and including its own."""
        hit = first + wp.tid()
        low = int(0)
        if hit > 0:
            low = hit_tile[hit - 1] + 1
        high = tile_count
        if hit < pair_count:
            high = hit_tile[hit]
        for tile in range(low, wp.min(high, tile_count) + 1):
            tile_first_hit[tile] = hit

    return SimpleNamespace(
        bound_paths=bound_paths,
        list_strips=list_strips,
        classify_pairs=classify_pairs,
        find_tile_ranges=find_tile_ranges,
    )
