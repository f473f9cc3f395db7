"""Adjoint of stage 1 of the splat renderer: sums over each Gaussian's pixels -> adj_points, adj_opacity.

Let w = dL/d(alpha) alpha and d = pixel - center. The sums of a Gaussian are those of w, w dx, w dy and, for the
covariance, w dx^2, w dx dy, w dy^2. With P the inverse covariance, the adjoint of the center is P (sum w d), and the
adjoints of P's entries xx, xy, yy are -1/2, -1 and -1/2 times the last three sums. Rows that are attached to the
control points pass their adjoints on to the two sides, and the sides to the points.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warpvec.kernels import splatting
from warpvec.kernels.constants import (
    BOUNDARY_SIGMA_X_MIN,
    BOUNDARY_SIGMA_Y_MAX,
    BOUNDARY_SIGMA_Y_MIN,
    COORDINATE_MAX,
    INTERIOR_SIGMA_MIN,
    LENGTH_MIN,
    SIGMA_PER_SPACING,
)
from warpvec.kernels.lanes import Lanes, stage_module
from warpvec.kernels.splatting import KINDS, PLANES

CENTER_TERMS = 3
COVARIANCE_TERMS = 6
"""Number of sums of a Gaussian, without and with those of its covariance."""

SIDE_TERMS = 4 * KINDS + 1
"""Number of sums of a sample over all rows: for each kind of basis the adjoints of A x, A y, B x, B y; last, the sum of
w."""


@cache
def make_kernels(lanes: Lanes, covariance: bool) -> SimpleNamespace:
    """Return ``center_adjoint``, ``gather_points_adjoint`` and ``gather_opacity_adjoint``.

    With ``covariance`` the covariances of the Gaussians are attached to the control points too, and
    ``covariance_adjoint`` is returned as well.
    """
    dtype, vector = lanes.dtype, lanes.vector
    add, mul, fma, fnma, spread, total = lanes.add, lanes.mul, lanes.fma, lanes.fnma, lanes.spread, lanes.total
    zero, tiny = wp.constant(dtype(0.0)), wp.constant(dtype(LENGTH_MIN))
    planes, terms = wp.constant(PLANES), wp.constant(COVARIANCE_TERMS if covariance else CENTER_TERMS)
    kinds, side_terms = wp.constant(KINDS if covariance else 1), wp.constant(SIDE_TERMS)
    module = stage_module("splatting_adjoint" + "_covariance" * covariance, lanes)

    @wp.kernel(module=module)
    def center_adjoint(
        first: int,
        row_weight: wp.array(dtype=dtype),  # [rows]
        row_count: int,
        block_count: int,
        interior: int,  # 1: interior rows are attached to the points
        splats: wp.array(dtype=vector),  # [N, rows, PLANES, samples]
        splat_sums: wp.array(dtype=vector),  # [N, rows, terms, samples]
        # outputs
        side_sums: wp.array(dtype=vector),  # [N, SIDE_TERMS, samples], the positions' part and the sum of w
    ):
        """Sum the adjoints of the sides' positions over all rows of one path, at a block of neighbouring samples."""
        item = first + wp.tid()
        path = item // block_count
        block = item % block_count
        weight = spread(zero)
        adj_ax, adj_ay, adj_bx, adj_by = spread(zero), spread(zero), spread(zero), spread(zero)
        for row in range(row_count):
            plane = (path * row_count + row) * planes * block_count + block
            sums = (path * row_count + row) * terms * block_count + block
            weight = add(weight, splat_sums[sums])
            if row == 0 or row == row_count - 1 or interior == 1:
                w = spread(row_weight[row])
                mx, my = splat_sums[sums + block_count], splat_sums[sums + 2 * block_count]
                pxy = splats[plane + 3 * block_count]
                adj_x = fma(splats[plane + 2 * block_count], mx, mul(pxy, my))
                adj_y = fma(pxy, mx, mul(splats[plane + 4 * block_count], my))
                adj_bx, adj_by = fma(w, adj_x, adj_bx), fma(w, adj_y, adj_by)
                adj_ax, adj_ay = fnma(w, adj_x, add(adj_ax, adj_x)), fnma(w, adj_y, add(adj_ay, adj_y))
        out = path * side_terms * block_count + block
        side_sums[out] = adj_ax
        side_sums[out + block_count] = adj_ay
        side_sums[out + 2 * block_count] = adj_bx
        side_sums[out + 3 * block_count] = adj_by
        side_sums[out + (side_terms - 1) * block_count] = weight

    @wp.kernel(module=module)
    def gather_points_adjoint(
        first: int,
        basis: wp.array(dtype=vector),  # [KINDS, 2 sides, P, samples]
        point_count: int,  # P
        block_count: int,
        side_sums: wp.array(dtype=vector),  # [N, SIDE_TERMS, samples]
        # outputs
        adj_points: wp.array2d(dtype=dtype),  # [N P, 2]
    ):
        """Compute the adjoint of one control point; zero where the path is not finite and therefore not drawn."""
        point = first + wp.tid()
        path = point // point_count
        x, y = spread(zero), spread(zero)
        for part in range(2 * kinds):
            for block in range(block_count):
                weight = basis[(part * point_count + point % point_count) * block_count + block]
                sums = (path * side_terms + 2 * part) * block_count + block
                x = fma(weight, side_sums[sums], x)
                y = fma(weight, side_sums[sums + block_count], y)
        adj_x, adj_y = total(x), total(y)
        adj_points[point, 0] = wp.where(wp.isfinite(adj_x), adj_x, zero)
        adj_points[point, 1] = wp.where(wp.isfinite(adj_y), adj_y, zero)

    @wp.kernel(module=module)
    def gather_opacity_adjoint(
        first: int,
        opacity: wp.array(dtype=dtype),  # [N]
        block_count: int,
        side_sums: wp.array(dtype=vector),  # [N, SIDE_TERMS, samples]
        # outputs
        adj_opacity: wp.array(dtype=dtype),  # [N]
    ):
        """Compute the adjoint of a path's opacity, to which the alphas of its Gaussians are proportional."""
        path = first + wp.tid()
        weight = spread(zero)
        for block in range(block_count):
            weight = add(weight, side_sums[((path + 1) * side_terms - 1) * block_count + block])
        value = total(weight)
        adj_opacity[path] = wp.where(opacity[path] > zero, value / wp.max(opacity[path], tiny), zero)

    kernels = {
        "center_adjoint": center_adjoint,
        "gather_points_adjoint": gather_points_adjoint,
        "gather_opacity_adjoint": gather_opacity_adjoint,
    }
    if covariance:
        kernels["covariance_adjoint"] = _covariance_adjoint(lanes, module)
    return SimpleNamespace(**kernels)


def _covariance_adjoint(lanes: Lanes, module: wp.Module) -> wp.Kernel:
    dtype, vector = lanes.dtype, lanes.vector
    add, mul, fma, sub, spread = lanes.add, lanes.mul, lanes.fma, lanes.sub, lanes.spread
    fnma, quotient, maximum, where_less = lanes.fnma, lanes.quotient, lanes.maximum, lanes.where_less
    functions = splatting.make_functions(lanes)
    combine, blend, norm = functions.combine, functions.blend, functions.norm
    inverse_norm, direction = functions.inverse_norm, functions.direction
    clamp_x, clamp_y = functions.clamp_x, functions.clamp_y
    zero, half, one, two = (wp.constant(dtype(value)) for value in (0.0, 0.5, 1.0, 2.0))
    tiny, farthest = wp.constant(dtype(LENGTH_MIN)), wp.constant(dtype(COORDINATE_MAX))
    across = wp.constant(dtype(SIGMA_PER_SPACING))
    floor_x, floor_inside = wp.constant(dtype(BOUNDARY_SIGMA_X_MIN)), wp.constant(dtype(INTERIOR_SIGMA_MIN))
    floor_y, ceiling_y = wp.constant(dtype(BOUNDARY_SIGMA_Y_MIN)), wp.constant(dtype(BOUNDARY_SIGMA_Y_MAX))
    terms, side_terms = wp.constant(COVARIANCE_TERMS), wp.constant(SIDE_TERMS)

    @wp.func
    def inverse_variance_slope(sigma: vector, inverse: vector, low: dtype, high: dtype, raw: vector):
        """Return d(1 / sigma^2) / d(raw sigma): -2 / sigma^3, or 0 where sigma is clamped."""
        free = where_less(spread(low), raw, where_less(raw, spread(high), spread(one), spread(zero)), spread(zero))
        return mul(free, mul(spread(-two), quotient(inverse, sigma)))

    @wp.func
    def add_to(sums: wp.array(dtype=vector), index: int, value: vector):
        sums[index] = add(sums[index], value)

    @wp.func
    def add_blended(sums: wp.array(dtype=vector), index: int, stride: int, w: dtype, x: vector, y: vector):
        """Add the adjoints x, y of (1 - w) A + w B to those of A x, A y, B x, B y."""
        add_to(sums, index, mul(spread(one - w), x))
        add_to(sums, index + stride, mul(spread(one - w), y))
        add_to(sums, index + 2 * stride, mul(spread(w), x))
        add_to(sums, index + 3 * stride, mul(spread(w), y))

    @wp.kernel(module=module)
    def covariance_adjoint(
        first: int,
        points: wp.array2d(dtype=dtype),  # [N P, 2] px
        point_count: int,  # P
        basis: wp.array(dtype=vector),  # [KINDS, 2 sides, P, samples]
        spacing_factor: wp.array(dtype=vector),  # [samples]
        row_weight: wp.array(dtype=dtype),  # [rows]
        row_step: wp.array(dtype=dtype),  # [rows]
        row_count: int,
        block_count: int,
        interior: int,  # 1: interior rows are attached to the points
        splat_sums: wp.array(dtype=vector),  # [N, rows, COVARIANCE_TERMS, samples]
        # outputs
        side_sums: wp.array(dtype=vector),  # [N, SIDE_TERMS, samples]: writes steps and tangents, adds to positions
    ):
        """Add what the covariances contribute to the adjoints of the sides, at a block of neighbouring samples."""
        item = first + wp.tid()
        path = item // block_count
        block = item % block_count
        gap_x = sub(
            combine(points, path, point_count, 0, basis, 1, block, block_count),
            combine(points, path, point_count, 0, basis, 0, block, block_count),
        )
        gap_y = sub(
            combine(points, path, point_count, 1, basis, 1, block, block_count),
            combine(points, path, point_count, 1, basis, 0, block, block_count),
        )
        a_step_x = combine(points, path, point_count, 0, basis, 2, block, block_count)
        a_step_y = combine(points, path, point_count, 1, basis, 2, block, block_count)
        b_step_x = combine(points, path, point_count, 0, basis, 3, block, block_count)
        b_step_y = combine(points, path, point_count, 1, basis, 3, block, block_count)
        a_tangent_x = combine(points, path, point_count, 0, basis, 4, block, block_count)
        a_tangent_y = combine(points, path, point_count, 1, basis, 4, block, block_count)
        b_tangent_x = combine(points, path, point_count, 0, basis, 5, block, block_count)
        b_tangent_y = combine(points, path, point_count, 1, basis, 5, block, block_count)
        gap = norm(gap_x, gap_y)
        factor = spacing_factor[block]
        adj_gap = spread(zero)
        out = path * side_terms * block_count + block
        for term in range(4, side_terms - 1):
            side_sums[out + term * block_count] = spread(zero)
        for row in range(row_count):
            is_boundary = row == 0 or row == row_count - 1
            if is_boundary or interior == 1:
                w = row_weight[row]
                sums = (path * row_count + row) * terms * block_count + block
                adj_pxx = mul(spread(-half), splat_sums[sums + 3 * block_count])
                adj_pxy = mul(spread(-one), splat_sums[sums + 4 * block_count])
                adj_pyy = mul(spread(-half), splat_sums[sums + 5 * block_count])
                step_x, step_y = blend(a_step_x, b_step_x, w), blend(a_step_y, b_step_y, w)
                distance = norm(step_x, step_y)
                across_step = spread(across * row_step[row])
                raw_x, raw_y = mul(factor, distance), mul(across_step, gap)
                sx, sy = clamp_x(raw_x, is_boundary), clamp_y(raw_y, is_boundary)
                tx, ty = blend(a_tangent_x, b_tangent_x, w), blend(a_tangent_y, b_tangent_y, w)
                inverse = inverse_norm(tx, ty)
                ux, uy = direction(tx, ty, inverse)
                px, py = quotient(spread(one), mul(sx, sx)), quotient(spread(one), mul(sy, sy))
                uxx, uxy, uyy = mul(ux, ux), mul(ux, uy), mul(uy, uy)
                adj_px = fma(adj_pxx, uxx, fma(adj_pxy, uxy, mul(adj_pyy, uyy)))
                adj_py = fma(adj_pxx, uyy, fnma(adj_pxy, uxy, mul(adj_pyy, uxx)))
                low_x = wp.where(is_boundary, floor_x, floor_inside)
                low_y = wp.where(is_boundary, floor_y, floor_inside)
                high_y = wp.where(is_boundary, ceiling_y, farthest)
                adj_raw_x = mul(adj_px, inverse_variance_slope(sx, px, low_x, farthest, raw_x))
                adj_raw_y = mul(adj_py, inverse_variance_slope(sy, py, low_y, high_y, raw_y))
                adj_gap = fma(across_step, adj_raw_y, adj_gap)
                along = quotient(mul(factor, adj_raw_x), maximum(distance, spread(tiny)))
                twist = mul(adj_pxy, sub(px, py))
                adj_ux = fma(mul(spread(two), ux), fma(adj_pxx, px, mul(adj_pyy, py)), mul(twist, uy))
                adj_uy = fma(mul(spread(two), uy), fma(adj_pxx, py, mul(adj_pyy, px)), mul(twist, ux))
                radial = fma(adj_ux, ux, mul(adj_uy, uy))
                add_blended(side_sums, out + 4 * block_count, block_count, w, mul(along, step_x), mul(along, step_y))
                adj_tx, adj_ty = mul(inverse, fnma(radial, ux, adj_ux)), mul(inverse, fnma(radial, uy, adj_uy))
                add_blended(side_sums, out + 8 * block_count, block_count, w, adj_tx, adj_ty)
        pull = quotient(adj_gap, maximum(gap, spread(tiny)))
        add_to(side_sums, out, mul(pull, sub(spread(zero), gap_x)))
        add_to(side_sums, out + block_count, mul(pull, sub(spread(zero), gap_y)))
        add_to(side_sums, out + 2 * block_count, mul(pull, gap_x))
        add_to(side_sums, out + 3 * block_count, mul(pull, gap_y))

    return covariance_adjoint
