"""Stage 2, binning: vertices -> (path, tile) pairs, their class, and each tile's pairs in z order. No gradient.

A path's bounding box, in tiles, is cut into strips, one per tile row. Pairs are numbered path by path, strip by strip,
left to right. A tile that an edge touches is partial. Any other tile has the same winding number everywhere: that of
its left neighbour, plus the edges that cross the middle of the strip between the two. A lane is an edge, which looks
only at the strips that it touches.

On the CPU a work item is a path (``classify_pairs``). On scalar lanes, the GPU's, a path would keep one thread busy for
long, so a work item is an edge (``mark_pairs``), then a strip (``classify_strips``).

Sorting puts the pairs of each tile next to one another, lowest path first. A position in that sorted list is a *hit*.
"""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels import edges
from warpvec.kernels.constants import COORDINATE_MAX, EMPTY, FULL, PARTIAL, TILE
from warpvec.kernels.lanes import Lanes, bundle, stage_module
from warpvec.kernels.making import made_once


@made_once
def make_functions(lanes: Lanes) -> SimpleNamespace:
    """Return ``tile_box``, which stages share that bound paths."""
    dtype, vec2 = lanes.dtype, lanes.vec2
    side, zero = wp.constant(dtype(TILE)), wp.constant(dtype(0.0))

    @wp.func
    def tile_of(coordinate: dtype, tile_count: int):
        """Return the tile of a coordinate, clamped to [0, tile_count]."""
        tile = wp.floor(coordinate / side)
        return int(wp.clamp(tile, zero, dtype(tile_count)))

    @wp.func
    def tile_box(low: vec2, high: vec2, is_wild: bool, tile_rows: int, tile_columns: int):
        """Return the tiles of a box of pixels, the last two exclusive; none if it is off the canvas or not finite."""
        left, top = tile_of(low[0], tile_columns), tile_of(low[1], tile_rows)
        right = wp.min(tile_of(high[0], tile_columns) + 1, tile_columns)
        bottom = wp.min(tile_of(high[1], tile_rows) + 1, tile_rows)
        off_canvas = high[0] <= zero or high[1] <= zero or left >= right or top >= bottom
        if off_canvas or is_wild:
            right = left
            bottom = top
        return wp.vec4i(left, top, right, bottom)

    return bundle(tile_box)


@made_once
def make_kernels(lanes: Lanes) -> SimpleNamespace:
    """Return ``bound_paths``, ``list_strips``, the kernels that classify pairs, and ``find_tile_ranges``."""
    dtype, vec2 = lanes.dtype, lanes.vec2
    v = lanes.functions
    walk, boxes = edges.make_functions(lanes), make_functions(lanes)
    width, bits = wp.constant(lanes.width), wp.constant(edges.TILE_BITS)
    half_side, per_side = wp.constant(dtype(TILE / 2)), wp.constant(dtype(1 / TILE))
    farthest, side = wp.constant(dtype(COORDINATE_MAX)), wp.constant(dtype(TILE))
    module = stage_module("binning", lanes)

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
        start = segment_first_vertex[loop_first_segment[path_first_loop[path]]]
        end = segment_first_vertex[loop_first_segment[path_first_loop[path + 1]]]
        most_left, most_right = v.spread(farthest), v.spread(-farthest)
        highest, lowest = v.spread(farthest), v.spread(-farthest)
        wild = v.spread(dtype(0.0))
        for group in range((end - start + width - 1) // width):
            vertex = v.whole_min(v.lane_numbers(start + group * width), v.spread_whole(end - 1))
            x, y = v.gather_x(vertices, vertex), v.gather_y(vertices, vertex)
            most_left, most_right = v.minimum(x, most_left), v.maximum(x, most_right)
            highest, lowest = v.minimum(y, highest), v.maximum(y, lowest)
            # A comparison with what is not a number is false.
            wild = v.where_less(walk.magnitude(x), v.spread(farthest), wild, v.spread(dtype(1.0)))
            wild = v.where_less(walk.magnitude(y), v.spread(farthest), wild, v.spread(dtype(1.0)))
        low = vec2(
            -v.lane_max(v.sub(v.spread(dtype(0.0)), most_left)), -v.lane_max(v.sub(v.spread(dtype(0.0)), highest))
        )
        high = vec2(v.lane_max(most_right), v.lane_max(lowest))
        box = boxes.tile_box(low, high, v.lane_max(wild) > dtype(0.0), tile_rows, tile_columns)
        path_tile_box[path] = box
        path_strip_count[path] = box[3] - box[1]
        path_pair_count[path] = (box[3] - box[1]) * (box[2] - box[0])

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

    @wp.func
    def mark_edges(
        start: int,
        end: int,
        vertices: wp.array(dtype=vec2),
        edge_end: wp.array(dtype=int),
        box: wp.vec4i,
        pair0: int,
        pair_winding: wp.array(dtype=int),
        pair_is_partial: wp.array(dtype=int),
    ):
        """Mark the tiles that the edges of a path touch, and note where they change the winding of a tile row."""
        none, unit, minus = v.spread_whole(0), v.spread_whole(1), v.spread_whole(-1)
        left, right, row_pairs = v.spread_whole(box[0]), v.spread_whole(box[2] - 1), v.spread_whole(box[2] - box[0])
        first_row, last_row, path_pair = v.spread_whole(box[1]), v.spread_whole(box[3] - 1), v.spread_whole(pair0)
        origin = v.spread_whole(pair0 - box[1] * (box[2] - box[0]) - box[0])
        for group in range((end - start + width - 1) // width):
            lane = v.lane_numbers(start + group * width)
            x0, y0, x1, y1 = walk.end_points(vertices, edge_end, v.whole_min(lane, v.spread_whole(end - 1)))
            # An edge that ends on the border of two tile rows touches both: the first row is ceil(y / TILE) - 1.
            ceiling = v.whole_fma(v.floor_whole(v.mul(v.minimum(y0, y1), v.spread(-per_side))), minus, none)
            row = v.whole_max(v.whole_add(ceiling, minus), first_row)
            row_end = v.whole_min(v.floor_whole(v.mul(v.maximum(y0, y1), v.spread(per_side))), last_row)
            while v.any_whole_less(row, v.whole_add(row_end, unit)):
                top = v.mul(v.real_of(row), v.spread(side))
                row_origin = v.whole_fma(row, row_pairs, origin)
                first_column, last_column = walk.column_range(x0, y0, x1, y1, top, v.add(top, v.spread(side)))
                touched = v.whole_max(v.whole_shift(first_column, v.spread_whole(bits)), left)
                touched_end = v.whole_add(
                    v.whole_min(v.whole_shift(last_column, v.spread_whole(bits)), right), row_origin
                )
                touched = v.whole_add(touched, row_origin)
                is_touched = v.where_whole_less(
                    row_end, row, none, v.where_whole_less(touched_end, touched, none, unit)
                )
                # Places where nothing is marked only have to be the path's own.
                touched = v.where_whole_less(none, is_touched, touched, path_pair)
                touched_end = v.where_whole_less(none, is_touched, touched_end, path_pair)
                v.mark_places(pair_is_partial, is_touched, touched, touched_end)
                if v.any_whole_less(v.whole_add(touched, unit), touched_end):
                    v.mark_ranges(pair_is_partial, v.whole_add(touched, unit), v.whole_add(touched_end, minus))

                middle = v.add(top, v.spread(half_side))
                is_below0 = v.whole_where_less(middle, y0, unit, none)
                step = v.whole_fma(is_below0, minus, v.whole_where_less(middle, y1, unit, none))
                x = v.fma(v.sub(x1, x0), v.mul(v.sub(middle, y0), walk.inverse(v.sub(y1, y0))), x0)
                behind = v.whole_max(v.whole_add(v.floor_whole(v.mul(x, v.spread(per_side))), unit), left)
                step = v.where_whole_less(right, behind, none, step)
                step = v.where_whole_less(row_end, row, none, step)
                step = v.where_whole_less(lane, v.spread_whole(end), step, none)
                v.scatter_steps(pair_winding, v.whole_add(behind, row_origin), step)
                row = v.whole_add(row, unit)

    @wp.func
    def classify_row(
        path: int,
        pair0: int,
        tile0: int,
        tile_end: int,
        tile_count: int,
        pair_winding: wp.array(dtype=int),
        pair_is_partial: wp.array(dtype=int),
        pair_path: wp.array(dtype=int),
        pair_class: wp.array(dtype=int),
        pair_key: wp.array(dtype=int),
        pair_index: wp.array(dtype=int),
    ):
        """Find the class and the sort key of the pairs of a strip, which has the tiles [tile0, tile_end)."""
        winding = int(0)
        for tile in range(tile0, tile_end):
            pair = pair0 + tile - tile0
            winding += pair_winding[pair]
            pair_class_here = wp.where(winding != 0, FULL, EMPTY)
            if pair_is_partial[pair] == 1:
                pair_class_here = PARTIAL
            pair_path[pair] = path
            pair_class[pair] = pair_class_here
            pair_key[pair] = wp.where(pair_class_here == EMPTY, tile_count, tile)
            pair_index[pair] = pair

    @wp.kernel(module=module)
    def classify_pairs(
        first: int,
        vertices: wp.array(dtype=vec2),  # [V] px
        edge_end: wp.array(dtype=int),  # [V]
        segment_first_vertex: wp.array(dtype=int),  # [R + 1]
        loop_first_segment: wp.array(dtype=int),  # [L + 1]
        path_first_loop: wp.array(dtype=int),  # [N + 1]
        tile_columns: int,
        tile_count: int,
        path_tile_box: wp.array(dtype=wp.vec4i),  # [N]
        path_first_pair: wp.array(dtype=int),  # [N + 1]
        # outputs
        pair_path: wp.array(dtype=int),  # [K]
        pair_class: wp.array(dtype=int),  # [K]
        pair_winding: wp.array(dtype=int),  # [K] scratch
        pair_is_partial: wp.array(dtype=int),  # [K + 1]
        pair_key: wp.array(dtype=int),  # [K] tile, or tile_count for an empty pair
        pair_index: wp.array(dtype=int),  # [K] the pair itself, to be sorted by key
    ):
        """Find the class and the sort key of each pair of one path."""
        path = first + wp.tid()
        box = path_tile_box[path]
        if box[2] <= box[0]:
            return
        pair0 = path_first_pair[path]
        for pair in range(pair0, path_first_pair[path + 1]):
            pair_winding[pair] = 0
            pair_is_partial[pair] = 0
        start = segment_first_vertex[loop_first_segment[path_first_loop[path]]]
        end = segment_first_vertex[loop_first_segment[path_first_loop[path + 1]]]
        mark_edges(start, end, vertices, edge_end, box, pair0, pair_winding, pair_is_partial)
        for strip in range(box[3] - box[1]):
            strip_pair = pair0 + strip * (box[2] - box[0])
            tile0 = (box[1] + strip) * tile_columns
            classify_row(
                path, strip_pair, tile0 + box[0], tile0 + box[2], tile_count, pair_winding, pair_is_partial,
                pair_path, pair_class, pair_key, pair_index,
            )  # fmt: skip

    @wp.kernel(module=module)
    def mark_pairs(
        first: int,
        vertices: wp.array(dtype=vec2),  # [V] px
        edge_end: wp.array(dtype=int),  # [V]
        edge_path: wp.array(dtype=int),  # [V]
        segment_first_vertex: wp.array(dtype=int),  # [R + 1]
        segment_count: int,  # R
        path_tile_box: wp.array(dtype=wp.vec4i),  # [N]
        path_first_pair: wp.array(dtype=int),  # [N + 1]
        # in and out: zeros before the first edge
        pair_winding: wp.array(dtype=int),  # [K] change of the winding from the left neighbour to this tile
        pair_is_partial: wp.array(dtype=int),  # [K + 1]
    ):
        """Mark the tiles that one edge touches, and note where it changes the winding."""
        edge = first + wp.tid()
        if edge >= segment_first_vertex[segment_count]:
            return
        path = edge_path[edge]
        box, pair0 = path_tile_box[path], path_first_pair[path]
        if box[2] > box[0]:
            mark_edges(edge, edge + 1, vertices, edge_end, box, pair0, pair_winding, pair_is_partial)

    @wp.kernel(module=module)
    def classify_strips(
        first: int,
        tile_columns: int,
        tile_count: int,
        path_tile_box: wp.array(dtype=wp.vec4i),  # [N]
        path_first_strip: wp.array(dtype=int),  # [N + 1]
        path_first_pair: wp.array(dtype=int),  # [N + 1]
        strip_path: wp.array(dtype=int),  # [strips] -1: no path
        pair_winding: wp.array(dtype=int),  # [K]
        pair_is_partial: wp.array(dtype=int),  # [K + 1]
        # outputs
        pair_path: wp.array(dtype=int),  # [K]
        pair_class: wp.array(dtype=int),  # [K]
        pair_key: wp.array(dtype=int),  # [K] tile, or tile_count for an empty pair
        pair_index: wp.array(dtype=int),  # [K] the pair itself, to be sorted by key
    ):
        """Find the class and the sort key of each pair of one strip."""
        strip = first + wp.tid()
        path = strip_path[strip]
        if path < 0:
            return
        box = path_tile_box[path]
        row = strip - path_first_strip[path]
        tile0 = (box[1] + row) * tile_columns
        classify_row(
            path, path_first_pair[path] + row * (box[2] - box[0]), tile0 + box[0], tile0 + box[2], tile_count,
            pair_winding, pair_is_partial, pair_path, pair_class, pair_key, pair_index,
        )  # fmt: skip

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

    by_edge = (mark_pairs, classify_strips)
    return bundle(bound_paths, list_strips, *(by_edge if width == 1 else (classify_pairs,)), find_tile_ranges)
