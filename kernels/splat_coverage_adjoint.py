"""Adjoint of stage 3 of the splat renderer: dL/d(coverage) of the pixels -> sums over the pixels of each Gaussian.

Each thread owns one Gaussian and its sums, and only reads pixels, so no atomics are needed. With T the path's own
transmittance at a pixel, d(coverage)/d(alpha) = T / (1 - alpha). A clipped or dropped alpha has a zero derivative. The
code of Vector Scaffolding divides by at least 1 - 0.99, and differentiates what it clips; that is given by two numbers.
"""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels import compositing, splat_binning, splat_coverage
from warpvec.kernels.constants import PARTIAL, SPLAT_ALPHA_MIN, TILE
from warpvec.kernels.lanes import Lanes, bundle, stage_module
from warpvec.kernels.making import made_once
from warpvec.kernels.splatting import PLANES
from warpvec.kernels.splatting_adjoint import CENTER_TERMS, COVARIANCE_TERMS


@made_once
def make_kernels(lanes: Lanes, covariance: bool) -> SimpleNamespace:
    """Return ``cover_splats_adjoint``; with ``covariance`` it also fills the sums of the covariance."""
    dtype, vector = lanes.dtype, lanes.vector
    v = lanes.functions
    gaussian = splat_coverage.make_functions(lanes).gaussian
    covered = splat_binning.make_functions(lanes).covered
    winding_index = compositing.make_functions(lanes).winding_index
    zero, half, one = (wp.constant(dtype(value)) for value in (0.0, 0.5, 1.0))
    alpha_min = wp.constant(dtype(SPLAT_ALPHA_MIN))
    planes, terms = wp.constant(PLANES), wp.constant(COVARIANCE_TERMS if covariance else CENTER_TERMS)
    blocks, width = wp.constant(lanes.blocks), wp.constant(lanes.width)
    module = stage_module("splat_coverage_adjoint" + "_covariance" * covariance, lanes)

    @wp.func
    def alpha_adjoint(alpha: vector, adj_coverage: vector, transmittance: vector, free_max: dtype, divided_max: dtype):
        """Return dL/d(alpha) alpha, or 0 where alpha is dropped or, from ``free_max`` on, clipped."""
        kept = v.where_less(alpha, v.spread(alpha_min), v.spread(zero), alpha)
        free = v.where_less(kept, v.spread(free_max), kept, v.spread(zero))
        left = v.sub(v.spread(one), v.minimum(free, v.spread(divided_max)))
        return v.mul(free, v.quotient(v.mul(adj_coverage, transmittance), left))

    @wp.kernel(module=module)
    def cover_splats_adjoint(
        first: int,
        path_tile_box: wp.array(dtype=wp.vec4i),  # [N]
        path_first_pair: wp.array(dtype=int),  # [N + 1]
        pair_class: wp.array(dtype=int),  # [K]
        pair_slot: wp.array(dtype=int),  # [K + 1]
        pair_is_visible: wp.array(dtype=int),  # [K]
        splats: wp.array(dtype=dtype),  # [N, rows, PLANES, samples]
        row_opacity: wp.array(dtype=dtype),  # [N rows]
        row_count: int,
        sample_stride: int,
        height: int,
        width_px: int,
        free_max: dtype,  # alpha from which on there is no derivative
        divided_max: dtype,  # largest alpha in 1 - alpha
        adj_slot_coverage: wp.array(dtype=vector),  # [slots, COLUMNS, TILE / width]
        slot_transmittance: wp.array(dtype=vector),  # [slots, COLUMNS, TILE / width]
        # outputs
        splat_sums: wp.array(dtype=dtype),  # [N, rows, terms, samples], see splatting_adjoint
    ):
        """Add the sums of one Gaussian over its pixels."""
        item = first + wp.tid()
        row = item // sample_stride
        sample = item % sample_stride
        path = row // row_count
        splat = row * planes * sample_stride + sample
        weight, weight_x, weight_y = v.spread(zero), v.spread(zero), v.spread(zero)
        if wp.static(covariance):
            weight_xx, weight_xy, weight_yy = v.spread(zero), v.spread(zero), v.spread(zero)
        reach_x = splats[splat + 5 * sample_stride]
        if reach_x >= zero:
            x, y, o = splats[splat], splats[splat + sample_stride], row_opacity[row]
            pxx, pxy = splats[splat + 2 * sample_stride], splats[splat + 3 * sample_stride]
            pyy, reach_y = splats[splat + 4 * sample_stride], splats[splat + 6 * sample_stride]
            left, right = covered(x - reach_x, x + reach_x, width_px)
            top, bottom = covered(y - reach_y, y + reach_y, height)
            box = path_tile_box[path]
            last_row = wp.where(left < right and top < bottom, (bottom + TILE - 1) // TILE, 0)
            for tile_row in range(top // TILE, last_row):
                pair0 = path_first_pair[path] + (tile_row - box[1]) * (box[2] - box[0]) - box[0]
                part_first = wp.max(top - tile_row * TILE, 0) // width
                part_end = (wp.min(bottom - tile_row * TILE, TILE) + width - 1) // width
                for column in range(left, right):
                    pair = pair0 + column // TILE
                    if pair_class[pair] == PARTIAL and pair_is_visible[pair] == 1:
                        dx = dtype(column) + half - x
                        slot = winding_index(pair_slot[pair], (column % TILE) * blocks)
                        for part in range(part_first, part_end):
                            dy = v.ramp_from(dtype(tile_row * TILE + part * width) + half - y)
                            alpha = gaussian(o, dx, dy, pxx, pxy, pyy)
                            w = alpha_adjoint(
                                alpha, adj_slot_coverage[slot + part], slot_transmittance[slot + part],
                                free_max, divided_max,
                            )  # fmt: skip
                            wy = v.mul(w, dy)
                            weight, weight_y = v.add(weight, w), v.add(weight_y, wy)
                            weight_x = v.fma(v.spread(dx), w, weight_x)
                            if wp.static(covariance):
                                weight_xx = v.fma(v.spread(dx * dx), w, weight_xx)
                                weight_xy = v.fma(v.spread(dx), wy, weight_xy)
                                weight_yy = v.fma(dy, wy, weight_yy)
        out = row * terms * sample_stride + sample
        splat_sums[out] = v.total(weight)
        splat_sums[out + sample_stride] = v.total(weight_x)
        splat_sums[out + 2 * sample_stride] = v.total(weight_y)
        if wp.static(covariance):
            splat_sums[out + 3 * sample_stride] = v.total(weight_xx)
            splat_sums[out + 4 * sample_stride] = v.total(weight_xy)
            splat_sums[out + 5 * sample_stride] = v.total(weight_yy)

    return bundle(cover_splats_adjoint)
