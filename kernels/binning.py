"""Stage 2, binning: vertices -> (path, tile) pairs, their class, and each tile's pairs in z order. No gradient.

A path's bounding box, in tiles, is cut into strips, one per tile row. Pairs are numbered path by path, strip by strip,
left to right. A tile that an edge touches is partial. Any other tile has the same winding number everywhere: that of
its left neighbour, plus the edges that cross the middle of the strip between the two. A lane is an edge, which looks
only at the strips that it touches.

Sorting puts the pairs of each tile next to one another, lowest path first. A position in that sorted list is a *hit*.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warpvec.kernels import edges
from warpvec.kernels.constants import COORDINATE_MAX, EMPTY, FULL, PARTIAL, TILE
from warpvec.kernels.index_lanes import make_index_lanes
from warpvec.kernels.lanes import Lanes, stage_module


@cache
def make_kernels(lanes: Lanes) -> SimpleNamespace:
    """Return ``bound_paths``, ``list_strips``, ``classify_pairs`` and ``find_tile_ranges``."""
    dtype, vec2 = lanes.dtype, lanes.vec2
    add, sub, mul, fma, spread = lanes.add, lanes.sub, lanes.mul, lanes.fma, lanes.spread
    minimum, maximum = lanes.minimum, lanes.maximum
    ints = make_index_lanes(lanes)
    lane_numbers, spread_whole, real_of, floor_whole = (
        ints.lane_numbers, ints.spread_whole, ints.real_of, ints.floor_whole
    )  # fmt: skip
    whole_add, whole_fma, whole_min, whole_max, whole_shift = (
        ints.whole_add, ints.whole_fma, ints.whole_min, ints.whole_max, ints.whole_shift
    )  # fmt: skip
    where_whole_less, whole_where_less, any_whole_less = (
        ints.where_whole_less, ints.whole_where_less, ints.any_whole_less
    )  # fmt: skip
    mark_places, mark_ranges, scatter_steps = ints.mark_places, ints.mark_ranges, ints.scatter_steps
    gather_x, gather_y, where_less, lane_max = ints.gather_x, ints.gather_y, lanes.where_less, lanes.lane_max
    functions = edges.make_functions(lanes)
    column_range, end_points, inverse = functions.column_range, functions.end_points, functions.inverse
    magnitude = functions.magnitude
    width, bits = wp.constant(lanes.width), wp.constant(edges.TILE_BITS)
    half_side, per_side = wp.constant(dtype(TILE / 2)), wp.constant(dtype(1 / TILE))
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
        start = segment_first_vertex[loop_first_segment[path_first_loop[path]]]
        end = segment_first_vertex[loop_first_segment[path_first_loop[path + 1]]]
        most_left, most_right = spread(farthest), spread(-farthest)
        highest, lowest = spread(farthest), spread(-farthest)
        wild = spread(dtype(0.0))
        for group in range((end - start + width - 1) // width):
            vertex = whole_min(lane_numbers(start + group * width), spread_whole(end - 1))
            x, y = gather_x(vertices, vertex), gather_y(vertices, vertex)
            most_left, most_right = minimum(x, most_left), maximum(x, most_right)
            highest, lowest = minimum(y, highest), maximum(y, lowest)
            # A comparison with what is not a number is false.
            wild = where_less(magnitude(x), spread(farthest), wild, spread(dtype(1.0)))
            wild = where_less(magnitude(y), spread(farthest), wild, spread(dtype(1.0)))
        low = vec2(-lane_max(sub(spread(dtype(0.0)), most_left)), -lane_max(sub(spread(dtype(0.0)), highest)))
        high = vec2(lane_max(most_right), lane_max(lowest))
        left = tile_of(low[0], tile_columns)
        top = tile_of(low[1], tile_rows)
        right = wp.min(tile_of(high[0], tile_columns) + 1, tile_columns)
        bottom = wp.min(tile_of(high[1], tile_rows) + 1, tile_rows)
        off_canvas = high[0] <= dtype(0.0) or high[1] <= dtype(0.0) or left >= right or top >= bottom
        if off_canvas or lane_max(wild) > dtype(0.0):
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
        none, unit, minus = spread_whole(0), spread_whole(1), spread_whole(-1)
        left, right, row_pairs = spread_whole(box[0]), spread_whole(box[2] - 1), spread_whole(box[2] - box[0])
        first_row, last_row, path_pair = spread_whole(box[1]), spread_whole(box[3] - 1), spread_whole(pair0)
        origin = spread_whole(pair0 - box[1] * (box[2] - box[0]) - box[0])
        for group in range((end - start + width - 1) // width):
            lane = lane_numbers(start + group * width)
            x0, y0, x1, y1 = end_points(vertices, edge_end, whole_min(lane, spread_whole(end - 1)))
            # An edge that ends on the border of two tile rows touches both: the first row is ceil(y / TILE) - 1.
            ceiling = whole_fma(floor_whole(mul(minimum(y0, y1), spread(-per_side))), minus, none)
            row = whole_max(whole_add(ceiling, minus), first_row)
            row_end = whole_min(floor_whole(mul(maximum(y0, y1), spread(per_side))), last_row)
            while any_whole_less(row, whole_add(row_end, unit)):
                top = mul(real_of(row), spread(side))
                row_origin = whole_fma(row, row_pairs, origin)
                first_column, last_column = column_range(x0, y0, x1, y1, top, add(top, spread(side)))
                touched = whole_max(whole_shift(first_column, spread_whole(bits)), left)
                touched_end = whole_add(whole_min(whole_shift(last_column, spread_whole(bits)), right), row_origin)
                touched = whole_add(touched, row_origin)
                is_touched = where_whole_less(row_end, row, none, where_whole_less(touched_end, touched, none, unit))
                # Places where nothing is marked only have to be the path's own.
                touched = where_whole_less(none, is_touched, touched, path_pair)
                touched_end = where_whole_less(none, is_touched, touched_end, path_pair)
                mark_places(pair_is_partial, is_touched, touched, touched_end)
                if any_whole_less(whole_add(touched, unit), touched_end):
                    mark_ranges(pair_is_partial, whole_add(touched, unit), whole_add(touched_end, minus))

                middle = add(top, spread(half_side))
                is_below0 = whole_where_less(middle, y0, unit, none)
                step = whole_fma(is_below0, minus, whole_where_less(middle, y1, unit, none))
                x = fma(sub(x1, x0), mul(sub(middle, y0), inverse(sub(y1, y0))), x0)
                behind = whole_max(whole_add(floor_whole(mul(x, spread(per_side))), unit), left)
                step = where_whole_less(right, behind, none, step)
                step = where_whole_less(row_end, row, none, step)
                step = where_whole_less(lane, spread_whole(end), step, none)
                scatter_steps(pair_winding, whole_add(behind, row_origin), step)
                row = whole_add(row, unit)

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
        path_first_strip: wp.array(dtype=int),  # [N + 1]
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
        pair = int(pair0)
        for tile_row in range(box[1], box[3]):
            winding = int(0)
            for tile in range(tile_row * tile_columns + box[0], tile_row * tile_columns + box[2]):
                winding += pair_winding[pair]
                pair_class_here = wp.where(winding != 0, FULL, EMPTY)
                if pair_is_partial[pair] == 1:
                    pair_class_here = PARTIAL
                pair_path[pair] = path
                pair_class[pair] = pair_class_here
                pair_key[pair] = wp.where(pair_class_here == EMPTY, tile_count, tile)
                pair_index[pair] = pair
                pair += 1

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
