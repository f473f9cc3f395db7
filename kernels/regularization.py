"""Add the adjoints of the regularizers (equation 6: Xing, Bezier and opacity) to those of the render.

``warpvec/fit/regularization.py`` defines and explains the functions, in torch. A fit needs their gradients at every
step, and never their values. One thread handles a path: first the terms of its cubics, then its opacity.
"""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels.constants import EXTENT_MIN, LEG_MIN, PROJECTION_WEIGHT, TIP_COSINE, TIP_PARAMETER
from warpvec.kernels.lanes import Lanes, bundle, stage_module
from warpvec.kernels.making import made_once


def tip_weights() -> tuple[float, float, float]:
    """Return the weights of the legs AB, BC, CD in B(t) - A at t = TIP_PARAMETER.

    Each is the sum of the Bernstein weights of the points after the leg.
    """
    t = TIP_PARAMETER
    third = t**3
    second = third + 3 * (1 - t) * t**2
    return second + 3 * (1 - t) ** 2 * t, second, third


@made_once
def make_kernels(lanes: Lanes) -> SimpleNamespace:
    """Make ``add_regularizers``."""
    dtype, vec2, vec3 = lanes.dtype, lanes.vec2, lanes.vec3
    zero, one, two = wp.constant(dtype(0.0)), wp.constant(dtype(1.0)), wp.constant(dtype(2.0))
    leg_min_squared = wp.constant(dtype(LEG_MIN**2))
    extent_min = wp.constant(dtype(EXTENT_MIN))
    projection_weight = wp.constant(dtype(PROJECTION_WEIGHT))
    tip_cosine_squared = wp.constant(dtype(TIP_COSINE**2))
    reach1, reach2, reach3 = (wp.constant(dtype(weight)) for weight in tip_weights())
    matrix = wp.types.matrix(shape=(3, 2), dtype=dtype)
    module = stage_module("regularization", lanes)

    @wp.func
    def legs_of(points: wp.array(dtype=vec2), segment: int, segment_next: wp.array(dtype=int)):
        """Return the legs AB, BC, CD [3, 2] of a cubic in pixels."""
        a = points[3 * segment]
        b = points[3 * segment + 1]
        c = points[3 * segment + 2]
        d = points[3 * segment_next[segment]]
        ab, bc, cd = b - a, c - b, d - c
        return matrix(ab[0], ab[1], bc[0], bc[1], cd[0], cd[1])

    @wp.func
    def scaled(legs: matrix, pixel: vec2):
        """Return legs in units in which the canvas is [-1, 1] on both axes."""
        return matrix(
            legs[0, 0] * pixel[0], legs[0, 1] * pixel[1],
            legs[1, 0] * pixel[0], legs[1, 1] * pixel[1],
            legs[2, 0] * pixel[0], legs[2, 1] * pixel[1],
        )  # fmt: skip

    @wp.func
    def turned(v: vec2):
        """Return ``v`` turned by 90 degrees, clockwise on screen: d(cross(v, dv))/d(dv)."""
        return vec2(-v[1], v[0])

    @wp.func
    def cross(u: vec2, v: vec2):
        return u[0] * v[1] - u[1] * v[0]

    @wp.func
    def xing_adjoint(legs: matrix):
        """Return d(-turn sine)/d(legs) with the sine of the angle from AB to CD; zero where the loss is zero."""
        ab, bc, cd = legs[0], legs[1], legs[2]
        adj = matrix()
        ab_squared = wp.dot(ab, ab)
        cd_squared = wp.dot(cd, cd)
        if ab_squared > leg_min_squared and cd_squared > leg_min_squared:
            inv_ab = one / wp.sqrt(ab_squared)
            inv_cd = one / wp.sqrt(cd_squared)
            turn = wp.where(cross(ab, bc) >= zero, one, -one)
            sine = cross(ab, cd) * inv_ab * inv_cd
            if sine * turn < zero:
                # The sine grows by cosine d(angle), and moving a leg v by dv turns it by cross(v, dv) / |v|^2.
                cosine = wp.dot(ab, cd) * inv_ab * inv_cd * turn
                adj_ab = turned(ab) * (cosine * inv_ab * inv_ab)
                adj_cd = turned(cd) * (cosine * inv_cd * inv_cd)
                adj = matrix(adj_ab[0], adj_ab[1], zero, zero, -adj_cd[0], -adj_cd[1])
        return adj

    @wp.func
    def projection_adjoint(legs: matrix, weight: dtype):
        """Return d(weight times the squared overshoots)/d(legs) of inner points beyond the chord's ends."""
        chord = legs[0] + legs[1] + legs[2]
        along = vec3(wp.dot(legs[0], chord), wp.dot(legs[1], chord), wp.dot(legs[2], chord))
        b_before = wp.max(-along[0], zero)
        b_after = wp.max(-along[1] - along[2], zero)
        c_before = wp.max(-along[0] - along[1], zero)
        c_after = wp.max(-along[2], zero)
        scale = -two * weight
        adj = vec3(scale * (b_before + c_before), scale * (b_after + c_before), scale * (b_after + c_after))
        adj_chord = adj[0] * legs[0] + adj[1] * legs[1] + adj[2] * legs[2]
        return wp.outer(adj, chord) + wp.outer(vec3(one, one, one), adj_chord)

    @wp.func
    def needle_tip(before: matrix, after: matrix):
        """Return u + w of the anchor between two cubics if it is a needle tip, else zero."""
        ahead = reach1 * after[0] + reach2 * after[1] + reach3 * after[2]
        behind = -(reach3 * before[0] + reach2 * before[1] + reach1 * before[2])
        cosine = wp.max(wp.dot(ahead, behind), zero)
        tip = vec2()
        if cosine * cosine > wp.dot(ahead, ahead) * wp.dot(behind, behind) * tip_cosine_squared:
            tip = ahead + behind
        return tip

    @wp.func
    def beyond(value: dtype):
        """Return the sign of ``value`` if it lies outside [-1, 1], else zero."""
        return wp.where(value > one, one, wp.where(value < -one, -one, zero))

    @wp.func
    def inverse_extent_squared(
        points: wp.array(dtype=vec2), start: int, end: int, segment_next: wp.array(dtype=int), pixel: vec2
    ):
        """Return 1 / extent^2 of a path, the unit of the projection term, which has no gradient."""
        extent = dtype(0.0)
        for segment in range(start, end):
            legs = scaled(legs_of(points, segment, segment_next), pixel)
            chord = legs[0] + legs[1] + legs[2]
            extent += wp.max(wp.dot(chord, chord), wp.ddot(legs, legs))
        extent = extent / dtype(end - start) + extent_min * extent_min * wp.dot(pixel, pixel)
        return one / (extent * extent)

    @wp.kernel(module=module)
    def add_regularizers(
        first: int,
        points: wp.array(dtype=vec2),  # [3 R] px
        opacity: wp.array(dtype=dtype),  # [N]
        path_first_segment: wp.array(dtype=int),  # [N + 1]
        segment_next: wp.array(dtype=int),  # [R]
        segment_previous: wp.array(dtype=int),  # [R]
        counts: wp.array(dtype=int),  # [1] N, the paths that there are
        pixel: vec2,  # size of a pixel in units in which the canvas is [-1, 1]
        xing_weight: dtype,
        bezier_weight: dtype,
        opacity_weight: dtype,
        # in and out
        adj_points: wp.array(dtype=vec2),  # [3 R]
        adj_opacity: wp.array(dtype=dtype),  # [N]
    ):
        """Add the regularizers' adjoints of one path."""
        path = first + wp.tid()
        if path >= counts[0]:
            return
        per_path = one / dtype(counts[0])
        start, end = path_first_segment[path], path_first_segment[path + 1]
        per_cubic = per_path / dtype(end - start)
        share = projection_weight * per_path * inverse_extent_squared(points, start, end, segment_next, pixel)
        for segment in range(start, end):
            legs = legs_of(points, segment, segment_next)
            units = scaled(legs, pixel)
            tip0 = needle_tip(scaled(legs_of(points, segment_previous[segment], segment_next), pixel), units)
            tip1 = needle_tip(units, scaled(legs_of(points, segment_next[segment], segment_next), pixel))
            adj_tips = wp.outer(vec3(reach1, reach2, reach3), tip0) - wp.outer(vec3(reach3, reach2, reach1), tip1)
            adj_units = projection_adjoint(units, share) + two * per_cubic * adj_tips
            adj = xing_weight * per_cubic * xing_adjoint(legs) + bezier_weight * scaled(adj_units, pixel)
            anchor = points[3 * segment]
            adj_anchor = vec2(
                beyond(anchor[0] * pixel[0] - one) * pixel[0], beyond(anchor[1] * pixel[1] - one) * pixel[1]
            )
            point = 3 * segment
            last = 3 * segment_next[segment]
            weight = bezier_weight * per_cubic / two
            adj_points[point] = adj_points[point] + weight * adj_anchor - adj[0]
            adj_points[point + 1] = adj_points[point + 1] + adj[0] - adj[1]
            adj_points[point + 2] = adj_points[point + 2] + adj[1] - adj[2]
            adj_points[last] = adj_points[last] + adj[2]
        slope = wp.where(opacity[path] < one, -one, wp.where(opacity[path] > one, one, zero))
        adj_opacity[path] = adj_opacity[path] + opacity_weight * per_path * slope

    return bundle(add_regularizers)
