"""Stage 3b, softening: windings and standard deviations -> the blurred coverage of soft paths.

What a soft path covers is its exact coverage, convolved with a sampled Gaussian along both axes. Soft paths have layers
of their own on a canvas with a margin of whole tiles, because what lies off the canvas is blurred into it. A layer is
the path's box of tiles, widened by the reach of the Gaussian; all its pairs are partial, so that the slot of a pair is
its own number. The layer is blurred along x, turned, and blurred along y. The result takes the place of the winding in
the slots of the canvas.

*Upright* layers have the order of slots: a tile is 16 columns of 16 rows, and the tiles of a strip follow one another.
*Turned* layers have tiles of 16 rows of 16 columns, and the tiles of a column of tiles follow one another. In both, a
blur runs along whole lane values.
"""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels import binning, compositing
from warpvec.kernels.constants import COLUMNS, COORDINATE_MAX, PARTIAL, TILE
from warpvec.kernels.lanes import Lanes, bundle, stage_module
from warpvec.kernels.making import made_once

AT_ONCE = 4
"""Lane values of a tile that a CPU thread blurs together, so that it loads each input once for all. The kernels have a
variable for each."""


def blurred_at_once(lanes: Lanes) -> int:
    """Return how many lane values of a tile a thread blurs together."""
    return AT_ONCE if lanes.width > 1 else 1


@made_once
def make_functions(lanes: Lanes) -> SimpleNamespace:
    """Return the functions that forward and adjoint share: places of lane values in layers, and the tile of a pair."""
    blocks, width = wp.constant(lanes.blocks), wp.constant(lanes.width)
    v = lanes.functions

    @wp.func
    def line_tiles(box: wp.vec4i, is_turned: int):
        """Return the number of tiles side by side in a line of a layer."""
        return wp.where(is_turned == 1, box[3] - box[1], box[2] - box[0])

    @wp.func
    def turned_tile(tile: int, first: int, box: wp.vec4i, is_turned: int):
        """Return where the ``tile`` of a layer, the ``first`` of its path, stands in the other order."""
        tiles = line_tiles(box, is_turned)
        lines = wp.where(is_turned == 1, box[2] - box[0], box[3] - box[1])
        local = tile - first
        return first + (local % tiles) * lines + local // tiles

    @wp.func
    def crosswise(start: int, part: int):
        """Return the places of the pixels across lane value ``part``, in a tile whose pixels begin at ``start``."""
        lane = v.lane_numbers((part % blocks) * width)
        return v.whole_fma(lane, v.spread_whole(TILE), v.spread_whole(start + part // blocks))

    @wp.func
    def canvas_slot(
        pair: int,
        path: int,
        margin: int,
        layer_box: wp.array(dtype=wp.vec4i),
        layer_first_pair: wp.array(dtype=int),
        soft_path: wp.array(dtype=int),
        path_tile_box: wp.array(dtype=wp.vec4i),
        path_first_pair: wp.array(dtype=int),
        pair_slot: wp.array(dtype=int),
    ):
        """Return the slot on the canvas of the ``pair`` of a layer; -1 if it lies in the margin."""
        box, own = layer_box[path], soft_path[path]
        canvas_box = path_tile_box[own]
        local, across = pair - layer_first_pair[path], box[2] - box[0]
        column, row = box[0] + local % across - margin, box[1] + local // across - margin
        slot = int(-1)
        if column >= canvas_box[0] and column < canvas_box[2] and row >= canvas_box[1] and row < canvas_box[3]:
            place = (row - canvas_box[1]) * (canvas_box[2] - canvas_box[0]) + column - canvas_box[0]
            slot = pair_slot[path_first_pair[own] + place]
        return slot

    return bundle(line_tiles, turned_tile, crosswise, canvas_slot)


@made_once
def make_kernels(lanes: Lanes) -> SimpleNamespace:
    """Return ``bound_soft_paths``, ``mark_soft_pairs``, ``cover_layers``, ``blur``, ``turn`` and ``place_layers``."""
    dtype, vec2, vector = lanes.dtype, lanes.vec2, lanes.vector
    v = lanes.functions
    pixels, layers = compositing.make_functions(lanes), make_functions(lanes)
    boxes = binning.make_functions(lanes)
    zero = wp.constant(dtype(0.0))
    blocks, tile_size = wp.constant(lanes.blocks), wp.constant(TILE * lanes.blocks)
    tile_vectors, tile_threads = wp.constant(lanes.tile_vectors), wp.constant(lanes.tile_threads)
    at_once = blurred_at_once(lanes)
    module = stage_module("softening", lanes)

    @wp.kernel(module=module)
    def bound_soft_paths(
        first: int,
        vertices: wp.array(dtype=vec2),  # [V] px
        segment_first_vertex: wp.array(dtype=int),  # [R + 1]
        loop_first_segment: wp.array(dtype=int),  # [L + 1]
        path_first_loop: wp.array(dtype=int),  # [N + 1]
        path_reach: wp.array(dtype=int),  # [N] px, 0 for a sharp path
        tile_rows: int,
        tile_columns: int,
        # outputs
        path_tile_box: wp.array(dtype=wp.vec4i),  # [N] those of sharp paths stay
        path_strip_count: wp.array(dtype=int),  # [N + 1]
        path_pair_count: wp.array(dtype=int),  # [N + 1]
    ):
        """Find the box of tiles of each soft path, with what its blur reaches."""
        path = first + wp.tid()
        if path_reach[path] == 0:
            return
        reach = vec2(dtype(path_reach[path]))
        low, high = vec2(dtype(COORDINATE_MAX)), vec2(-dtype(COORDINATE_MAX))
        start = segment_first_vertex[loop_first_segment[path_first_loop[path]]]
        is_wild = bool(False)
        for vertex in range(start, segment_first_vertex[loop_first_segment[path_first_loop[path + 1]]]):
            place = vertices[vertex]
            # A comparison with what is not a number is false.
            if wp.abs(place[0]) < dtype(COORDINATE_MAX) and wp.abs(place[1]) < dtype(COORDINATE_MAX):
                low, high = wp.min(low, place), wp.max(high, place)
            else:
                is_wild = True
        box = boxes.tile_box(low - reach, high + reach, is_wild, tile_rows, tile_columns)
        path_tile_box[path] = box
        path_strip_count[path] = box[3] - box[1]
        path_pair_count[path] = (box[3] - box[1]) * (box[2] - box[0])

    @wp.kernel(module=module)
    def mark_soft_pairs(
        first: int,
        path_reach: wp.array(dtype=int),  # [N]
        path_tile_box: wp.array(dtype=wp.vec4i),  # [N]
        path_first_pair: wp.array(dtype=int),  # [N + 1]
        tile_columns: int,
        # outputs
        pair_class: wp.array(dtype=int),  # [K] those of sharp paths stay
        pair_is_partial: wp.array(dtype=int),  # [K + 1]
        pair_key: wp.array(dtype=int),  # [K]
    ):
        """Make all pairs of the soft paths partial."""
        path = first + wp.tid()
        if path_reach[path] == 0:
            return
        box = path_tile_box[path]
        pair = path_first_pair[path]
        for row in range(box[1], box[3]):
            for column in range(box[0], box[2]):
                pair_class[pair] = PARTIAL
                pair_is_partial[pair] = 1
                pair_key[pair] = row * tile_columns + column
                pair += 1

    @wp.kernel(module=module)
    def cover_layers(
        first: int,
        slot_winding: wp.array(dtype=vector),  # [slots, COLUMNS] of the layers
        # outputs
        layer: wp.array(dtype=vector),  # [pairs, TILE] upright
    ):
        """Write the coverage of the layers."""
        item = first + wp.tid()
        pair = item // tile_threads
        for index in range(tile_vectors):
            part = (item % tile_threads) * tile_vectors + index
            winding = v.load(slot_winding, pixels.winding_index(pair, part))
            v.store(layer, pair * tile_size + part, pixels.coverage(winding))

    @wp.kernel(module=module)
    def blur(
        first: int,
        layer: wp.array(dtype=vector),  # [pairs, TILE]
        is_turned: int,
        pair_path: wp.array(dtype=int),  # [pairs]
        layer_box: wp.array(dtype=wp.vec4i),  # [S]
        layer_first_pair: wp.array(dtype=int),  # [S + 1]
        reach: wp.array(dtype=int),  # [S]
        weights: wp.array2d(dtype=dtype),  # [S, taps] 0 beyond the reach
        # outputs
        blurred: wp.array(dtype=vector),  # [pairs, TILE]
    ):
        """Blur a tile of the layers along its lines. Beyond its box a path covers nothing."""
        item = first + wp.tid()
        tile = item // tile_threads
        path = pair_path[tile]
        pair0 = layer_first_pair[path]
        tiles = layers.line_tiles(layer_box[path], is_turned)
        place = (tile - pair0) % tiles
        for step in range(0, tile_vectors, at_once):
            part = (item % tile_threads) * tile_vectors + step
            position = place * TILE + part // blocks
            center = tile * tile_size + part
            # `second = total` would make both one variable in Warp.
            total, second, third, fourth = v.spread(zero), v.spread(zero), v.spread(zero), v.spread(zero)
            for tap in range(
                wp.max(-reach[path], -position),
                wp.min(reach[path] + wp.static(at_once - 1), tiles * TILE - 1 - position) + 1,
            ):
                value = v.load(layer, center + tap * blocks)
                total = v.fma(v.spread(weights[path, wp.abs(tap)]), value, total)
                if wp.static(at_once > 1):
                    second = v.fma(v.spread(weights[path, wp.abs(tap - 1)]), value, second)
                    third = v.fma(v.spread(weights[path, wp.abs(tap - 2)]), value, third)
                    fourth = v.fma(v.spread(weights[path, wp.abs(tap - 3)]), value, fourth)
            v.store(blurred, center, total)
            if wp.static(at_once > 1):
                v.store(blurred, center + 1, second)
                v.store(blurred, center + 2, third)
                v.store(blurred, center + 3, fourth)

    @wp.kernel(module=module)
    def turn(
        first: int,
        layer: wp.array(dtype=vector),  # [pairs, TILE]
        is_turned: int,
        pair_path: wp.array(dtype=int),  # [pairs]
        layer_box: wp.array(dtype=wp.vec4i),  # [S]
        layer_first_pair: wp.array(dtype=int),  # [S + 1]
        # outputs
        turned: wp.array(dtype=vector),  # [pairs, TILE] in the other order
    ):
        """Turn a tile of the layers."""
        item = first + wp.tid()
        tile = item // tile_threads
        path = pair_path[tile]
        other = layers.turned_tile(tile, layer_first_pair[path], layer_box[path], is_turned)
        for index in range(tile_vectors):
            part = (item % tile_threads) * tile_vectors + index
            across = layers.crosswise(tile * wp.static(TILE * TILE), part)
            v.store(turned, other * tile_size + part, v.gather_value(layer, across))

    @wp.kernel(module=module)
    def place_layers(
        first: int,
        layer: wp.array(dtype=vector),  # [pairs, TILE] turned
        margin: int,  # tiles
        layer_pair_path: wp.array(dtype=int),  # [pairs]
        layer_box: wp.array(dtype=wp.vec4i),  # [S]
        layer_first_pair: wp.array(dtype=int),  # [S + 1]
        soft_path: wp.array(dtype=int),  # [S]
        path_tile_box: wp.array(dtype=wp.vec4i),  # [N]
        path_first_pair: wp.array(dtype=int),  # [N + 1]
        pair_slot: wp.array(dtype=int),  # [K + 1]
        # outputs
        slot_winding: wp.array(dtype=vector),  # [slots, COLUMNS] of the canvas; those of sharp paths stay
    ):
        """Write a tile of the layers, upright, to its slot on the canvas."""
        item = first + wp.tid()
        pair = item // tile_threads
        path = layer_pair_path[pair]
        slot = layers.canvas_slot(
            pair, path, margin, layer_box, layer_first_pair, soft_path, path_tile_box, path_first_pair, pair_slot
        )
        if slot >= 0:
            turned = layers.turned_tile(pair, layer_first_pair[path], layer_box[path], 0)
            for index in range(tile_vectors):
                part = (item % tile_threads) * tile_vectors + index
                across = layers.crosswise(turned * wp.static(TILE * TILE), part)
                v.store(slot_winding, slot * wp.static(COLUMNS * lanes.blocks) + part, v.gather_value(layer, across))

    return bundle(bound_soft_paths, mark_soft_pairs, cover_layers, blur, turn, place_layers)
