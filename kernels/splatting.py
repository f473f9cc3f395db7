"""Stage 1 of the splat renderer: control points -> Gaussians along both sides of a path and on lines between them.

Row r of a path blends its two sides: X = (1 - w_r) A(u_k) + w_r B(u_k). The first and the last row are the sides
themselves. The sides, their spacing and their tangents are linear in the control points; the host computes the weights
(the *basis*) for any degree. The covariance is R diag(sx^2, sy^2) R^T. R rotates the x axis to the row's tangent; sx
and sy are proportional to the distances to the next sample and the next row (Bezier Splatting, section 3).

The adjoints of the positions need no quadrature weights: the size of a Gaussian is proportional to its spacing, so its
adjoint is the integral of the gradient over its own cell, up to a constant. Their sum is the area term of equation (4).
"""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels.constants import (
    BOUNDARY_SIGMA_X_MIN,
    BOUNDARY_SIGMA_Y_MAX,
    BOUNDARY_SIGMA_Y_MIN,
    COORDINATE_MAX,
    SIGMA_MIN_INSIDE,
    SIGMA_PER_SPACING,
    SPLAT_ALPHA_MIN,
    TANGENT_MIN,
    THIN_RATIO,
    THIN_SIGMA,
)
from warpvec.kernels.lanes import Lanes, bundle, stage_module
from warpvec.kernels.making import made_once

PLANES = 7
"""Number of values of a Gaussian: center x, y; inverse covariance xx, xy, yy; half the size of its visible box in x, y
(negative: invisible)."""

KINDS = 3
"""Number of kinds of basis: position, step to the next sample, tangent. Each has a part for either side."""


@made_once
def make_functions(lanes: Lanes) -> SimpleNamespace:
    """Return the functions that forward and adjoint share."""
    dtype, vector = lanes.dtype, lanes.vector
    v = lanes.functions
    zero, one = wp.constant(dtype(0.0)), wp.constant(dtype(1.0))
    tangent_min_squared = wp.constant(dtype(TANGENT_MIN**2))
    floor_x, floor_inside = wp.constant(dtype(BOUNDARY_SIGMA_X_MIN)), wp.constant(dtype(SIGMA_MIN_INSIDE))
    thin, ratio = wp.constant(dtype(THIN_SIGMA)), wp.constant(dtype(THIN_RATIO))
    far = wp.constant(dtype(COORDINATE_MAX))
    floor_y, ceiling_y = wp.constant(dtype(BOUNDARY_SIGMA_Y_MIN)), wp.constant(dtype(BOUNDARY_SIGMA_Y_MAX))

    @wp.func
    def combine(
        points: wp.array2d(dtype=dtype),
        path: int,
        point_count: int,
        axis: int,
        basis: wp.array(dtype=vector),
        part: int,
        block: int,
        block_count: int,
    ):
        """Return one coordinate of a linear combination of the control points, for the samples of a block."""
        value = v.spread(zero)
        for j in range(point_count):
            weight = basis[(part * point_count + j) * block_count + block]
            value = v.fma(weight, v.spread(points[path * point_count + j, axis]), value)
        return value

    @wp.func
    def blend(a: vector, b: vector, w: dtype):
        """Return (1 - w) a + w b."""
        return v.fma(v.spread(w), v.sub(b, a), a)

    @wp.func
    def norm(x: vector, y: vector):
        return v.root(v.fma(x, x, v.mul(y, y)))

    @wp.func
    def inverse_norm(x: vector, y: vector):
        """Return 1 / length, or 0 for a vector without a direction."""
        squared = v.fma(x, x, v.mul(y, y))
        inverse = v.quotient(v.spread(one), v.root(v.maximum(squared, v.spread(tangent_min_squared))))
        return v.where_less(squared, v.spread(tangent_min_squared), v.spread(zero), inverse)

    @wp.func
    def direction(x: vector, y: vector, inverse: vector):
        """Return the unit vector of (x, y), given ``inverse`` = 1 / length; (1, 0) where ``inverse`` is 0."""
        return v.where_less(v.spread(zero), inverse, v.mul(x, inverse), v.spread(one)), v.mul(y, inverse)

    @wp.func
    def most(raw_y: vector, other: vector):
        """Return the largest deviation of an interior sample along one axis, given the ``other`` axis' own."""
        return v.where_less(raw_y, v.spread(thin), v.mul(v.spread(ratio), other), v.spread(far))

    @wp.func
    def bound_x(raw_x: vector, raw_y: vector, is_boundary: bool):
        """Bound the standard deviation ``raw_x`` along the curve, in pixels; ``raw_y`` is that across."""
        if is_boundary:
            return v.maximum(raw_x, v.spread(floor_x))
        return v.maximum(v.minimum(raw_x, most(raw_y, raw_y)), v.spread(floor_inside))

    @wp.func
    def bound_y(raw_x: vector, raw_y: vector, is_boundary: bool):
        """Bound the standard deviation ``raw_y`` across the curve, in pixels."""
        if is_boundary:
            return v.minimum(v.maximum(raw_y, v.spread(floor_y)), v.spread(ceiling_y))
        return v.maximum(v.minimum(raw_y, most(raw_y, raw_x)), v.spread(floor_inside))

    return bundle(combine, blend, norm, inverse_norm, direction, most, bound_x, bound_y)


@made_once
def make_kernels(lanes: Lanes) -> SimpleNamespace:
    """Return ``place_splats``."""
    dtype, vector = lanes.dtype, lanes.vector
    v = lanes.functions
    sides = make_functions(lanes)
    zero, one, two = (wp.constant(dtype(value)) for value in (0.0, 1.0, 2.0))
    across = wp.constant(dtype(SIGMA_PER_SPACING))
    alpha_min, farthest = wp.constant(dtype(SPLAT_ALPHA_MIN)), wp.constant(dtype(COORDINATE_MAX))
    width, planes = wp.constant(lanes.width), wp.constant(PLANES)
    module = stage_module("splatting", lanes)

    @wp.func
    def visible_reach(x: vector, y: vector, reach: vector, sample: vector, sample_count: int):
        """Return ``reach``, or -1 for a Gaussian that is not finite, too far out, or beyond the last sample."""
        farness = v.add(v.add(v.maximum(x, v.sub(v.spread(zero), x)), v.maximum(y, v.sub(v.spread(zero), y))), reach)
        # A comparison with a NaN is false.
        kept = v.where_less(farness, v.spread(farthest), reach, v.spread(-one))
        return v.where_less(sample, v.spread(dtype(sample_count)), kept, v.spread(-one))

    @wp.kernel(module=module)
    def place_splats(
        first: int,
        points: wp.array2d(dtype=dtype),  # [N P, 2] px
        point_count: int,  # P
        row_opacity: wp.array(dtype=dtype),  # [N rows]
        basis: wp.array(dtype=vector),  # [KINDS, 2 sides, P, samples]
        spacing_factor: wp.array(dtype=vector),  # [samples] sx divided by the distance to the next sample
        row_weight: wp.array(dtype=dtype),  # [rows] w_r
        row_step: wp.array(dtype=dtype),  # [rows] difference of w to the next row
        row_count: int,
        sample_count: int,
        block_count: int,
        # outputs
        splats: wp.array(dtype=vector),  # [N, rows, PLANES, samples]
    ):
        """Place the Gaussians of a block of neighbouring samples of one path, on all of its rows."""
        item = first + wp.tid()
        path = item // block_count
        block = item % block_count
        ax = sides.combine(points, path, point_count, 0, basis, 0, block, block_count)
        ay = sides.combine(points, path, point_count, 1, basis, 0, block, block_count)
        bx = sides.combine(points, path, point_count, 0, basis, 1, block, block_count)
        by = sides.combine(points, path, point_count, 1, basis, 1, block, block_count)
        asx = sides.combine(points, path, point_count, 0, basis, 2, block, block_count)
        asy = sides.combine(points, path, point_count, 1, basis, 2, block, block_count)
        bsx = sides.combine(points, path, point_count, 0, basis, 3, block, block_count)
        bsy = sides.combine(points, path, point_count, 1, basis, 3, block, block_count)
        atx = sides.combine(points, path, point_count, 0, basis, 4, block, block_count)
        aty = sides.combine(points, path, point_count, 1, basis, 4, block, block_count)
        btx = sides.combine(points, path, point_count, 0, basis, 5, block, block_count)
        bty = sides.combine(points, path, point_count, 1, basis, 5, block, block_count)
        gap = v.mul(v.spread(across), sides.norm(v.sub(bx, ax), v.sub(by, ay)))
        sample = v.ramp_from(dtype(block * width))
        for row in range(row_count):
            w = row_weight[row]
            is_boundary = row == 0 or row == row_count - 1
            x, y = sides.blend(ax, bx, w), sides.blend(ay, by, w)
            distance = sides.norm(sides.blend(asx, bsx, w), sides.blend(asy, bsy, w))
            raw_x, raw_y = v.mul(spacing_factor[block], distance), v.mul(v.spread(row_step[row]), gap)
            sx, sy = sides.bound_x(raw_x, raw_y, is_boundary), sides.bound_y(raw_x, raw_y, is_boundary)
            tx, ty = sides.blend(atx, btx, w), sides.blend(aty, bty, w)
            ux, uy = sides.direction(tx, ty, sides.inverse_norm(tx, ty))
            vx, vy = v.mul(sx, sx), v.mul(sy, sy)
            # The Gaussian is dropped where q > reach2.
            reach2 = two * wp.log(wp.max(row_opacity[path * row_count + row] / alpha_min, one))
            px, py = v.quotient(v.spread(one), vx), v.quotient(v.spread(one), vy)
            uxx, uxy, uyy = v.mul(ux, ux), v.mul(ux, uy), v.mul(uy, uy)
            reach_x = v.root(v.mul(v.spread(reach2), v.fma(uxx, vx, v.mul(uyy, vy))))
            reach_y = v.root(v.mul(v.spread(reach2), v.fma(uyy, vx, v.mul(uxx, vy))))
            plane = (path * row_count + row) * planes * block_count + block
            splats[plane] = x
            splats[plane + block_count] = y
            splats[plane + 2 * block_count] = v.fma(uxx, px, v.mul(uyy, py))
            splats[plane + 3 * block_count] = v.mul(uxy, v.sub(px, py))
            splats[plane + 4 * block_count] = v.fma(uyy, px, v.mul(uxx, py))
            splats[plane + 5 * block_count] = visible_reach(x, y, reach_x, sample, sample_count)
            splats[plane + 6 * block_count] = visible_reach(x, y, reach_y, sample, sample_count)

    return bundle(place_splats)
