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

from functools import cache
from types import SimpleNamespace

import warp as wp

from warpvec.geometry.gradients import FLAT
from warpvec.kernels import compositing, gradients
from warpvec.kernels.constants import EMPTY, FULL, PARTIAL, TILE
from warpvec.kernels.lanes import Lanes, stage_module

TERMS = 5
"""Number of sums. A pair has five: dL/d(red), dL/d(green), dL/d(blue), dL/d(opacity), opacity curvature. A tile uses
the first CANVAS_TERMS for the sums over the canvas; its fifth is unused. A scene with gradients has
``gradients.GRADIENT_TERMS`` more."""

CANVAS_TERMS = 4
"""Number of sums over the canvas, and of those that a tile uses: three of dL/d(background), and the squared error."""


@cache
def make_kernels(lanes: Lanes, fused: bool, with_curvature: bool, with_gradients: bool = False) -> SimpleNamespace:
    """Return ``composite_adjoint``, ``gather_paths_adjoint``, ``gather_tiles`` and ``gather_canvas``.

    Args:
        lanes: width and precision.
        fused: whether ``tile_reference`` is the target, and the loss the squared error against it; if not, it is
            dL/d(image).
        with_curvature: whether to fill the fifth sum of each pair.
        with_gradients: whether the scene has gradients; if not, their arrays are not touched.
    """
    dtype, vec3, vec4, vector = lanes.dtype, lanes.vec3, lanes.vec4, lanes.vector
    mul, fma, sub = lanes.mul, lanes.fma, lanes.sub
    spread, get, put, load, store = lanes.spread, lanes.get, lanes.put, lanes.load, lanes.store
    prefetch = lanes.prefetch
    reduce_tile, reduce_canvas = lanes.reduce_tile, lanes.reduce_canvas
    functions = compositing.make_functions(lanes)
    winding_index, on_canvas = functions.winding_index, functions.on_canvas
    coverage, coverage_slope = functions.coverage, functions.coverage_slope
    paint = gradients.make_functions(lanes)
    slopes, offset_x, offset_y, free_share = paint.slopes, paint.offset_x, paint.offset_y, paint.free_share
    share, on_ramp, unit_or_share = paint.share, paint.on_ramp, paint.unit_or_share
    inverse_length, geometry_adjoint = paint.inverse_length, paint.geometry_adjoint
    tile_vectors = wp.constant(lanes.tile_vectors)
    tile_threads = wp.constant(lanes.tile_threads)
    tile_size = wp.constant(lanes.tile_vectors * lanes.tile_threads)
    pair_terms = TERMS + gradients.GRADIENT_TERMS * with_gradients
    reducers, terms, canvas_terms = wp.constant(lanes.reducers), wp.constant(pair_terms), wp.constant(CANVAS_TERMS)
    canvas_threads, canvas_reducers = wp.constant(lanes.canvas_threads), wp.constant(lanes.canvas_reducers)
    gathered_terms = wp.constant(pair_terms if with_gradients else TERMS if with_curvature else TERMS - 1)
    sums_type = wp.types.vector(pair_terms, dtype=dtype)
    local_array = lanes.tile_vectors > 1
    zero, one = wp.constant(dtype(0.0)), wp.constant(dtype(1.0))
    suffix = "_fused" * fused + "_curvature" * with_curvature + "_gradients" * with_gradients
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
                reduce_tile(pair_sums, pair, term, spread(zero), lane)
            if pair_class[pair] == PARTIAL:
                for vector_index in range(tile_vectors):
                    slot_winding[winding_index(pair_slot[pair], lane * tile_vectors + vector_index)] = spread(zero)

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
        tile_columns: int,
        height: int,
        width_px: int,
        tile_reference: wp.array(dtype=vector),  # [tiles, planes, TILE TILE / width] target (fused) or dL/d(image)
        reference_planes: int,  # 3, or 4 for a shifted target (fused only)
        error_scale: dtype,  # dL/d(squared error), fused only
        stack_chunk: int,  # tiles that share a stack, one after another; 0: every tile has its own
        stack_depth: int,  # entries of a shared stack
        stack_first: int,  # entries of the tiles before those of this launch, if every tile has its own
        stack: wp.array(dtype=vector),  # [entries, 3, TILE TILE / width] scratch: the colour behind each hit
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
        entry0 = start + tile - stack_first
        if stack_chunk > 0:
            entry0 = (tile // stack_chunk) * stack_depth
        part0 = lane * tile_vectors
        stack0 = entry0 * 3 * tile_size + part0

        base = background[0]
        for v in range(tile_vectors):
            store(stack, stack0 + v, spread(base[0]))
            store(stack, stack0 + v + tile_size, spread(base[1]))
            store(stack, stack0 + v + 2 * tile_size, spread(base[2]))
        above = stack0
        for hit in range(begin, end):
            pair = hit_pair[hit]
            path = pair_path[pair]
            c = color[path]
            red, green, blue = spread(c[0]), spread(c[1]), spread(c[2])
            full_alpha = spread(opacity[path])
            is_full = pair_class[pair] == FULL
            winding0 = winding_index(pair_slot[pair], part0)
            if wp.static(with_gradients):
                kind, geometry, e = int(paint_kind[path]), vec4(paint_geometry[path]), vec3(end_color[path])
                slope = slopes(kind, geometry)
            # Windings lie anywhere in memory. These are of this tile, or of the next one.
            prefetch(slot_winding, winding_index(pair_slot[hit_pair[wp.min(hit + 2, last_hit)]], 0))
            behind = above
            above += 3 * tile_size
            for v in range(tile_vectors):
                alpha = full_alpha
                if wp.static(with_gradients):
                    if kind != wp.static(FLAT):
                        qx = offset_x(geometry, tile, part0 + v, tile_columns)
                        qy = offset_y(geometry, tile, part0 + v, tile_columns)
                        ramp = share(free_share(slope, qx, qy))
                        red = fma(ramp, spread(e[0] - c[0]), spread(c[0]))
                        green = fma(ramp, spread(e[1] - c[1]), spread(c[1]))
                        blue = fma(ramp, spread(e[2] - c[2]), spread(c[2]))
                if not is_full:
                    alpha = mul(full_alpha, coverage(load(slot_winding, winding0 + v)))
                b0, b1, b2 = (
                    load(stack, behind + v),
                    load(stack, behind + v + tile_size),
                    load(stack, behind + v + 2 * tile_size),
                )
                store(stack, above + v, fma(alpha, sub(red, b0), b0))
                store(stack, above + v + tile_size, fma(alpha, sub(green, b1), b1))
                store(stack, above + v + 2 * tile_size, fma(alpha, sub(blue, b2), b2))

        if wp.static(local_array):
            transmittance = wp.zeros(shape=(tile_vectors,), dtype=vector)
            g0 = wp.zeros(shape=(tile_vectors,), dtype=vector)
            g1 = wp.zeros(shape=(tile_vectors,), dtype=vector)
            g2 = wp.zeros(shape=(tile_vectors,), dtype=vector)
        else:
            transmittance = spread(one)
            g0 = spread(zero)
            g1 = spread(zero)
            g2 = spread(zero)
        squared_error = spread(zero)
        reference0 = tile * reference_planes * tile_size + part0
        for v in range(tile_vectors):
            put(transmittance, v, spread(one))
            r0 = load(tile_reference, reference0 + v)
            r1 = load(tile_reference, reference0 + v + tile_size)
            r2 = load(tile_reference, reference0 + v + 2 * tile_size)
            if wp.static(fused):
                mask = on_canvas(tile, part0 + v, tile_columns, height, width_px)
                r0 = mul(mask, sub(load(stack, above + v), r0))
                r1 = mul(mask, sub(load(stack, above + v + tile_size), r1))
                r2 = mul(mask, sub(load(stack, above + v + 2 * tile_size), r2))
                squared_error = fma(r0, r0, fma(r1, r1, fma(r2, r2, squared_error)))
                if reference_planes > 3:
                    shift = load(tile_reference, reference0 + v + 3 * tile_size)  # 0 outside of the canvas
                    r0, r1, r2 = sub(r0, shift), sub(r1, shift), sub(r2, shift)
                scale = spread(dtype(2.0) * error_scale)
                r0, r1, r2 = mul(scale, r0), mul(scale, r1), mul(scale, r2)
            put(g0, v, r0)
            put(g1, v, r1)
            put(g2, v, r2)

        for below in range(end - begin):
            hit = end - 1 - below
            above -= 3 * tile_size
            pair = hit_pair[hit]
            path = pair_path[pair]
            c = color[path]
            red, green, blue = spread(c[0]), spread(c[1]), spread(c[2])
            full_alpha = spread(opacity[path])
            is_full = pair_class[pair] == FULL
            winding0 = winding_index(pair_slot[pair], part0)
            adj_red, adj_green, adj_blue = spread(zero), spread(zero), spread(zero)
            adj_opacity, curvature = spread(zero), spread(zero)
            if wp.static(with_gradients):
                kind, geometry, e = int(paint_kind[path]), vec4(paint_geometry[path]), vec3(end_color[path])
                slope = slopes(kind, geometry)
                end_red, end_green, end_blue = spread(zero), spread(zero), spread(zero)
                moment0, moment1, moment2 = spread(zero), spread(zero), spread(zero)
            for v in range(tile_vectors):
                t = get(transmittance, v)
                a0, a1, a2 = get(g0, v), get(g1, v), get(g2, v)
                if wp.static(with_gradients):
                    if kind != wp.static(FLAT):
                        qx = offset_x(geometry, tile, part0 + v, tile_columns)
                        qy = offset_y(geometry, tile, part0 + v, tile_columns)
                        free = free_share(slope, qx, qy)
                        ramp = share(free)
                        red = fma(ramp, spread(e[0] - c[0]), spread(c[0]))
                        green = fma(ramp, spread(e[1] - c[1]), spread(c[1]))
                        blue = fma(ramp, spread(e[2] - c[2]), spread(c[2]))
                d0 = sub(red, load(stack, above + v))
                d1 = sub(green, load(stack, above + v + tile_size))
                d2 = sub(blue, load(stack, above + v + 2 * tile_size))
                adj_alpha = mul(t, fma(a0, d0, fma(a1, d1, mul(a2, d2))))
                covered = spread(one)
                if not is_full:
                    winding = load(slot_winding, winding0 + v)
                    covered = coverage(winding)
                    store(slot_winding, winding0 + v, mul(mul(adj_alpha, full_alpha), coverage_slope(winding)))
                visible = mul(t, mul(full_alpha, covered))
                adj_red = fma(visible, a0, adj_red)
                adj_green = fma(visible, a1, adj_green)
                adj_blue = fma(visible, a2, adj_blue)
                adj_opacity = fma(adj_alpha, covered, adj_opacity)
                if wp.static(with_gradients):
                    if kind != wp.static(FLAT):
                        ramped = mul(visible, ramp)
                        end_red = fma(ramped, a0, end_red)
                        end_green = fma(ramped, a1, end_green)
                        end_blue = fma(ramped, a2, end_blue)
                        contrast = fma(
                            a0, spread(e[0] - c[0]), fma(a1, spread(e[1] - c[1]), mul(a2, spread(e[2] - c[2])))
                        )
                        adj_share = on_ramp(free, mul(visible, contrast))
                        along = mul(adj_share, inverse_length(slope, qx, qy))
                        moment0 = fma(adj_share, unit_or_share(slope, ramp), moment0)
                        moment1 = fma(along, spread(qx), moment1)
                        moment2 = fma(along, qy, moment2)
                if wp.static(with_curvature):
                    change = mul(t, covered)  # of the colour, by the opacity, per unit of c - B
                    mask = on_canvas(tile, part0 + v, tile_columns, height, width_px)
                    square = mul(mask, mul(change, change))
                    curvature = fma(square, fma(d0, d0, fma(d1, d1, mul(d2, d2))), curvature)
                put(transmittance, v, sub(t, visible))
            reduce_tile(pair_sums, pair, 0, adj_red, lane)
            reduce_tile(pair_sums, pair, 1, adj_green, lane)
            reduce_tile(pair_sums, pair, 2, adj_blue, lane)
            reduce_tile(pair_sums, pair, 3, adj_opacity, lane)
            if wp.static(with_curvature):
                reduce_tile(pair_sums, pair, 4, curvature, lane)
            if wp.static(with_gradients):
                reduce_tile(pair_sums, pair, 5, end_red, lane)
                reduce_tile(pair_sums, pair, 6, end_green, lane)
                reduce_tile(pair_sums, pair, 7, end_blue, lane)
                reduce_tile(pair_sums, pair, 8, moment0, lane)
                reduce_tile(pair_sums, pair, 9, moment1, lane)
                reduce_tile(pair_sums, pair, 10, moment2, lane)

        adj_red, adj_green, adj_blue = spread(zero), spread(zero), spread(zero)
        for v in range(tile_vectors):
            t = get(transmittance, v)
            adj_red = fma(t, get(g0, v), adj_red)
            adj_green = fma(t, get(g1, v), adj_green)
            adj_blue = fma(t, get(g2, v), adj_blue)
        reduce_tile(tile_sums, tile, 0, adj_red, lane)
        reduce_tile(tile_sums, tile, 1, adj_green, lane)
        reduce_tile(tile_sums, tile, 2, adj_blue, lane)
        reduce_tile(tile_sums, tile, 3, squared_error, lane)

    @wp.kernel(module=module)
    def gather_paths_adjoint(
        first: int,
        path_first_pair: wp.array(dtype=int),  # [N + 1]
        pair_class: wp.array(dtype=int),  # [K]
        pair_sums: wp.array2d(dtype=dtype),  # [K reducers, terms]
        paint_kind: wp.array(dtype=int),  # [N] this and the next: ``with_gradients`` only
        paint_geometry: wp.array(dtype=vec4),  # [N] px
        # outputs
        adj_color: wp.array(dtype=vec3),  # [N]
        adj_opacity: wp.array(dtype=dtype),  # [N]
        opacity_curvature: wp.array(dtype=dtype),  # [N], for ``with_curvature``
        adj_end_color: wp.array(dtype=vec3),  # [N] this and the next: ``with_gradients`` only
        adj_geometry: wp.array(dtype=vec4),  # [N]
    ):
        """Add the sums of one path over its pairs, in their fixed order."""
        path = first + wp.tid()
        total = sums_type()
        for pair in range(path_first_pair[path], path_first_pair[path + 1]):
            if pair_class[pair] != EMPTY:
                for row in range(pair * reducers, (pair + 1) * reducers):
                    for term in range(gathered_terms):
                        total[term] = total[term] + pair_sums[row, term]
        if wp.static(with_gradients):
            adj_end_color[path] = vec3(total[5], total[6], total[7])
            moments = vec3(total[8], total[9], total[10])
            adj_geometry[path] = geometry_adjoint(paint_kind[path], paint_geometry[path], moments)
            for term in range(3):
                total[term] = total[term] - total[TERMS + term]
        adj_color[path] = vec3(total[0], total[1], total[2])
        adj_opacity[path] = total[3]
        if wp.static(with_curvature):
            opacity_curvature[path] = total[4]

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
        red, green, blue, error = wp.float64(0.0), wp.float64(0.0), wp.float64(0.0), wp.float64(0.0)
        row = int(thread)
        while row < row_count:
            red += wp.float64(tile_sums[row, 0])
            green += wp.float64(tile_sums[row, 1])
            blue += wp.float64(tile_sums[row, 2])
            error += wp.float64(tile_sums[row, 3])
            row += canvas_threads
        reduce_canvas(group_sums, 0, red, thread)
        reduce_canvas(group_sums, 1, green, thread)
        reduce_canvas(group_sums, 2, blue, thread)
        reduce_canvas(group_sums, 3, error, thread)

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

    return SimpleNamespace(
        composite_adjoint=composite_adjoint,
        gather_paths_adjoint=gather_paths_adjoint,
        gather_tiles=gather_tiles,
        gather_canvas=gather_canvas,
    )
