"""Adjoint of stage 1 of the splat renderer: sums over each Gaussian's pixels -> adj_points, adj_opacity.

Let w = dL/d(alpha) alpha and d = pixel - center. The sums of a Gaussian are those of w, w dx, w dy and, for the
covariance, w dx^2, w dx dy, w dy^2. With P the inverse covariance, the adjoint of the center is P (sum w d), and the
adjoints of P's entries xx, xy, yy are -1/2, -1 and -1/2 times the last three sums. Rows that are attached to the
control points pass their adjoints on to the two sides, and the sides to the points.
"""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels import splatting
from warpvec.kernels.constants import (
    BOUNDARY_SIGMA_X_MIN,
    BOUNDARY_SIGMA_Y_MAX,
    BOUNDARY_SIGMA_Y_MIN,
    COORDINATE_MAX,
    LENGTH_MIN,
    SIGMA_MIN_INSIDE,
    SIGMA_PER_SPACING,
    THIN_RATIO,
)
from warpvec.kernels.lanes import Lanes, bundle, stage_module
from warpvec.kernels.making import made_once
from warpvec.kernels.splatting import KINDS, PLANES

CENTER_TERMS = 3
COVARIANCE_TERMS = 6
"""Number of sums of a Gaussian, without and with those of its covariance."""

SIDE_TERMS = 4 * KINDS + 1
"""Number of sums of a sample over all rows: for each kind of basis the adjoints of A x, A y, B x, B y; last, the sum of
w."""


@made_once
def make_kernels(lanes: Lanes, covariance: bool) -> SimpleNamespace:
    """Return ``center_adjoint``, ``gather_points_adjoint`` and ``gather_opacity_adjoint``.

    With ``covariance`` the covariances of the Gaussians are attached to the control points too, and
    ``covariance_adjoint`` is returned as well.
    """
    dtype, vector = lanes.dtype, lanes.vector
    v = lanes.functions
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
        weight = v.spread(zero)
        adj_ax, adj_ay, adj_bx, adj_by = v.spread(zero), v.spread(zero), v.spread(zero), v.spread(zero)
        for row in range(row_count):
            plane = (path * row_count + row) * planes * block_count + block
            sums = (path * row_count + row) * terms * block_count + block
            weight = v.add(weight, splat_sums[sums])
            if row == 0 or row == row_count - 1 or interior == 1:
                w = v.spread(row_weight[row])
                mx, my = splat_sums[sums + block_count], splat_sums[sums + 2 * block_count]
                pxy = splats[plane + 3 * block_count]
                adj_x = v.fma(splats[plane + 2 * block_count], mx, v.mul(pxy, my))
                adj_y = v.fma(pxy, mx, v.mul(splats[plane + 4 * block_count], my))
                adj_bx, adj_by = v.fma(w, adj_x, adj_bx), v.fma(w, adj_y, adj_by)
                adj_ax, adj_ay = v.fnma(w, adj_x, v.add(adj_ax, adj_x)), v.fnma(w, adj_y, v.add(adj_ay, adj_y))
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
        x, y = v.spread(zero), v.spread(zero)
        for part in range(2 * kinds):
            for block in range(block_count):
                weight = basis[(part * point_count + point % point_count) * block_count + block]
                sums = (path * side_terms + 2 * part) * block_count + block
                x = v.fma(weight, side_sums[sums], x)
                y = v.fma(weight, side_sums[sums + block_count], y)
        adj_x, adj_y = v.total(x), v.total(y)
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
        weight = v.spread(zero)
        for block in range(block_count):
            weight = v.add(weight, side_sums[((path + 1) * side_terms - 1) * block_count + block])
        value = v.total(weight)
        adj_opacity[path] = wp.where(opacity[path] > zero, value / wp.max(opacity[path], tiny), zero)

    more = [_covariance_adjoint(lanes, module)] if covariance else []
    return bundle(center_adjoint, gather_points_adjoint, gather_opacity_adjoint, *more)


def _covariance_adjoint(lanes: Lanes, module: wp.Module) -> wp.Kernel:
    dtype, vector = lanes.dtype, lanes.vector
    v = lanes.functions
    sides = splatting.make_functions(lanes)
    zero, half, one, two = (wp.constant(dtype(value)) for value in (0.0, 0.5, 1.0, 2.0))
    tiny, farthest = wp.constant(dtype(LENGTH_MIN)), wp.constant(dtype(COORDINATE_MAX))
    across = wp.constant(dtype(SIGMA_PER_SPACING))
    floor_x, floor_inside = wp.constant(dtype(BOUNDARY_SIGMA_X_MIN)), wp.constant(dtype(SIGMA_MIN_INSIDE))
    floor_y, ceiling_y = wp.constant(dtype(BOUNDARY_SIGMA_Y_MIN)), wp.constant(dtype(BOUNDARY_SIGMA_Y_MAX))
    terms, side_terms = wp.constant(COVARIANCE_TERMS), wp.constant(SIDE_TERMS)
    ratio = wp.constant(dtype(THIN_RATIO))

    @wp.func
    def inverse_variance_slope(sigma: vector, inverse: vector, low: dtype, high: dtype, raw: vector):
        """Return d(1 / sigma^2) / d(raw sigma): -2 / sigma^3, or 0 where sigma is clamped."""
        free = v.where_less(
            v.spread(low), raw, v.where_less(raw, v.spread(high), v.spread(one), v.spread(zero)), v.spread(zero)
        )
        return v.mul(free, v.mul(v.spread(-two), v.quotient(inverse, sigma)))

    @wp.func
    def add_to(sums: wp.array(dtype=vector), index: int, value: vector):
        sums[index] = v.add(sums[index], value)

    @wp.func
    def add_blended(sums: wp.array(dtype=vector), index: int, stride: int, w: dtype, x: vector, y: vector):
        """Add the adjoints x, y of (1 - w) A + w B to those of A x, A y, B x, B y."""
        add_to(sums, index, v.mul(v.spread(one - w), x))
        add_to(sums, index + stride, v.mul(v.spread(one - w), y))
        add_to(sums, index + 2 * stride, v.mul(v.spread(w), x))
        add_to(sums, index + 3 * stride, v.mul(v.spread(w), y))

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
        gap_x = v.sub(
            sides.combine(points, path, point_count, 0, basis, 1, block, block_count),
            sides.combine(points, path, point_count, 0, basis, 0, block, block_count),
        )
        gap_y = v.sub(
            sides.combine(points, path, point_count, 1, basis, 1, block, block_count),
            sides.combine(points, path, point_count, 1, basis, 0, block, block_count),
        )
        a_step_x = sides.combine(points, path, point_count, 0, basis, 2, block, block_count)
        a_step_y = sides.combine(points, path, point_count, 1, basis, 2, block, block_count)
        b_step_x = sides.combine(points, path, point_count, 0, basis, 3, block, block_count)
        b_step_y = sides.combine(points, path, point_count, 1, basis, 3, block, block_count)
        a_tangent_x = sides.combine(points, path, point_count, 0, basis, 4, block, block_count)
        a_tangent_y = sides.combine(points, path, point_count, 1, basis, 4, block, block_count)
        b_tangent_x = sides.combine(points, path, point_count, 0, basis, 5, block, block_count)
        b_tangent_y = sides.combine(points, path, point_count, 1, basis, 5, block, block_count)
        gap = sides.norm(gap_x, gap_y)
        factor = spacing_factor[block]
        adj_gap = v.spread(zero)
        out = path * side_terms * block_count + block
        for term in range(4, side_terms - 1):
            side_sums[out + term * block_count] = v.spread(zero)
        for row in range(row_count):
            is_boundary = row == 0 or row == row_count - 1
            if is_boundary or interior == 1:
                w = row_weight[row]
                sums = (path * row_count + row) * terms * block_count + block
                adj_pxx = v.mul(v.spread(-half), splat_sums[sums + 3 * block_count])
                adj_pxy = v.mul(v.spread(-one), splat_sums[sums + 4 * block_count])
                adj_pyy = v.mul(v.spread(-half), splat_sums[sums + 5 * block_count])
                step_x, step_y = sides.blend(a_step_x, b_step_x, w), sides.blend(a_step_y, b_step_y, w)
                distance = sides.norm(step_x, step_y)
                across_step = v.spread(across * row_step[row])
                raw_x, raw_y = v.mul(factor, distance), v.mul(across_step, gap)
                sx, sy = sides.bound_x(raw_x, raw_y, is_boundary), sides.bound_y(raw_x, raw_y, is_boundary)
                tx, ty = sides.blend(a_tangent_x, b_tangent_x, w), sides.blend(a_tangent_y, b_tangent_y, w)
                inverse = sides.inverse_norm(tx, ty)
                ux, uy = sides.direction(tx, ty, inverse)
                px, py = v.quotient(v.spread(one), v.mul(sx, sx)), v.quotient(v.spread(one), v.mul(sy, sy))
                uxx, uxy, uyy = v.mul(ux, ux), v.mul(ux, uy), v.mul(uy, uy)
                adj_px = v.fma(adj_pxx, uxx, v.fma(adj_pxy, uxy, v.mul(adj_pyy, uyy)))
                adj_py = v.fma(adj_pxx, uyy, v.fnma(adj_pxy, uxy, v.mul(adj_pyy, uxx)))
                low_x = wp.where(is_boundary, floor_x, floor_inside)
                low_y = wp.where(is_boundary, floor_y, floor_inside)
                high_y = wp.where(is_boundary, ceiling_y, farthest)
                free_x, free_y = v.minimum(raw_x, v.spread(farthest)), v.minimum(raw_y, v.spread(farthest))
                if not is_boundary:
                    free_x = v.minimum(raw_x, sides.most(raw_y, raw_y))
                    free_y = v.minimum(raw_y, sides.most(raw_y, raw_x))
                adj_raw_x = v.mul(adj_px, inverse_variance_slope(sx, px, low_x, farthest, free_x))
                adj_raw_y = v.mul(adj_py, inverse_variance_slope(sy, py, low_y, high_y, free_y))
                # A deviation that the ratio bounds follows the other one.
                moved_x = v.where_less(free_x, raw_x, adj_raw_x, v.spread(zero))
                moved_y = v.where_less(free_y, raw_y, adj_raw_y, v.spread(zero))
                adj_raw_x = v.fma(v.spread(ratio), moved_y, v.sub(adj_raw_x, moved_x))
                adj_raw_y = v.fma(v.spread(ratio), moved_x, v.sub(adj_raw_y, moved_y))
                adj_gap = v.fma(across_step, adj_raw_y, adj_gap)
                along = v.quotient(v.mul(factor, adj_raw_x), v.maximum(distance, v.spread(tiny)))
                twist = v.mul(adj_pxy, v.sub(px, py))
                adj_ux = v.fma(v.mul(v.spread(two), ux), v.fma(adj_pxx, px, v.mul(adj_pyy, py)), v.mul(twist, uy))
                adj_uy = v.fma(v.mul(v.spread(two), uy), v.fma(adj_pxx, py, v.mul(adj_pyy, px)), v.mul(twist, ux))
                radial = v.fma(adj_ux, ux, v.mul(adj_uy, uy))
                add_blended(
                    side_sums, out + 4 * block_count, block_count, w, v.mul(along, step_x), v.mul(along, step_y)
                )
                adj_tx, adj_ty = v.mul(inverse, v.fnma(radial, ux, adj_ux)), v.mul(inverse, v.fnma(radial, uy, adj_uy))
                add_blended(side_sums, out + 8 * block_count, block_count, w, adj_tx, adj_ty)
        pull = v.quotient(adj_gap, v.maximum(gap, v.spread(tiny)))
        add_to(side_sums, out, v.mul(pull, v.sub(v.spread(zero), gap_x)))
        add_to(side_sums, out + block_count, v.mul(pull, v.sub(v.spread(zero), gap_y)))
        add_to(side_sums, out + 2 * block_count, v.mul(pull, gap_x))
        add_to(side_sums, out + 3 * block_count, v.mul(pull, gap_y))

    return covariance_adjoint
