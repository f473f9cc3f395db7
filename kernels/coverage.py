"""Stage 3, coverage: vertices and partial pairs -> the winding of each pixel, by exact area.

The winding of a pixel is the integral of the winding number over the pixel. coverage = min(abs(winding), 1) is the
area that a simple path covers under the non-zero rule. An edge adds to each pixel it crosses dy times the mean distance
to the pixel's right border, and passes the rest of dy on to the right. Sums along the row then give the winding. (This
is the accumulation buffer of font-rs and stb_truetype, with exact areas.)

The winding is positive inside a path that runs counter-clockwise on screen.

A lane is a pixel row, so the sums along the rows of a tile take 16 additions.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warpvec.kernels import edges
from warpvec.kernels.constants import COLUMNS, TILE
from warpvec.kernels.lanes import Lanes, stage_module


@cache
def make_kernels(lanes: Lanes) -> SimpleNamespace:
    """Return ``accumulate_winding``."""
    dtype, vec2, vector = lanes.dtype, lanes.vec2, lanes.vector
    add, mul, fma, fnma, sub = lanes.add, lanes.mul, lanes.fma, lanes.fnma, lanes.sub
    minimum, maximum, spread = lanes.minimum, lanes.maximum, lanes.spread
    functions = edges.make_functions(lanes)
    inverse, column_range, row_crossing = functions.inverse, functions.column_range, functions.row_crossing
    blocks = wp.constant(lanes.blocks)
    width = wp.constant(lanes.width)
    height = wp.constant(dtype(lanes.width))
    zero, half, one = wp.constant(dtype(0.0)), wp.constant(dtype(0.5)), wp.constant(dtype(1.0))
    module = stage_module("coverage", lanes)

    @wp.kernel(module=module)
    def accumulate_winding(
        first: int,
        vertices: wp.array(dtype=vec2),  # [V] px
        segment_first_vertex: wp.array(dtype=int),  # [R + 1]
        loop_first_segment: wp.array(dtype=int),  # [L + 1]
        path_first_loop: wp.array(dtype=int),  # [N + 1]
        path_tile_box: wp.array(dtype=wp.vec4i),  # [N]
        path_first_strip: wp.array(dtype=int),  # [N + 1]
        path_first_pair: wp.array(dtype=int),  # [N + 1]
        strip_path: wp.array(dtype=int),  # [strips] -1: no path
        pair_slot: wp.array(dtype=int),  # [K + 1] exclusive count of partial pairs
        # outputs
        slot_winding: wp.array(dtype=vector),  # [slots, COLUMNS, TILE / width]
    ):
        """Find the winding in the partial pairs of one strip (CPU), or of one pixel row of a strip (scalar lanes)."""
        item = first + wp.tid()
        strip = item // blocks
        block = item % blocks
        path = strip_path[strip]
        if path < 0:
            return
        box = path_tile_box[path]
        strip_in_path = strip - path_first_strip[path]
        pair0 = path_first_pair[path] + strip_in_path * (box[2] - box[0])
        pair_end = pair0 + box[2] - box[0]
        for index in range(pair_slot[pair0] * COLUMNS, pair_slot[pair_end] * COLUMNS):
            slot_winding[index * blocks + block] = spread(zero)

        top = dtype((box[1] + strip_in_path) * TILE + block * width)
        bottom = top + height
        left_column = box[0] * TILE
        end_column = box[2] * TILE
        carry = spread(zero)
        for loop in range(path_first_loop[path], path_first_loop[path + 1]):
            start = segment_first_vertex[loop_first_segment[loop]]
            end = segment_first_vertex[loop_first_segment[loop + 1]]
            v0 = vertices[end - 1]
            for v in range(start, end):
                v1 = vertices[v]
                dy = v1[1] - v0[1]
                if dy != zero and wp.max(v0[1], v1[1]) > top and wp.min(v0[1], v1[1]) < bottom:
                    touched = column_range(v0, v1, top, bottom)
                    if touched[0] < end_column:
                        dx = v1[0] - v0[0]
                        inv_dx = inverse(dx)
                        inv_dy = inverse(dy)
                        upper = row_crossing(top, v0[1], inv_dy)
                        lower = row_crossing(top + one, v0[1], inv_dy)
                        row_low = minimum(upper, lower)
                        row_high = maximum(upper, lower)
                        # s at the left border of the current column. The part left of the box goes into ``carry``.
                        column = wp.max(touched[0], left_column)
                        cross = (dtype(column) - v0[0]) * inv_dx
                        if touched[0] < left_column:
                            low = maximum(row_low, spread(wp.where(dx >= zero, zero, cross)))
                            high = minimum(row_high, spread(wp.where(dx >= zero, cross, one)))
                            carry = fma(spread(dy), maximum(sub(high, low), spread(zero)), carry)
                        passed = spread(zero)
                        last = wp.min(touched[1], end_column - 1)
                        index = int(-1)
                        while column <= last:
                            following = (dtype(column + 1) - v0[0]) * inv_dx
                            low = maximum(row_low, spread(wp.min(cross, following)))
                            high = minimum(row_high, spread(wp.max(cross, following)))
                            part = mul(spread(dy), maximum(sub(high, low), spread(zero)))
                            middle = fma(mul(add(low, high), spread(half)), spread(dx), spread(v0[0] - dtype(column)))
                            pair = pair0 + column // TILE - box[0]
                            slot = pair_slot[pair]
                            # A column in the guard margin may lie in a tile that rounding left unmarked.
                            if pair_slot[pair + 1] > slot:
                                index = (slot * COLUMNS + column % TILE) * blocks + block
                                area = fnma(part, middle, part)
                                slot_winding[index] = add(slot_winding[index], add(area, passed))
                                passed = sub(part, area)
                            cross = following
                            column += 1
                        if index >= 0:
                            slot_winding[index + blocks] = add(slot_winding[index + blocks], passed)
                v0 = v1

        for pair in range(pair0, pair_end):
            slot = pair_slot[pair]
            if pair_slot[pair + 1] > slot:
                base = slot * COLUMNS * blocks + block
                for column in range(TILE):
                    carry = add(carry, slot_winding[base + column * blocks])
                    slot_winding[base + column * blocks] = carry
                carry = add(carry, slot_winding[base + TILE * blocks])

    return SimpleNamespace(accumulate_winding=accumulate_winding)
