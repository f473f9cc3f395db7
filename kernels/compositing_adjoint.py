"""Adjoint of stage 4, and the fused render + MSE + adjoint of the fitting loop.

Let T_i be the transmittance in front of path i and B_i the colour behind it. At a pixel with image adjoint g,
dL/dc_i = T_i a_i g and dL/da_i = T_i g . (c_i - B_i). Recovering B_i from the image would divide by 1 - a_i, which is 0
for an opaque path. Instead a tile first composites back to front and stacks every B_i, then walks front to back.

The exact removal cost of a path (the rise of the MSE without it) needs one more sum over pixels, the *opacity
curvature* T_i^2 coverage_i^2 |c_i - B_i|^2. The image is affine in the opacity of one path, so the squared error is a
parabola in it, and this sum is the coefficient of its square.

A target may be *shifted*: adjoints and removal costs are then those of the squared error against the target plus a
fourth plane, which all channels share. The loss is still that against the target itself.
"""

from types import SimpleNamespace
from typing import Any

import warp as wp

from warpvec.geometry.paints.registry import FLAT
from warpvec.kernels import compositing, gradients, stops
from warpvec.kernels.constants import EMPTY, FULL, PARTIAL, TILE
from warpvec.kernels.lanes import Lanes, bundle, stage_module
from warpvec.kernels.making import made_once

TERMS = 5
"""Number of sums. A pair has five: dL/d(red), dL/d(green), dL/d(blue), dL/d(opacity), opacity curvature. A tile uses
the first CANVAS_TERMS for the sums over the canvas; its fifth is unused. A scene with gradients has
``gradients.GRADIENT_TERMS`` more, one with gradients of several stops ``stops.STOP_TERMS`` more."""

FIRST_STOP_TERM = TERMS + stops.WHOLE_TERMS
"""The first of the sums of a pair for its second stop."""

CANVAS_TERMS = 4
"""Number of sums over the canvas, and of those that a tile uses: three of dL/d(background), and the squared error."""


@made_once
def make_kernels(
    lanes: Lanes,
    fused: bool,
    with_curvature: bool,
    with_gradients: bool = False,
    with_stops: bool = False,
    with_shares: bool = False,
) -> SimpleNamespace:
    """Return ``composite_adjoint``, ``gather_paths_adjoint``, ``gather_tiles`` and ``gather_canvas``.

    Scalar lanes add ``gather_pairs``, and ``with_stops`` adds ``gather_stops``.

    Args:
        lanes: width and precision.
        fused: whether ``tile_reference`` is the target, and the loss the squared error against it; if not, it is
            dL/d(image).
        with_curvature: whether to fill the fifth sum of each pair.
        with_gradients: whether the scene has gradients; if not, their arrays are not touched.
        with_stops: whether it has gradients of several or translucent stops; ``with_gradients`` is then False.
        with_shares: whether colours answer for other shares of the pixels than they cover; all paths are then flat.
    """
    dtype, vec3, vec4, vector = lanes.dtype, lanes.vec3, lanes.vec4, lanes.vector
    v = lanes.functions
    pixels = compositing.make_functions(lanes)
    paint, shade = gradients.make_functions(lanes), stops.make_functions(lanes)
    vec5, vec8 = shade.vec5, shade.vec8
    tile_vectors = wp.constant(lanes.tile_vectors)
    tile_threads = wp.constant(lanes.tile_threads)
    tile_size = wp.constant(lanes.tile_vectors * lanes.tile_threads)
    pair_terms = TERMS + gradients.GRADIENT_TERMS * with_gradients + stops.STOP_TERMS * with_stops
    reducers, terms, canvas_terms = wp.constant(lanes.reducers), wp.constant(pair_terms), wp.constant(CANVAS_TERMS)
    canvas_threads, canvas_reducers = wp.constant(lanes.canvas_threads), wp.constant(lanes.canvas_reducers)
    path_terms = TERMS + gradients.GRADIENT_TERMS * with_gradients
    gathered_terms = wp.constant(path_terms if with_gradients else TERMS if with_curvature else TERMS - 1)
    sums_type = wp.types.vector(path_terms, dtype=dtype)
    local_array = lanes.tile_vectors > 1
    zero, one = wp.constant(dtype(0.0)), wp.constant(dtype(1.0))
    suffix = "_fused" * fused + "_curvature" * with_curvature + "_gradients" * with_gradients + "_stops" * with_stops
    suffix += "_shares" * with_shares
    module = stage_module(f"compositing_adjoint{suffix}", lanes)

    @wp.func
    def clear_hidden(
        hit_begin: int,
        hit_end: int,
        lane: int,
        hit_pair: wp.array(dtype=int),
        pair_class: wp.array(dtype=int),
        pair_slot: wp.array(dtype=int),
        slot_winding: wp.array(dtype=vector),
        pair_sums: wp.array2d(dtype=dtype),
    ):
        """Write zero adjoints for the hits of a tile that are hidden."""
        for hit in range(hit_begin, hit_end):
            pair = hit_pair[hit]
            for term in range(terms):
                v.reduce_tile(pair_sums, pair, term, v.spread(zero), lane)
            if pair_class[pair] == PARTIAL:
                for vector_index in range(tile_vectors):
                    slot_winding[pixels.winding_index(pair_slot[pair], lane * tile_vectors + vector_index)] = v.spread(
                        zero
                    )

    @wp.func
    def add_plain(
        tile: int,
        begin: int,
        end: int,
        hit_pair: wp.array(dtype=int),
        pair_path: wp.array(dtype=int),
        color: wp.array(dtype=vec3),
        opacity: wp.array(dtype=dtype),
        base: vec3,
        tile_moments: wp.array2d(dtype=dtype),
        error_scale: dtype,
        pair_sums: wp.array2d(dtype=dtype),
        tile_sums: wp.array2d(dtype=dtype),
    ):
        """Write the sums of a tile of one colour: that of the background, or of a path that covers all of it.

        They follow from the number of pixels on the canvas, the mean of the target there, and its squared deviation.
        """
        count = tile_moments[tile, 0]
        mean = vec3(tile_moments[tile, 1], tile_moments[tile, 2], tile_moments[tile, 3])
        shown, left = vec3(base), dtype(one)
        if end > begin:
            path = pair_path[hit_pair[begin]]
            shown = base + opacity[path] * (color[path] - base)
            left = one - opacity[path]
        adjoint = (dtype(2.0) * error_scale * count) * (shown - mean)
        if end > begin:
            pair = hit_pair[begin]
            path = pair_path[pair]
            for term in range(terms):
                pair_sums[pair, term] = zero
            for channel in range(3):
                pair_sums[pair, channel] = opacity[path] * adjoint[channel]
            pair_sums[pair, 3] = wp.dot(adjoint, color[path] - base)
        for channel in range(3):
            tile_sums[tile, channel] = left * adjoint[channel]
        tile_sums[tile, 3] = tile_moments[tile, 4] + count * wp.dot(shown - mean, shown - mean)

    @wp.kernel(module=module)
    def composite_adjoint(
        first: int,
        tile_first_hit: wp.array(dtype=int),  # [tiles + 1]
        tile_first_visible: wp.array(dtype=int),  # [tiles]
        hit_pair: wp.array(dtype=int),  # [K]
        pair_path: wp.array(dtype=int),  # [K]
        pair_class: wp.array(dtype=int),  # [K]
        pair_slot: wp.array(dtype=int),  # [K + 1]
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
        tile_reference: wp.array(dtype=vector),  # [tiles, planes, TILE TILE / width] target (fused) or dL/d(image)
        reference_planes: int,  # 3, or 4 for a shifted target (fused only)
        tile_moments: wp.array2d(dtype=dtype),  # [tiles, 5] pixels, means, squared deviation, or none
        has_moments: int,
        error_scale: dtype,  # dL/d(squared error), fused only
        stack_chunk: int,  # tiles that share a stack, one after another; 0: every tile has its own
        stack_depth: int,  # entries of a shared stack
        stack_first: int,  # entries of the tiles before those of this launch, if every tile has its own
        stack: wp.array(dtype=vector),  # [entries, 3, TILE TILE / width] scratch: the colour behind each hit
        slot_share: wp.array(dtype=vector),  # [slots, COLUMNS, TILE / width] of the colour: ``with_shares`` only
        # in: winding, out: dL/d(winding)
        slot_winding: wp.array(dtype=vector),  # [slots, COLUMNS, TILE / width]
        # outputs
        pair_sums: wp.array2d(dtype=dtype),  # [K reducers, terms]
        tile_sums: wp.array2d(dtype=dtype),  # [tiles reducers, TERMS]
    ):
        """Compute the adjoints of one tile (CPU) or one pixel (scalar lanes)."""
        item = first + wp.tid()
        tile = item // tile_threads
        lane = item % tile_threads
        start = tile_first_hit[tile]
        end = tile_first_hit[tile + 1]
        begin = tile_first_visible[tile]
        last_hit = tile_first_hit[(height + TILE - 1) // TILE * tile_columns] - 1
        clear_hidden(start, begin, lane, hit_pair, pair_class, pair_slot, slot_winding, pair_sums)
        if wp.static(fused and local_array and not with_curvature):
            if has_moments != 0:
                is_plain = begin == end
                if end - begin == 1:
                    is_plain = pair_class[hit_pair[begin]] == FULL
                    if wp.static(with_gradients):
                        is_plain = is_plain and paint_kind[pair_path[hit_pair[begin]]] == wp.static(FLAT)
                    if wp.static(with_stops):
                        is_plain = False
                if is_plain:
                    add_plain(
                        tile, begin, end, hit_pair, pair_path, color, opacity, background[0], tile_moments,
                        error_scale, pair_sums, tile_sums,
                    )  # fmt: skip
                    return
        entry0 = start + tile - stack_first
        if stack_chunk > 0:
            entry0 = (tile // stack_chunk) * stack_depth
        part0 = lane * tile_vectors
        stack0 = entry0 * 3 * tile_size + part0

        base = background[0]
        for i in range(tile_vectors):
            v.store(stack, stack0 + i, v.spread(base[0]))
            v.store(stack, stack0 + i + tile_size, v.spread(base[1]))
            v.store(stack, stack0 + i + 2 * tile_size, v.spread(base[2]))
        above = stack0
        for hit in range(begin, end):
            pair = hit_pair[hit]
            path = pair_path[pair]
            c = color[path]
            red, green, blue = v.spread(c[0]), v.spread(c[1]), v.spread(c[2])
            full_alpha = v.spread(opacity[path])
            is_full = pair_class[pair] == FULL
            winding0 = pixels.winding_index(pair_slot[pair], part0)
            if wp.static(with_gradients):
                kind, geometry, e = int(paint_kind[path]), vec4(paint_geometry[path]), vec3(end_color[path])
                slope = paint.slopes(kind, geometry)
                kind = paint.shown_kind(kind, slope)
            if wp.static(with_stops):
                stop_number, form = int(stop_count[path]), vec5(place_form[path])
            # Windings lie anywhere in memory. These are of this tile, or of the next one.
            v.prefetch(slot_winding, pixels.winding_index(pair_slot[hit_pair[wp.min(hit + 2, last_hit)]], 0))
            behind = above
            above += 3 * tile_size
            for i in range(tile_vectors):
                alpha = full_alpha
                if wp.static(with_gradients):
                    if kind != wp.static(FLAT):
                        qx = paint.offset_x(geometry, tile, part0 + i, tile_columns)
                        qy = paint.offset_y(geometry, tile, part0 + i, tile_columns)
                        ramp = paint.share(paint.free_share(kind, slope, qx, qy))
                        red = v.fma(ramp, v.spread(e[0] - c[0]), v.spread(c[0]))
                        green = v.fma(ramp, v.spread(e[1] - c[1]), v.spread(c[1]))
                        blue = v.fma(ramp, v.spread(e[2] - c[2]), v.spread(c[2]))
                if not is_full:
                    alpha = v.mul(full_alpha, pixels.coverage(v.load(slot_winding, winding0 + i)))
                if wp.static(with_stops):
                    place = shade.place_in(form, stop_number, place_kind[path], tile, part0 + i, tile_columns)
                    red, green, blue, stop_alpha = shade.color_at(place, path, stop_number, stop_ramps)
                    alpha = v.mul(alpha, stop_alpha)
                b0 = v.load(stack, behind + i)
                b1 = v.load(stack, behind + i + tile_size)
                b2 = v.load(stack, behind + i + 2 * tile_size)
                v.store(stack, above + i, v.fma(alpha, v.sub(red, b0), b0))
                v.store(stack, above + i + tile_size, v.fma(alpha, v.sub(green, b1), b1))
                v.store(stack, above + i + 2 * tile_size, v.fma(alpha, v.sub(blue, b2), b2))

        if wp.static(local_array):
            transmittance = wp.zeros(shape=(tile_vectors,), dtype=vector)
            g0 = wp.zeros(shape=(tile_vectors,), dtype=vector)
            g1 = wp.zeros(shape=(tile_vectors,), dtype=vector)
            g2 = wp.zeros(shape=(tile_vectors,), dtype=vector)
            if wp.static(with_stops):
                places = wp.zeros(shape=(tile_vectors,), dtype=vector)
                seen0 = wp.zeros(shape=(tile_vectors,), dtype=vector)
                seen1 = wp.zeros(shape=(tile_vectors,), dtype=vector)
                seen2 = wp.zeros(shape=(tile_vectors,), dtype=vector)
                seen3 = wp.zeros(shape=(tile_vectors,), dtype=vector)
        else:
            transmittance = v.spread(one)
            g0 = v.spread(zero)
            g1 = v.spread(zero)
            g2 = v.spread(zero)
            if wp.static(with_stops):
                places = v.spread(zero)
                seen0 = v.spread(zero)
                seen1 = v.spread(zero)
                seen2 = v.spread(zero)
                seen3 = v.spread(zero)
        squared_error = v.spread(zero)
        reference0 = tile * reference_planes * tile_size + part0
        for i in range(tile_vectors):
            v.put(transmittance, i, v.spread(one))
            r0 = v.load(tile_reference, reference0 + i)
            r1 = v.load(tile_reference, reference0 + i + tile_size)
            r2 = v.load(tile_reference, reference0 + i + 2 * tile_size)
            if wp.static(fused):
                mask = pixels.on_canvas(tile, part0 + i, tile_columns, height, width_px)
                r0 = v.mul(mask, v.sub(v.load(stack, above + i), r0))
                r1 = v.mul(mask, v.sub(v.load(stack, above + i + tile_size), r1))
                r2 = v.mul(mask, v.sub(v.load(stack, above + i + 2 * tile_size), r2))
                squared_error = v.fma(r0, r0, v.fma(r1, r1, v.fma(r2, r2, squared_error)))
                if reference_planes > 3:
                    shift = v.load(tile_reference, reference0 + i + 3 * tile_size)  # 0 outside of the canvas
                    r0, r1, r2 = v.sub(r0, shift), v.sub(r1, shift), v.sub(r2, shift)
                scale = v.spread(dtype(2.0) * error_scale)
                r0, r1, r2 = v.mul(scale, r0), v.mul(scale, r1), v.mul(scale, r2)
            v.put(g0, i, r0)
            v.put(g1, i, r1)
            v.put(g2, i, r2)

        for below in range(end - begin):
            hit = end - 1 - below
            above -= 3 * tile_size
            pair = hit_pair[hit]
            path = pair_path[pair]
            c = color[path]
            red, green, blue = v.spread(c[0]), v.spread(c[1]), v.spread(c[2])
            full_alpha = v.spread(opacity[path])
            is_full = pair_class[pair] == FULL
            winding0 = pixels.winding_index(pair_slot[pair], part0)
            adj_red, adj_green, adj_blue = v.spread(zero), v.spread(zero), v.spread(zero)
            adj_opacity, curvature = v.spread(zero), v.spread(zero)
            if wp.static(with_gradients):
                kind, geometry, e = int(paint_kind[path]), vec4(paint_geometry[path]), vec3(end_color[path])
                slope = paint.slopes(kind, geometry)
                kind = paint.shown_kind(kind, slope)
                end_red, end_green, end_blue = v.spread(zero), v.spread(zero), v.spread(zero)
                moment0, moment1, moment2 = v.spread(zero), v.spread(zero), v.spread(zero)
            if wp.static(with_stops):
                stop_number, form = int(stop_count[path]), vec5(place_form[path])
                adj_stop_alpha = v.spread(zero)
                moment0, moment1, moment2 = v.spread(zero), v.spread(zero), v.spread(zero)
                moment3, moment4, moment5 = v.spread(zero), v.spread(zero), v.spread(zero)
            for i in range(tile_vectors):
                t = v.get(transmittance, i)
                a0, a1, a2 = v.get(g0, i), v.get(g1, i), v.get(g2, i)
                if wp.static(with_gradients):
                    if kind != wp.static(FLAT):
                        qx = paint.offset_x(geometry, tile, part0 + i, tile_columns)
                        qy = paint.offset_y(geometry, tile, part0 + i, tile_columns)
                        free = paint.free_share(kind, slope, qx, qy)
                        ramp = paint.share(free)
                        red = v.fma(ramp, v.spread(e[0] - c[0]), v.spread(c[0]))
                        green = v.fma(ramp, v.spread(e[1] - c[1]), v.spread(c[1]))
                        blue = v.fma(ramp, v.spread(e[2] - c[2]), v.spread(c[2]))
                if wp.static(with_stops):
                    place = shade.place_in(form, stop_number, place_kind[path], tile, part0 + i, tile_columns)
                    red, green, blue, stop_alpha = shade.color_at(place, path, stop_number, stop_ramps)
                d0 = v.sub(red, v.load(stack, above + i))
                d1 = v.sub(green, v.load(stack, above + i + tile_size))
                d2 = v.sub(blue, v.load(stack, above + i + 2 * tile_size))
                adj_alpha = v.mul(t, v.fma(a0, d0, v.fma(a1, d1, v.mul(a2, d2))))
                covered = v.spread(one)
                if not is_full:
                    winding = v.load(slot_winding, winding0 + i)
                    covered = pixels.coverage(winding)
                    adj_covered = v.mul(adj_alpha, full_alpha)
                    if wp.static(with_stops):
                        adj_covered = v.mul(adj_covered, stop_alpha)
                    v.store(slot_winding, winding0 + i, v.mul(adj_covered, pixels.coverage_slope(winding)))
                if wp.static(with_stops):
                    seen_alpha = v.mul(v.mul(adj_alpha, full_alpha), covered)
                    covered = v.mul(covered, stop_alpha)
                visible = v.mul(t, v.mul(full_alpha, covered))
                shown = visible
                if wp.static(with_shares):
                    if not is_full:
                        shown = v.mul(t, v.mul(full_alpha, v.load(slot_share, winding0 + i)))
                adj_red = v.fma(shown, a0, adj_red)
                adj_green = v.fma(shown, a1, adj_green)
                adj_blue = v.fma(shown, a2, adj_blue)
                adj_opacity = v.fma(adj_alpha, covered, adj_opacity)
                if wp.static(with_gradients):
                    if kind != wp.static(FLAT):
                        ramped = v.mul(visible, ramp)
                        end_red = v.fma(ramped, a0, end_red)
                        end_green = v.fma(ramped, a1, end_green)
                        end_blue = v.fma(ramped, a2, end_blue)
                        contrast = v.fma(
                            a0,
                            v.spread(e[0] - c[0]),
                            v.fma(a1, v.spread(e[1] - c[1]), v.mul(a2, v.spread(e[2] - c[2]))),
                        )
                        adj_share = paint.on_ramp(free, v.mul(visible, contrast))
                        along = v.mul(adj_share, paint.offset_weight(kind, slope, qx, qy))
                        moment0 = v.fma(adj_share, paint.share_weight(kind, ramp), moment0)
                        moment1 = v.fma(along, v.spread(qx), moment1)
                        moment2 = v.fma(along, qy, moment2)
                if wp.static(with_stops):
                    adj_stop_alpha = v.add(adj_stop_alpha, seen_alpha)
                    if stop_number > 1:
                        r0, r1, r2 = v.mul(visible, a0), v.mul(visible, a1), v.mul(visible, a2)
                        v.put(places, i, place)
                        v.put(seen0, i, r0)
                        v.put(seen1, i, r1)
                        v.put(seen2, i, r2)
                        v.put(seen3, i, seen_alpha)
                        adj_place = shade.adj_place(place, r0, r1, r2, seen_alpha, path, stop_number, stop_ramps)
                        along = v.mul(adj_place, shade.offset_weight(place_kind[path], place))
                        qx = shade.offset_x(form, tile, part0 + i, tile_columns)
                        qy = shade.offset_y(form, tile, part0 + i, tile_columns)
                        along_x, along_y = v.mul(along, v.spread(qx)), v.mul(along, qy)
                        moment0 = v.add(moment0, adj_place)
                        moment1, moment2 = v.add(moment1, along_x), v.add(moment2, along_y)
                        moment3 = v.fma(along_x, v.spread(qx), moment3)
                        moment4 = v.fma(along_x, qy, moment4)
                        moment5 = v.fma(along_y, qy, moment5)
                if wp.static(with_curvature):
                    change = v.mul(t, covered)  # of the colour, by the opacity, per unit of c - B
                    mask = pixels.on_canvas(tile, part0 + i, tile_columns, height, width_px)
                    square = v.mul(mask, v.mul(change, change))
                    curvature = v.fma(square, v.fma(d0, d0, v.fma(d1, d1, v.mul(d2, d2))), curvature)
                v.put(transmittance, i, v.sub(t, visible))
            v.reduce_tile(pair_sums, pair, 0, adj_red, lane)
            v.reduce_tile(pair_sums, pair, 1, adj_green, lane)
            v.reduce_tile(pair_sums, pair, 2, adj_blue, lane)
            v.reduce_tile(pair_sums, pair, 3, adj_opacity, lane)
            if wp.static(with_curvature):
                v.reduce_tile(pair_sums, pair, 4, curvature, lane)
            if wp.static(with_gradients):
                v.reduce_tile(pair_sums, pair, 5, end_red, lane)
                v.reduce_tile(pair_sums, pair, 6, end_green, lane)
                v.reduce_tile(pair_sums, pair, 7, end_blue, lane)
                v.reduce_tile(pair_sums, pair, 8, moment0, lane)
                v.reduce_tile(pair_sums, pair, 9, moment1, lane)
                v.reduce_tile(pair_sums, pair, 10, moment2, lane)
            if wp.static(with_stops):
                v.reduce_tile(pair_sums, pair, 5, adj_stop_alpha, lane)
                v.reduce_tile(pair_sums, pair, 6, moment0, lane)
                v.reduce_tile(pair_sums, pair, 7, moment1, lane)
                v.reduce_tile(pair_sums, pair, 8, moment2, lane)
                v.reduce_tile(pair_sums, pair, 9, moment3, lane)
                v.reduce_tile(pair_sums, pair, 10, moment4, lane)
                v.reduce_tile(pair_sums, pair, 11, moment5, lane)
                for stop in range(1, stop_number):
                    row = stop_ramps[path, stop]
                    sum0, sum1, sum2 = v.spread(zero), v.spread(zero), v.spread(zero)
                    sum3, sum4, sum5 = v.spread(zero), v.spread(zero), v.spread(zero)
                    for i in range(tile_vectors):
                        place = v.get(places, i)
                        r0, r1, r2 = v.get(seen0, i), v.get(seen1, i), v.get(seen2, i)
                        seen_alpha = v.get(seen3, i)
                        part = shade.share(place, row)
                        sum0, sum1 = v.fma(r0, part, sum0), v.fma(r1, part, sum1)
                        sum2, sum3 = v.fma(r2, part, sum2), v.fma(seen_alpha, part, sum3)
                        steep = shade.steepness(place, row, r0, r1, r2, seen_alpha)
                        sum4, sum5 = v.add(sum4, steep), v.fma(steep, part, sum5)
                    term0 = wp.static(FIRST_STOP_TERM) + (stop - 1) * wp.static(stops.SEGMENT_TERMS)
                    v.reduce_tile(pair_sums, pair, term0, sum0, lane)
                    v.reduce_tile(pair_sums, pair, term0 + 1, sum1, lane)
                    v.reduce_tile(pair_sums, pair, term0 + 2, sum2, lane)
                    v.reduce_tile(pair_sums, pair, term0 + 3, sum3, lane)
                    v.reduce_tile(pair_sums, pair, term0 + 4, sum4, lane)
                    v.reduce_tile(pair_sums, pair, term0 + 5, sum5, lane)

        adj_red, adj_green, adj_blue = v.spread(zero), v.spread(zero), v.spread(zero)
        for i in range(tile_vectors):
            t = v.get(transmittance, i)
            adj_red = v.fma(t, v.get(g0, i), adj_red)
            adj_green = v.fma(t, v.get(g1, i), adj_green)
            adj_blue = v.fma(t, v.get(g2, i), adj_blue)
        v.reduce_tile(tile_sums, tile, 0, adj_red, lane)
        v.reduce_tile(tile_sums, tile, 1, adj_green, lane)
        v.reduce_tile(tile_sums, tile, 2, adj_blue, lane)
        v.reduce_tile(tile_sums, tile, 3, squared_error, lane)

    @wp.kernel(module=module)
    def gather_paths_adjoint(
        first: int,
        path_first_pair: wp.array(dtype=int),  # [N + 1]
        pair_class: wp.array(dtype=int),  # [K]
        sums: wp.array2d(dtype=dtype),  # of pairs [K, terms]; on scalar lanes of paths [N reducers, terms]
        paint_kind: wp.array(dtype=int),  # [N] this and the next: ``with_gradients`` only
        paint_geometry: wp.array(dtype=vec4),  # [N] px
        # outputs
        adj_color: wp.array(dtype=vec3),  # [N]
        adj_opacity: wp.array(dtype=dtype),  # [N]
        opacity_curvature: wp.array(dtype=dtype),  # [N], for ``with_curvature``
        adj_end_color: wp.array(dtype=vec3),  # [N] this and the next: ``with_gradients`` only
        adj_geometry: wp.array(dtype=vec4),  # [N]
    ):
        """Add the sums of one path, in their fixed order."""
        path = first + wp.tid()
        total = sums_type()
        if wp.static(lanes.width == 1):
            for row in range(path * reducers, (path + 1) * reducers):
                for term in range(gathered_terms):
                    total[term] = total[term] + sums[row, term]
        else:
            for pair in range(path_first_pair[path], path_first_pair[path + 1]):
                if pair_class[pair] != EMPTY:
                    for term in range(gathered_terms):
                        total[term] = total[term] + sums[pair, term]
        if wp.static(with_gradients):
            adj_end_color[path] = vec3(total[5], total[6], total[7])
            moments = vec3(total[8], total[9], total[10])
            adj_geometry[path] = paint.geometry_adjoint(paint_kind[path], paint_geometry[path], moments)
            for term in range(3):
                total[term] = total[term] - total[TERMS + term]
        adj_color[path] = vec3(total[0], total[1], total[2])
        adj_opacity[path] = total[3]
        if wp.static(with_curvature):
            opacity_curvature[path] = total[4]

    @wp.kernel(module=module)
    def gather_stops(
        first: int,
        path_first_pair: wp.array(dtype=int),  # [N + 1]
        pair_class: wp.array(dtype=int),  # [K]
        pair_sums: wp.array2d(dtype=dtype),  # [K reducers, terms]
        stop_count: wp.array(dtype=int),  # [N]
        # outputs
        stop_sums: wp.array2d(dtype=dtype),  # [N, STOP_TERMS]
    ):
        """Add one of the sums of a path for its stops over its pairs, in their fixed order."""
        item = first + wp.tid()
        path, term = item // wp.static(stops.STOP_TERMS), item % wp.static(stops.STOP_TERMS)
        total = dtype(0.0)
        if term < wp.static(stops.WHOLE_TERMS) + (stop_count[path] - 1) * wp.static(stops.SEGMENT_TERMS):
            for pair in range(path_first_pair[path], path_first_pair[path + 1]):
                if pair_class[pair] != EMPTY:
                    for row in range(pair * reducers, (pair + 1) * reducers):
                        total = total + pair_sums[row, wp.static(TERMS) + term]
        stop_sums[path, term] = total

    @wp.kernel(module=module)
    def gather_tiles(
        first: int,
        tile_sums: wp.array2d(dtype=dtype),  # [tiles reducers, TERMS]
        row_count: int,
        # outputs
        group_sums: wp.array2d(dtype=wp.float64),  # [canvas_reducers, CANVAS_TERMS]
    ):
        """Add every ``canvas_threads``-th row in each thread, and the threads of a group to one sum."""
        thread = first + wp.tid()
        total = wp.vec4d()
        row = int(thread)
        while row < row_count:
            for term in range(canvas_terms):
                total[term] = total[term] + wp.float64(tile_sums[row, term])
            row += canvas_threads
        for term in range(canvas_terms):
            v.reduce_canvas(group_sums, term, total[term], thread)

    @wp.kernel(module=module)
    def gather_canvas(
        first: int,
        group_sums: wp.array2d(dtype=wp.float64),  # [canvas_reducers, CANVAS_TERMS]
        error_scale: dtype,
        overflow: wp.array(dtype=int),  # [4] counts that exceeded their capacity
        # in and out
        dropped_steps: wp.array(dtype=int),  # [1] number of steps that overflowed
        # outputs
        fits: wp.array(dtype=wp.float64),  # [1] 1, or -1 for a step that overflowed
        canvas_sums: wp.array(dtype=dtype),  # [CANVAS_TERMS] dL/d(background) and the error times ``error_scale``
    ):
        """Add one sum over all tiles. A step that overflowed gets a zero gradient and leaves the error as it was."""
        term = first + wp.tid()
        value = wp.float64(0.0)
        for row in range(canvas_reducers):
            value += group_sums[row, term]
        sum_here = dtype(value)
        overflowed = overflow[0] + overflow[1] + overflow[2] + overflow[3] > 0
        if term < canvas_terms - 1:
            canvas_sums[term] = wp.where(overflowed, zero, sum_here)
        else:
            fits[0] = wp.where(overflowed, wp.float64(-1.0), wp.float64(1.0))
            if overflowed:
                dropped_steps[0] = dropped_steps[0] + 1
            else:
                canvas_sums[term] = sum_here * error_scale

    own = (gather_stops,) if with_stops else ()
    if lanes.width == 1:
        own = (*own, _gather_pairs(lanes, module, sums_type, gathered_terms))
    return bundle(composite_adjoint, gather_paths_adjoint, *own, gather_tiles, gather_canvas)


def _gather_pairs(lanes: Lanes, module: Any, sums_type: Any, gathered_terms: int) -> Any:
    dtype, v = lanes.dtype, lanes.functions
    tile_threads, reducers = wp.constant(lanes.tile_threads), wp.constant(lanes.reducers)

    @wp.kernel(module=module)
    def gather_pairs(
        first: int,
        path_first_pair: wp.array(dtype=int),  # [N + 1]
        pair_class: wp.array(dtype=int),  # [K]
        pair_sums: wp.array2d(dtype=dtype),  # [K reducers, terms]
        # outputs
        path_sums: wp.array2d(dtype=dtype),  # [N reducers, terms]
    ):
        """Add every ``tile_threads``-th sum of a path in each thread, and the threads of a group to one sum."""
        thread = first + wp.tid()
        path, lane = thread // tile_threads, thread % tile_threads
        total = sums_type()
        row = path_first_pair[path] * reducers + lane
        row_end = path_first_pair[path + 1] * reducers
        while row < row_end:
            if pair_class[row // reducers] != EMPTY:
                for term in range(gathered_terms):
                    total[term] = total[term] + pair_sums[row, term]
            row += tile_threads
        for term in range(gathered_terms):
            v.reduce_tile(path_sums, path, term, total[term], lane)

    return gather_pairs
