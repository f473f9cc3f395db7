"""Derivatives of the pixels of stage 4, for the Gauss-Newton matrix: by the paints, and by the winding of each path.

Let T_i be the transmittance in front of path i, a_i its opacity times its coverage, and B_i the colour behind it. The
*visible share* of the path, T_i a_i, is the derivative of the pixel by the colour of the path. The derivative by its
winding is T_i da_i/d(winding) (c_i - B_i), and that of the transmittance of all paths has 0 for c_i and the
transmittance behind the path for B_i. A tile first goes back to front, for all that lies behind a path, and then front
to back.
"""

from types import SimpleNamespace

import warp as wp

from warpvec.geometry.paints.registry import FLAT
from warpvec.kernels import compositing, gradients, stops
from warpvec.kernels.constants import FULL
from warpvec.kernels.lanes import Lanes, bundle, stage_module
from warpvec.kernels.making import made_once

SLOPE_PLANES = 4
"""Derivatives by a winding: of red, green and blue, and of the transmittance of all paths."""


@made_once
def make_kernels(lanes: Lanes, with_gradients: bool = False, with_stops: bool = False) -> SimpleNamespace:
    """Return ``derive_pixels``; the arguments are those of ``compositing.make_kernels``."""
    dtype, vec3, vec4, vector = lanes.dtype, lanes.vec3, lanes.vec4, lanes.vector
    v = lanes.functions
    pixels = compositing.make_functions(lanes)
    paint, shade = gradients.make_functions(lanes), stops.make_functions(lanes)
    vec5, vec8 = shade.vec5, shade.vec8
    zero, one = wp.constant(dtype(0.0)), wp.constant(dtype(1.0))
    planes = wp.constant(SLOPE_PLANES)
    tile_vectors = wp.constant(lanes.tile_vectors)
    tile_threads = wp.constant(lanes.tile_threads)
    tile_size = wp.constant(lanes.tile_vectors * lanes.tile_threads)
    module = stage_module(f"pixel_slopes{'_gradients' * with_gradients}{'_stops' * with_stops}", lanes)

    @wp.kernel(module=module)
    def derive_pixels(
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
        height: int,
        width_px: int,
        first_hit: int,  # first hit of the first tile of this launch
        # outputs
        hit_share: wp.array(dtype=vector),  # [hits of this launch, TILE TILE / width] 0 outside of the canvas
        hit_slopes: wp.array(dtype=vector),  # [the same, SLOPE_PLANES, TILE TILE / width] of partial pairs only
    ):
        """Derive one tile (CPU) or one pixel (scalar lanes)."""
        item = first + wp.tid()
        tile = item // tile_threads
        lane = item % tile_threads
        begin = tile_first_visible[tile]
        end = tile_first_hit[tile + 1]
        base = background[0]
        for vector_index in range(tile_vectors):
            part = lane * tile_vectors + vector_index
            for hit in range(tile_first_hit[tile], begin):
                v.store(hit_share, (hit - first_hit) * tile_size + part, v.spread(zero))
                for plane in range(planes):
                    v.store(hit_slopes, ((hit - first_hit) * planes + plane) * tile_size + part, v.spread(zero))

            behind0, behind1, behind2 = v.spread(base[0]), v.spread(base[1]), v.spread(base[2])
            behind3 = v.spread(one)
            for hit in range(begin, end):
                pair = hit_pair[hit]
                path = pair_path[pair]
                alpha = v.spread(opacity[path])
                c = color[path]
                red, green, blue = v.spread(c[0]), v.spread(c[1]), v.spread(c[2])
                if wp.static(with_gradients):
                    if paint_kind[path] != wp.static(FLAT):
                        geometry, e = paint_geometry[path], end_color[path]
                        slope = paint.slopes(paint_kind[path], geometry)
                        kind = paint.shown_kind(paint_kind[path], slope)
                        qx = paint.offset_x(geometry, tile, part, tile_columns)
                        qy = paint.offset_y(geometry, tile, part, tile_columns)
                        t = paint.share(paint.free_share(kind, slope, qx, qy))
                        red = v.fma(t, v.spread(e[0] - c[0]), red)
                        green = v.fma(t, v.spread(e[1] - c[1]), green)
                        blue = v.fma(t, v.spread(e[2] - c[2]), blue)
                if wp.static(with_stops):
                    t = shade.place_in(place_form[path], stop_count[path], place_kind[path], tile, part, tile_columns)
                    red, green, blue, a = shade.color_at(t, path, stop_count[path], stop_ramps)
                    alpha = v.mul(alpha, a)
                red, green, blue = v.sub(red, behind0), v.sub(green, behind1), v.sub(blue, behind2)
                faded = v.sub(v.spread(zero), behind3)
                if pair_class[pair] != FULL:
                    winding = v.load(slot_winding, pixels.winding_index(pair_slot[pair], part))
                    rise = v.mul(alpha, pixels.coverage_slope(winding))
                    alpha = v.mul(alpha, pixels.coverage(winding))
                    place = (hit - first_hit) * planes * tile_size + part
                    v.store(hit_slopes, place, v.mul(rise, red))
                    v.store(hit_slopes, place + tile_size, v.mul(rise, green))
                    v.store(hit_slopes, place + 2 * tile_size, v.mul(rise, blue))
                    v.store(hit_slopes, place + 3 * tile_size, v.mul(rise, faded))
                behind0 = v.fma(alpha, red, behind0)
                behind1 = v.fma(alpha, green, behind1)
                behind2 = v.fma(alpha, blue, behind2)
                behind3 = v.fma(alpha, faded, behind3)
                v.store(hit_share, (hit - first_hit) * tile_size + part, alpha)

            mask = pixels.on_canvas(tile, part, tile_columns, height, width_px)
            transmittance = mask
            for above in range(end - begin):
                hit = end - 1 - above
                if pair_class[hit_pair[hit]] != FULL:
                    for plane in range(planes):
                        place = ((hit - first_hit) * planes + plane) * tile_size + part
                        v.store(hit_slopes, place, v.mul(transmittance, v.load(hit_slopes, place)))
                place = (hit - first_hit) * tile_size + part
                share = v.mul(transmittance, v.load(hit_share, place))
                v.store(hit_share, place, share)
                transmittance = v.sub(transmittance, share)

    return bundle(derive_pixels)
