"""Adjoint of stage 3b: dL/d(blurred coverage) -> dL/d(winding) of the layers, and dL/d(standard deviation).

The Gaussian is symmetric, so the adjoint of a blur is the same blur. With b = G_y h and h = G_x c,

    dL/dh = G_y dL/db,   dL/dc = G_x dL/dh,   dL/dsigma = sum dL/db . (G_y' h) + sum dL/dh . (G_x' c),

where G' is the derivative of the weights by the standard deviation.
"""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels import compositing, softening
from warpvec.kernels.constants import COLUMNS, TILE
from warpvec.kernels.lanes import Lanes, bundle, stage_module
from warpvec.kernels.making import made_once


@made_once
def make_kernels(lanes: Lanes) -> SimpleNamespace:
    """Return ``take_layers``, ``blur_adjoint`` and ``uncover_layers``."""
    dtype, vector = lanes.dtype, lanes.vector
    v = lanes.functions
    pixels, layers = compositing.make_functions(lanes), softening.make_functions(lanes)
    zero = wp.constant(dtype(0.0))
    blocks, tile_size = wp.constant(lanes.blocks), wp.constant(TILE * lanes.blocks)
    tile_vectors, tile_threads = wp.constant(lanes.tile_vectors), wp.constant(lanes.tile_threads)
    at_once = softening.blurred_at_once(lanes)
    module = stage_module("softening_adjoint", lanes)

    @wp.kernel(module=module)
    def take_layers(
        first: int,
        slot_winding: wp.array(dtype=vector),  # [slots, COLUMNS] dL/d(blurred coverage) on the canvas
        margin: int,  # tiles
        layer_pair_path: wp.array(dtype=int),  # [pairs]
        layer_box: wp.array(dtype=wp.vec4i),  # [S]
        layer_first_pair: wp.array(dtype=int),  # [S + 1]
        soft_path: wp.array(dtype=int),  # [S]
        path_tile_box: wp.array(dtype=wp.vec4i),  # [N]
        path_first_pair: wp.array(dtype=int),  # [N + 1]
        pair_slot: wp.array(dtype=int),  # [K + 1]
        # outputs
        adj_layer: wp.array(dtype=vector),  # [pairs, TILE] turned
    ):
        """Write the adjoint of a tile of the layers, turned; 0 in the margin."""
        item = first + wp.tid()
        pair = item // tile_threads
        path = layer_pair_path[pair]
        slot = layers.canvas_slot(
            pair, path, margin, layer_box, layer_first_pair, soft_path, path_tile_box, path_first_pair, pair_slot
        )
        turned = layers.turned_tile(pair, layer_first_pair[path], layer_box[path], 0)
        for index in range(tile_vectors):
            part = (item % tile_threads) * tile_vectors + index
            value = v.spread(zero)
            if slot >= 0:
                value = v.gather_value(slot_winding, layers.crosswise(slot * wp.static(COLUMNS * TILE), part))
            v.store(adj_layer, turned * tile_size + part, value)

    @wp.kernel(module=module)
    def blur_adjoint(
        first: int,
        layer: wp.array(dtype=vector),  # [pairs, TILE] what was blurred
        adj_blurred: wp.array(dtype=vector),  # [pairs, TILE]
        is_turned: int,
        pair_path: wp.array(dtype=int),  # [pairs]
        layer_box: wp.array(dtype=wp.vec4i),  # [S]
        layer_first_pair: wp.array(dtype=int),  # [S + 1]
        reach: wp.array(dtype=int),  # [S]
        weights: wp.array2d(dtype=dtype),  # [S, taps] 0 beyond the reach
        slopes: wp.array2d(dtype=dtype),  # [S, taps] their derivatives by the standard deviation
        # outputs
        adj_layer: wp.array(dtype=vector),  # [pairs, TILE]
        sigma_share: wp.array(dtype=dtype),  # [pairs, tile_threads] adds up to dL/d(standard deviation)
    ):
        """Blur the adjoint of a tile, and sum what its pixels would change with the standard deviation."""
        item = first + wp.tid()
        tile = item // tile_threads
        path = pair_path[tile]
        tiles = layers.line_tiles(layer_box[path], is_turned)
        place = (tile - layer_first_pair[path]) % tiles
        share = v.spread(zero)
        for step in range(0, tile_vectors, at_once):
            part = (item % tile_threads) * tile_vectors + step
            position = place * TILE + part // blocks
            center = tile * tile_size + part
            total, second, third, fourth = v.spread(zero), v.spread(zero), v.spread(zero), v.spread(zero)
            change, second_change = v.spread(zero), v.spread(zero)
            third_change, fourth_change = v.spread(zero), v.spread(zero)
            for tap in range(
                wp.max(-reach[path], -position),
                wp.min(reach[path] + wp.static(at_once - 1), tiles * TILE - 1 - position) + 1,
            ):
                side, there = wp.abs(tap), center + tap * blocks
                adj, value = v.load(adj_blurred, there), v.load(layer, there)
                total = v.fma(v.spread(weights[path, side]), adj, total)
                change = v.fma(v.spread(slopes[path, side]), value, change)
                if wp.static(at_once > 1):
                    side = wp.abs(tap - 1)
                    second = v.fma(v.spread(weights[path, side]), adj, second)
                    second_change = v.fma(v.spread(slopes[path, side]), value, second_change)
                    side = wp.abs(tap - 2)
                    third = v.fma(v.spread(weights[path, side]), adj, third)
                    third_change = v.fma(v.spread(slopes[path, side]), value, third_change)
                    side = wp.abs(tap - 3)
                    fourth = v.fma(v.spread(weights[path, side]), adj, fourth)
                    fourth_change = v.fma(v.spread(slopes[path, side]), value, fourth_change)
            v.store(adj_layer, center, total)
            share = v.fma(change, v.load(adj_blurred, center), share)
            if wp.static(at_once > 1):
                v.store(adj_layer, center + 1, second)
                v.store(adj_layer, center + 2, third)
                v.store(adj_layer, center + 3, fourth)
                share = v.fma(second_change, v.load(adj_blurred, center + 1), share)
                share = v.fma(third_change, v.load(adj_blurred, center + 2), share)
                share = v.fma(fourth_change, v.load(adj_blurred, center + 3), share)
        sigma_share[item] = v.total(share)

    @wp.kernel(module=module)
    def uncover_layers(
        first: int,
        adj_layer: wp.array(dtype=vector),  # [pairs, TILE] upright
        # in: winding, out: dL/d(winding)
        slot_winding: wp.array(dtype=vector),  # [slots, COLUMNS] of the layers
    ):
        """Replace the windings of the layers by their adjoints."""
        item = first + wp.tid()
        pair = item // tile_threads
        for index in range(tile_vectors):
            part = (item % tile_threads) * tile_vectors + index
            place = pixels.winding_index(pair, part)
            slope = pixels.coverage_slope(v.load(slot_winding, place))
            v.store(slot_winding, place, v.mul(v.load(adj_layer, pair * tile_size + part), slope))

    return bundle(take_layers, blur_adjoint, uncover_layers)
