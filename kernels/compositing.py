"""Stage 4, compositing: windings, colours and opacities -> the image.

Paths are blended over one another, back to front: C <- C + a (c - C) with a = opacity * coverage. The colour c of a
path is flat or a gradient (``gradients.py``). A scene without gradients is drawn by kernels that know of none, and one
whose gradients are all of two opaque stops by kernels that know of no others (``stops.py``).
"""

from types import SimpleNamespace

import warp as wp

from warpvec.geometry.paints.registry import FLAT
from warpvec.kernels import gradients, stops
from warpvec.kernels.constants import COLUMNS, FULL, TILE
from warpvec.kernels.lanes import Lanes, bundle, stage_module
from warpvec.kernels.making import made_once


@made_once
def make_functions(lanes: Lanes) -> SimpleNamespace:
    """Return the functions that forward and adjoint share: indices of a pair's pixels, and coverage from winding."""
    dtype, vector = lanes.dtype, lanes.vector
    v = lanes.functions
    zero, one = wp.constant(dtype(0.0)), wp.constant(dtype(1.0))
    blocks, width = wp.constant(lanes.blocks), wp.constant(lanes.width)

    @wp.func
    def winding_index(slot: int, part: int):
        """Return the index in ``slot`` of lane value ``part`` of a tile; pixels are stored column by column."""
        return slot * wp.static(COLUMNS * lanes.blocks) + part

    @wp.func
    def on_canvas(tile: int, part: int, tile_columns: int, height: int, width_px: int):
        """Return 1 for the lanes of ``part`` whose pixel lies on the canvas, else 0."""
        column = (tile % tile_columns) * TILE + part // blocks
        row = (tile // tile_columns) * TILE + (part % blocks) * width
        inside = wp.where(column < width_px, one, zero)
        half = dtype(0.5)
        return v.where_less(v.ramp_from(dtype(row) + half), v.spread(dtype(height)), v.spread(inside), v.spread(zero))

    @wp.func
    def coverage(winding: vector):
        """Return min(abs(winding), 1): the non-zero rule, applied to the mean winding of a pixel."""
        return v.minimum(v.maximum(winding, v.sub(v.spread(zero), winding)), v.spread(one))

    @wp.func
    def coverage_slope(winding: vector):
        """Return d(coverage)/d(winding): the sign of the winding, or 0 beyond 1, where more winding covers no more."""
        positive = v.where_less(v.spread(zero), winding, v.spread(one), v.spread(zero))
        sign = v.where_less(winding, v.spread(zero), v.spread(-one), positive)
        return v.where_less(v.spread(one), v.maximum(winding, v.sub(v.spread(zero), winding)), v.spread(zero), sign)

    return bundle(winding_index, on_canvas, coverage, coverage_slope)


@made_once
def make_kernels(lanes: Lanes, with_gradients: bool = False, with_stops: bool = False) -> SimpleNamespace:
    """Return ``find_visible`` and ``composite``.

    ``with_gradients`` is for scenes whose gradients all have two opaque stops, ``with_stops`` for all others.
    """
    dtype, vec3, vec4, vector = lanes.dtype, lanes.vec3, lanes.vec4, lanes.vector
    v = lanes.functions
    pixels = make_functions(lanes)
    paint, shade = gradients.make_functions(lanes), stops.make_functions(lanes)
    vec5, vec8 = shade.vec5, shade.vec8
    one = wp.constant(dtype(1.0))
    tile_vectors = wp.constant(lanes.tile_vectors)
    tile_threads = wp.constant(lanes.tile_threads)
    tile_size = wp.constant(lanes.tile_vectors * lanes.tile_threads)
    module = stage_module(f"compositing{'_gradients' * with_gradients}{'_stops' * with_stops}", lanes)

    @wp.kernel(module=module)
    def find_visible(
        first: int,
        tile_first_hit: wp.array(dtype=int),  # [tiles + 1]
        hit_pair: wp.array(dtype=int),  # [K]
        pair_path: wp.array(dtype=int),  # [K]
        pair_class: wp.array(dtype=int),  # [K]
        opacity: wp.array(dtype=dtype),  # [N]
        transmittance_min: dtype,
        # outputs
        tile_first_visible: wp.array(dtype=int),  # [tiles]
    ):
        """Find the lowest hit of a tile that is not hidden behind the tile's full pairs."""
        tile = first + wp.tid()
        transmittance = dtype(1.0)
        start = tile_first_hit[tile]
        hit = tile_first_hit[tile + 1]
        while hit > start and transmittance >= transmittance_min:
            hit -= 1
            pair = hit_pair[hit]
            if pair_class[pair] == FULL:
                transmittance *= one - opacity[pair_path[pair]]
        tile_first_visible[tile] = hit

    @wp.kernel(module=module)
    def composite(
        first: int,
        tile_first_hit: wp.array(dtype=int),  # [tiles + 1]
        tile_first_visible: wp.array(dtype=int),  # [tiles]
        hit_pair: wp.array(dtype=int),  # [K]
        pair_path: wp.array(dtype=int),  # [K]
        pair_class: wp.array(dtype=int),  # [K]
        pair_slot: wp.array(dtype=int),  # [K + 1]
        slot_winding: wp.array(dtype=vector),  # [slots, COLUMNS, TILE / width]
        color: wp.array(dtype=vec3),  # [N]
        opacity: wp.array(dtype=dtype),  # [N]
        background: wp.array(dtype=vec3),  # [1]
        paint_kind: wp.array(dtype=int),  # [N] this and the next two: ``with_gradients`` only
        paint_geometry: wp.array(dtype=vec4),  # [N] px
        end_color: wp.array(dtype=vec3),  # [N]
        stop_count: wp.array(dtype=int),  # [N] this and the next three: ``with_stops`` only
        place_kind: wp.array(dtype=int),  # [N]
        place_form: wp.array(dtype=vec5),  # [N]
        stop_ramps: wp.array2d(dtype=vec8),  # [N, STOPS_MAX]
        tile_columns: int,
        # outputs
        tile_image: wp.array(dtype=vector),  # [tiles, 3, TILE TILE / width]
    ):
        """Composite one tile (CPU) or one pixel (scalar lanes), back to front."""
        item = first + wp.tid()
        tile = item // tile_threads
        lane = item % tile_threads
        begin = tile_first_visible[tile]
        end = tile_first_hit[tile + 1]
        base = background[0]
        for vector_index in range(tile_vectors):
            part = lane * tile_vectors + vector_index
            red = v.spread(base[0])
            green = v.spread(base[1])
            blue = v.spread(base[2])
            for hit in range(begin, end):
                pair = hit_pair[hit]
                path = pair_path[pair]
                alpha = v.spread(opacity[path])
                if pair_class[pair] != FULL:
                    alpha = v.mul(alpha, pixels.coverage(slot_winding[pixels.winding_index(pair_slot[pair], part)]))
                c = color[path]
                r, g, b = v.spread(c[0]), v.spread(c[1]), v.spread(c[2])
                if wp.static(with_gradients):
                    if paint_kind[path] != wp.static(FLAT):
                        geometry, e = paint_geometry[path], end_color[path]
                        slope = paint.slopes(paint_kind[path], geometry)
                        kind = paint.shown_kind(paint_kind[path], slope)
                        qx = paint.offset_x(geometry, tile, part, tile_columns)
                        qy = paint.offset_y(geometry, tile, part, tile_columns)
                        t = paint.share(paint.free_share(kind, slope, qx, qy))
                        r = v.fma(t, v.spread(e[0] - c[0]), r)
                        g = v.fma(t, v.spread(e[1] - c[1]), g)
                        b = v.fma(t, v.spread(e[2] - c[2]), b)
                if wp.static(with_stops):
                    t = shade.place_in(place_form[path], stop_count[path], place_kind[path], tile, part, tile_columns)
                    r, g, b, a = shade.color_at(t, path, stop_count[path], stop_ramps)
                    alpha = v.mul(alpha, a)
                red = v.fma(alpha, v.sub(r, red), red)
                green = v.fma(alpha, v.sub(g, green), green)
                blue = v.fma(alpha, v.sub(b, blue), blue)
            index = tile * 3 * tile_size + part
            tile_image[index] = red
            tile_image[index + tile_size] = green
            tile_image[index + 2 * tile_size] = blue

    return bundle(find_visible, composite)
