"""Add the adjoints of the regularizers of paths of two sides to those of the render.

``warpvec/paper/side_terms.py`` defines and explains the functions, in torch. This is without the projection term. One
thread handles a path.
"""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels.constants import TIP_COSINE, XING_NORM_ADDED, XING_TRIPLE
from warpvec.kernels.lanes import Lanes, bundle, stage_module
from warpvec.kernels.making import made_once


@made_once
def make_kernels(lanes: Lanes) -> SimpleNamespace:
    """Return ``add_side_terms``."""
    dtype, vec2 = lanes.dtype, lanes.vec2
    zero, one, quarter = (wp.constant(dtype(value)) for value in (0.0, 1.0, 0.25))
    norm_added, triple = wp.constant(dtype(XING_NORM_ADDED)), wp.constant(XING_TRIPLE)
    tip_cosine_squared = wp.constant(dtype(TIP_COSINE**2))
    module = stage_module("side_terms", lanes)

    @wp.func
    def leg(points: wp.array(dtype=vec2), start: int, point: int, point_count: int, pixel: vec2):
        """Return the vector from a point of the path to the next one, in half sides."""
        index = point % point_count
        return wp.cw_mul(points[start + (index + 1) % point_count] - points[start + index], pixel)

    @wp.func
    def add_leg(adj_points: wp.array(dtype=vec2), start: int, point: int, point_count: int, pixel: vec2, adj_leg: vec2):
        """Add the adjoint of a `leg` to those of its ends."""
        index = point % point_count
        adj = wp.cw_mul(adj_leg, pixel)
        following = start + (index + 1) % point_count
        adj_points[start + index] = adj_points[start + index] - adj
        adj_points[following] = adj_points[following] + adj

    @wp.func
    def cross(u: vec2, w: vec2):
        return u[0] * w[1] - u[1] * w[0]

    @wp.func
    def toward(u: vec2):
        """Return the unit vector along ``u``, or zero: the derivative of its length."""
        length = wp.length(u)
        return wp.where(length > zero, u / wp.where(length > zero, length, one), vec2())

    @wp.func
    def beyond(value: dtype):
        """Return the sign of ``value`` if it lies outside [-1, 1], else zero."""
        return wp.where(value > one, one, wp.where(value < -one, -one, zero))

    @wp.kernel(module=module)
    def add_side_terms(
        first: int,
        points: wp.array(dtype=vec2),  # [N 2 M] px
        opacity: wp.array2d(dtype=dtype),  # [N, opacities of a path]
        counts: wp.array(dtype=int),  # [1] N, the paths that there are
        reach: wp.array(dtype=dtype),  # [M] weights of the legs of a side in the vector from its start to a tip's probe
        pixel: vec2,  # size of a pixel in half sides
        xing_weight: dtype,
        bezier_weight: dtype,
        opacity_weight: dtype,
        # in and out
        adj_points: wp.array(dtype=vec2),  # [N 2 M]
        adj_opacity: wp.array2d(dtype=dtype),  # [N, opacities of a path]
    ):
        """Add the regularizers' adjoints of one path."""
        path = first + wp.tid()
        if path >= counts[0]:
            return
        per_path = one / dtype(counts[0])
        degree = reach.shape[0]
        point_count = 2 * degree
        start = path * point_count

        triple_count = (point_count - 1) // triple
        for index in range(triple_count):
            point = triple * index
            before = leg(points, start, point, point_count, pixel)
            after = leg(points, start, point + 2, point_count, pixel)
            turn = wp.where(cross(before, leg(points, start, point + 1, point_count, pixel)) >= zero, one, -one)
            divisor = wp.length(before) * wp.length(after) + norm_added
            sine = cross(before, after) / divisor
            if sine * turn < zero:
                weight = -turn * xing_weight * per_path / dtype(triple_count) / divisor
                adj_before = vec2(after[1], -after[0]) - sine * wp.length(after) * toward(before)
                adj_after = vec2(-before[1], before[0]) - sine * wp.length(before) * toward(after)
                add_leg(adj_points, start, point, point_count, pixel, weight * adj_before)
                add_leg(adj_points, start, point + 2, point_count, pixel, weight * adj_after)

        for side in range(2):
            joint, other = side * degree, (1 - side) * degree
            ahead, behind = vec2(), vec2()
            for j in range(degree):
                ahead += reach[j] * leg(points, start, joint + j, point_count, pixel)
                behind -= reach[degree - 1 - j] * leg(points, start, other + j, point_count, pixel)
            cosine = wp.max(wp.dot(ahead, behind), zero)
            if cosine * cosine > wp.dot(ahead, ahead) * wp.dot(behind, behind) * tip_cosine_squared:
                tip = bezier_weight * per_path * (ahead + behind)
                for j in range(degree):
                    add_leg(adj_points, start, joint + j, point_count, pixel, reach[j] * tip)
                    add_leg(adj_points, start, other + j, point_count, pixel, -reach[degree - 1 - j] * tip)
            place = wp.cw_mul(points[start + joint], pixel)
            outward = vec2(beyond(place[0] - one), beyond(place[1] - one))
            adj_joint = bezier_weight * per_path * quarter * wp.cw_mul(outward, pixel)
            adj_points[start + joint] = adj_points[start + joint] + adj_joint

        share = opacity_weight * per_path / dtype(opacity.shape[1])
        for k in range(opacity.shape[1]):
            slope = wp.where(opacity[path, k] < one, -one, wp.where(opacity[path, k] > one, one, zero))
            adj_opacity[path, k] = adj_opacity[path, k] + share * slope

    return bundle(add_side_terms)
