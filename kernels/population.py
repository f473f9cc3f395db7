"""Step the paths of a fit: from the adjoints of a scene's values to its next values, in one launch.

A segment has an age of its own, because a path may gain segments later.

``warpvec/fit/population.py`` describes the parameters. One pass over them does the chain rule, Adan and the scene's new
values.
"""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels.adan import SCALED, SIGMOID, make_functions
from warpvec.kernels.constants import REDUCED_LANES
from warpvec.kernels.lanes import Lanes, bundle, stage_module
from warpvec.kernels.making import made_once


def threads_per_path(lanes: Lanes, by_axis: bool = False) -> int:
    """Return the number of threads that share a path: a warp on CUDA, one on a CPU (where lanes are not threads).

    ``by_axis`` it is even, so that each takes the values of one axis.
    """
    return REDUCED_LANES if lanes.width == 1 else 1 + by_axis


@made_once
def make_kernels(lanes: Lanes, by_axis: bool = False) -> SimpleNamespace:
    """Make ``step_population`` and ``begin_step``; ``by_axis`` the unit of points differs across and down."""
    dtype, vec2, vec3 = lanes.dtype, lanes.vec2, lanes.vec3
    array2d, array3d = wp.array2d(dtype=dtype), wp.array3d(dtype=dtype)
    one = wp.constant(dtype(1.0))
    optimizer = make_functions(lanes)
    parts = wp.constant(threads_per_path(lanes, by_axis))
    module = stage_module("population" + "_by_axis" * by_axis, lanes)

    @wp.kernel(module=module)
    def step_population(
        first: int,
        path_count: int,  # N, or room for so many; the background follows
        counts: wp.array(dtype=int),  # [1] paths that there are
        unit: vec2,  # px, across and down; equal unless ``by_axis``
        color_form: int,
        rates: wp.vec3d,  # learning rates of points, colours and opacities
        factor: wp.array(dtype=wp.float64),  # [1] multiplies the rates; if it is negative, nothing changes
        betas: vec3,
        log_betas: vec3,
        eps: dtype,
        path_first_segment: wp.array(dtype=int),  # [N + 1]
        segment_age: wp.array(dtype=wp.int64),  # [R] steps taken, including this one
        path_age: wp.array(dtype=wp.int64),  # [N + 1] the same; the last is the background's
        adj_segments: array2d,  # [R, 2 M], dense
        adj_color: array2d,  # [N, 3]
        adj_opacity: array2d,  # [N, 1]
        adj_background: array2d,  # [1, 3]
        # in and out: a parameter, the averages m, v and n, and the previous gradient
        segments: array3d,  # [5, R, 2 M]
        color: array3d,  # [5, N, 3]
        opacity: array3d,  # [5, N, 1]
        background: array3d,  # [5, 1, 3]
        # in and out: the scene's values
        scene_segments: array2d,  # [R, 2 M] px
        scene_color: array2d,  # [N, 3]
        scene_opacity: array2d,  # [N, 1]
        scene_background: array2d,  # [1, 3]
    ):
        """Take one step of one part of a path and its segments; path N is the background."""
        if factor[0] < wp.float64(0.0):
            return
        item = first + wp.tid()
        path = item // parts
        part = item - path * parts
        if path < path_count and path >= counts[0]:
            return
        scale = unit[0]
        if wp.static(by_axis):
            scale = wp.where(part % 2 == 0, unit[0], unit[1])
        age = path_age[path]
        first_step = age == wp.int64(1)
        bias = optimizer.corrections(age, log_betas)
        lr_color = dtype(rates[1] * factor[0])
        if path < path_count:
            lr_points, lr_opacity = dtype(rates[0] * factor[0]), dtype(rates[2] * factor[0])
            segment, end = int(path_first_segment[path]), path_first_segment[path + 1]
            while segment < end:
                # Segments of equal age are one long row, which is faster than several short ones.
                stop = int(segment + 1)
                while stop < end and segment_age[stop] == segment_age[segment]:
                    stop += 1
                own_age = segment_age[segment]
                own_bias = vec3(bias)
                if own_age != age:
                    own_bias = optimizer.corrections(own_age, log_betas)
                optimizer.update_row(
                    segment, stop - segment, part, parts, wp.static(SCALED), scale, own_age == wp.int64(1),
                    lr_points, betas, own_bias, eps, adj_segments,
                    segments[0], segments[1], segments[2], segments[3], segments[4], scene_segments,
                )  # fmt: skip
                segment = int(stop)
            optimizer.update_row(
                path, 1, part, parts, color_form, one, first_step, lr_color, betas, bias, eps,
                adj_color, color[0], color[1], color[2], color[3], color[4], scene_color,
            )  # fmt: skip
            optimizer.update_row(
                path, 1, part, parts, wp.static(SIGMOID), one, first_step, lr_opacity, betas, bias, eps,
                adj_opacity, opacity[0], opacity[1], opacity[2], opacity[3], opacity[4], scene_opacity,
            )  # fmt: skip
        else:
            optimizer.update_row(
                0, 1, part, parts, color_form, one, first_step, lr_color, betas, bias, eps,
                adj_background, background[0], background[1], background[2], background[3], background[4],
                scene_background,
            )  # fmt: skip

    @wp.kernel(module=module)
    def begin_step(
        first: int,
        path_count: int,
        segment_count: int,
        step_fits: wp.array(dtype=wp.float64),  # [1] 1, or -1 if there was no room to draw the paths
        factors: wp.array(dtype=wp.float64),  # [steps] of the learning rates of the coming steps
        # in and out
        fits: wp.array(dtype=wp.float64),  # [1] the same of all steps so far
        position: wp.array(dtype=int),  # [1] steps begun, into ``factors``
        segment_age: wp.array(dtype=wp.int64),  # [R]
        path_age: wp.array(dtype=wp.int64),  # [N + 1]
        # outputs
        factor: wp.array(dtype=wp.float64),  # [1] for ``step_population``
    ):
        """Take the factor of a step, and age what it steps; without room, now or before, nothing changes."""
        item = first + wp.tid()
        # Every item may read this before or after item 0 has written it: the result is the same.
        all_fit = wp.min(fits[0], step_fits[0])
        if all_fit > wp.float64(0.0):
            if item < segment_count:
                segment_age[item] = segment_age[item] + wp.int64(1)
            if item <= path_count:
                path_age[item] = path_age[item] + wp.int64(1)
        if item == 0:
            factor[0] = wp.where(all_fit > wp.float64(0.0), factors[position[0]], wp.float64(-1.0))
            fits[0] = all_fit
            position[0] = position[0] + 1

    return bundle(step_population, begin_step)
