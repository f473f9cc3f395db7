"""Stage 3, coverage: vertices and partial pairs -> the winding of each pixel, by exact area.

The winding of a pixel is the integral of the winding number over the pixel. coverage = min(abs(winding), 1) is the
area that a simple path covers under the non-zero rule. An edge adds to each pixel it crosses dy times the mean distance
to the pixel's right border, and passes the rest of dy on to the right. Sums along the row then give the winding. (This
is the accumulation buffer of font-rs and stb_truetype, with exact areas.)

The winding is positive inside a path that runs counter-clockwise on screen.

On the CPU a work item is a path: 16 of its edges at a time walk through the pixels that they cross (``edges.py``), and
each adds to its pixels in turn. On scalar lanes a work item is a pixel row of a tile, which looks at every edge of its
path: thus each pixel is written by one thread of a GPU, which adds in a fixed order.
"""

from types import SimpleNamespace
from typing import Any

import warp as wp

from warpvec.kernels import edges
from warpvec.kernels.constants import COLUMNS, TILE
from warpvec.kernels.lanes import Lanes, stage_module
from warpvec.kernels.making import made_once


@made_once
def make_kernels(lanes: Lanes, is_linked: bool = False) -> SimpleNamespace:
    """Return ``accumulate_winding``; ``is_linked`` is for strokes, whose edges do not follow one another in a loop.

    It makes a difference on scalar lanes only, which save a look at ``edge_end`` without it.
    """
    kernel = _of_rows(lanes, is_linked) if lanes.width == 1 else _of_paths(lanes)
    return SimpleNamespace(accumulate_winding=kernel)


def _of_paths(lanes: Lanes) -> Any:
    dtype, vec2, vector, width = lanes.dtype, lanes.vec2, lanes.vector, lanes.width
    v = lanes.functions
    walk = edges.make_functions(lanes)
    zero, half = wp.constant(dtype(0.0)), wp.constant(dtype(0.5))
    slot_size = wp.constant(COLUMNS * TILE)

    @wp.func
    def add_edges(
        start: int,
        end: int,
        vertices: wp.array(dtype=vec2),
        edge_end: wp.array(dtype=int),
        box: wp.vec4i,
        pair0: int,
        pair_end: int,
        carry0: int,
        pair_slot: wp.array(dtype=int),
        slot_winding: wp.array(dtype=vector),
    ):
        """Add the edges [start, end) of a path to its pixels; what lies left of its box, to the row's carry."""
        side, row_pairs = v.spread_whole(TILE), v.spread_whole(box[2] - box[0])
        origin = v.spread_whole(pair0 - box[1] * (box[2] - box[0]) - box[0])
        left, right = v.spread_whole(box[0] * TILE), v.spread_whole(box[2] * TILE)
        top, bottom = v.spread_whole(box[1] * TILE), v.spread_whole(box[3] * TILE)
        left_of_box, carry_origin = v.spread_whole(box[0] * TILE - 1), v.spread_whole((carry0 - box[1]) * TILE)
        first_pair, last_pair = v.spread_whole(pair0), v.spread_whole(pair_end - 1)
        last_place = v.spread_whole(pair_slot[pair_end] * slot_size - TILE - 1)
        # Lanes without work add nothing, each to a place of its own.
        idle = v.lane_numbers(carry0 * TILE)
        for group in range((end - start + width - 1) // width):
            lane = v.lane_numbers(start + group * width)
            x0, y0, x1, y1 = walk.end_points(vertices, edge_end, v.whole_min(lane, v.spread_whole(end - 1)))
            x, y, dx, dy = walk.left_end(x0, y0, x1, y1)
            height, inv_dx, inv_dy = v.sub(y1, y0), walk.inverse(dx), walk.inverse(dy)
            low, stop = walk.between(top, bottom, y, inv_dy)
            stop = v.minimum(stop, walk.crossing(right, x, inv_dx))
            stop = v.where_less(v.spread(zero), walk.magnitude(height), stop, low)
            stop = v.where_index_less(lane, v.spread_whole(end), stop, low)
            # All that lies left of the box counts as one column.
            column, row = walk.pixel_at(low, x, dx, left_of_box, right), walk.pixel_at(low, y, dy, top, bottom)
            ahead = walk.row_ahead(dy)
            passed = v.spread(zero)
            while v.any_less(low, stop):
                across, down = walk.step_ends(column, row, ahead, x, y, inv_dx, inv_dy)
                high = v.maximum(low, v.minimum(stop, v.minimum(across, down)))
                part = v.mul(height, v.sub(high, low))
                middle = v.fma(v.mul(v.add(low, high), v.spread(half)), dx, v.sub(x, v.real_of(column)))
                area = v.fnma(part, middle, part)
                rest = v.sub(part, area)
                value = v.add(area, passed)
                pair = v.whole_min(v.whole_max(walk.pair_of(column, row, row_pairs, origin), first_pair), last_pair)
                # Rounding of a huge edge may leave a tile unmarked. Its pixels then are those of another pair.
                place = v.whole_min(walk.place_in(v.gather_whole(pair_slot, pair), column, row), last_place)
                beside = v.whole_add(place, side)
                carry = v.whole_add(carry_origin, row)
                place = v.where_whole_less(column, left, carry, place)
                beside = v.where_whole_less(column, left, carry, beside)
                value = v.where_index_less(column, left, part, value)
                rest = v.where_index_less(column, left, v.spread(zero), rest)
                # The rest goes on to the next pixel of the walk, if that is the pixel to the right.
                passed = v.where_less(across, v.minimum(down, stop), rest, v.spread(zero))
                value = v.where_less(low, stop, value, v.spread(zero))
                rest = v.where_less(low, stop, v.sub(rest, passed), v.spread(zero))
                place, beside = v.whole_where_less(low, stop, place, idle), v.whole_where_less(low, stop, beside, idle)
                v.scatter_add(slot_winding, place, value, beside, rest)
                column, row = walk.next_pixel(column, row, ahead, across, down)
                low = high

    @wp.func
    def add_along_rows(
        strip_pair: int,
        strip_end: int,
        carry: vector,
        pair_slot: wp.array(dtype=int),
        slot_winding: wp.array(dtype=vector),
    ):
        """Replace what the edges added to the pixels of a strip by the sums along the rows, from ``carry`` on."""
        for pair in range(strip_pair, strip_end):
            slot = pair_slot[pair]
            if pair_slot[pair + 1] > slot:
                for column in range(slot * COLUMNS, slot * COLUMNS + TILE):
                    carry = v.add(carry, slot_winding[column])
                    slot_winding[column] = carry
                carry = v.add(carry, slot_winding[slot * COLUMNS + TILE])

    @wp.kernel(module=stage_module("coverage", lanes))
    def accumulate_winding(
        first: int,
        vertices: wp.array(dtype=vec2),  # [V] px
        edge_end: wp.array(dtype=int),  # [V]
        segment_first_vertex: wp.array(dtype=int),  # [R + 1]
        loop_first_segment: wp.array(dtype=int),  # [L + 1]
        path_first_loop: wp.array(dtype=int),  # [N + 1]
        path_tile_box: wp.array(dtype=wp.vec4i),  # [N]
        path_first_strip: wp.array(dtype=int),  # [N + 1]
        path_first_pair: wp.array(dtype=int),  # [N + 1]
        pair_slot: wp.array(dtype=int),  # [K + 1] exclusive count of partial pairs
        slot_count: int,
        # outputs
        slot_winding: wp.array(dtype=vector),  # [slots, COLUMNS] of pixels, then [strips] of what enters from the left
    ):
        """Find the winding in the partial pairs of one path."""
        path = first + wp.tid()
        box = path_tile_box[path]
        pair0, pair_end = path_first_pair[path], path_first_pair[path + 1]
        if pair_slot[pair0] == pair_slot[pair_end]:
            return
        for index in range(pair_slot[pair0] * COLUMNS, pair_slot[pair_end] * COLUMNS):
            slot_winding[index] = v.spread(zero)
        carry0 = slot_count * COLUMNS + path_first_strip[path]
        for index in range(carry0, carry0 + box[3] - box[1]):
            slot_winding[index] = v.spread(zero)
        start = segment_first_vertex[loop_first_segment[path_first_loop[path]]]
        end = segment_first_vertex[loop_first_segment[path_first_loop[path + 1]]]
        add_edges(start, end, vertices, edge_end, box, pair0, pair_end, carry0, pair_slot, slot_winding)
        for strip in range(box[3] - box[1]):
            strip_pair = pair0 + strip * (box[2] - box[0])
            strip_end = strip_pair + box[2] - box[0]
            add_along_rows(strip_pair, strip_end, slot_winding[carry0 + strip], pair_slot, slot_winding)

    return accumulate_winding


def _of_rows(lanes: Lanes, is_linked: bool) -> Any:
    dtype, vec2 = lanes.dtype, lanes.vec2
    walk = edges.make_functions(lanes)
    zero, half, one = wp.constant(dtype(0.0)), wp.constant(dtype(0.5)), wp.constant(dtype(1.0))

    @wp.func
    def add_edge(v0: vec2, v1: vec2, top: dtype, left_column: int, place0: int, slot_winding: wp.array(dtype=dtype)):
        """Add an edge to the pixels of a row of a tile, from ``place0`` on; return what lies left of the tile."""
        bottom, left_of_tile = top + one, dtype(0.0)
        first_column, last_column = walk.column_range(v0[0], v0[1], v1[0], v1[1], top, bottom)
        if first_column >= left_column + TILE:
            return left_of_tile
        dx, dy = v1[0] - v0[0], v1[1] - v0[1]
        inv_dx, inv_dy = walk.inverse(dx), walk.inverse(dy)
        upper = wp.clamp((top - v0[1]) * inv_dy, zero, one)
        lower = wp.clamp((bottom - v0[1]) * inv_dy, zero, one)
        row_low, row_high = wp.min(upper, lower), wp.max(upper, lower)
        # s at the left border of the current column.
        cross = (dtype(left_column) - v0[0]) * inv_dx
        if first_column < left_column:
            low = wp.max(row_low, wp.where(dx >= zero, zero, cross))
            high = wp.min(row_high, wp.where(dx >= zero, cross, one))
            left_of_tile += dy * wp.max(high - low, zero)
        passed = dtype(0.0)
        column = wp.max(first_column, left_column)
        cross = (dtype(column) - v0[0]) * inv_dx
        last = wp.min(last_column, left_column + TILE - 1)
        place = place0 + (column - left_column) * TILE
        while column <= last:
            following = (dtype(column + 1) - v0[0]) * inv_dx
            low = wp.max(row_low, wp.min(cross, following))
            high = wp.min(row_high, wp.max(cross, following))
            part = dy * wp.max(high - low, zero)
            middle = half * (low + high) * dx + (v0[0] - dtype(column))
            area = part - part * middle
            # An atomic operation returns nothing, so that the thread need not wait for the memory.
            wp.atomic_add(slot_winding, place, area + passed)
            passed = part - area
            cross = following
            column += 1
            place += TILE
        if passed != zero and column < left_column + TILE:
            wp.atomic_add(slot_winding, place, passed)
        return left_of_tile

    @wp.kernel(module=stage_module(f"coverage{'_linked' * is_linked}", lanes))
    def accumulate_winding(
        first: int,
        vertices: wp.array(dtype=vec2),  # [V] px
        edge_end: wp.array(dtype=int),  # [V] read only if ``is_linked``
        segment_first_vertex: wp.array(dtype=int),  # [R + 1]
        loop_first_segment: wp.array(dtype=int),  # [L + 1]
        path_first_loop: wp.array(dtype=int),  # [N + 1]
        path_tile_box: wp.array(dtype=wp.vec4i),  # [N]
        path_first_pair: wp.array(dtype=int),  # [N + 1]
        pair_path: wp.array(dtype=int),  # [K]
        pair_slot: wp.array(dtype=int),  # [K + 1] exclusive count of partial pairs
        # outputs
        slot_winding: wp.array(dtype=dtype),  # [slots, COLUMNS, TILE]
    ):
        """Find the winding in one pixel row of a pair, if it is partial."""
        item = first + wp.tid()
        pair, row = item // TILE, item % TILE
        slot = pair_slot[pair]
        if pair_slot[pair + 1] == slot:
            return
        path = pair_path[pair]
        box, pair_in_path = path_tile_box[path], pair - path_first_pair[path]
        top = dtype((box[1] + pair_in_path // (box[2] - box[0])) * TILE + row)
        left_column = (box[0] + pair_in_path % (box[2] - box[0])) * TILE
        place0, winding = slot * COLUMNS * TILE + row, dtype(0.0)
        for place in range(place0, place0 + TILE * TILE, TILE):
            slot_winding[place] = zero
        for loop in range(path_first_loop[path], path_first_loop[path + 1]):
            start = segment_first_vertex[loop_first_segment[loop]]
            end = segment_first_vertex[loop_first_segment[loop + 1]]
            v0 = vertices[end - 1]
            for v in range(start, end):
                v1 = vertices[v]
                if wp.static(is_linked):
                    v0 = v1
                    v1 = vertices[edge_end[v]]
                if v0[1] != v1[1] and wp.max(v0[1], v1[1]) > top and wp.min(v0[1], v1[1]) < top + one:
                    winding += add_edge(v0, v1, top, left_column, place0, slot_winding)
                v0 = v1
        for place in range(place0, place0 + TILE * TILE, TILE):
            winding += slot_winding[place]
            slot_winding[place] = winding

    return accumulate_winding
