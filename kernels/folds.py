"""Where outlines cross themselves, and lines turn back, once a file has rounded their nodes.

The same as `warpvec.geometry.rounding`, `crossings` and `overshoots`, which say more, in one launch. One work item does
all: a drawing that is fitted exactly has at most some hundred curves.
"""

import math
from types import SimpleNamespace
from typing import Any

import warp as wp

from warpvec.kernels import bezier
from warpvec.kernels.constants import DIRECTION_MIN
from warpvec.kernels.lanes import bundle, make_lanes, unit
from warpvec.kernels.vectors import as_real, cross, unit_of, vec2

real = wp.float64


def make_kernels(numbers: Any) -> SimpleNamespace:
    """Return ``round_nodes``, ``count_crossings`` and ``find_overshoots``.

    ``numbers`` has the constants of the modules above: ``smooth_degrees``, ``handle_error``, ``rounding_degrees_max``,
    ``length_min``, ``turn_max``, ``reach``, ``chords``, ``fold_min`` and ``fold_width``.
    """
    module = unit("folds")
    curves = bezier.make_functions(make_lanes(1, real))
    shortest = wp.constant(real(DIRECTION_MIN))
    zero, half = wp.constant(real(0.0)), wp.constant(real(0.5))
    turn_max, turn_cost = wp.constant(real(numbers.turn_max)), wp.constant(real(4 * numbers.reach))
    reach = wp.constant(numbers.reach)
    chords, chord_share = wp.constant(numbers.chords), wp.constant(real(1.0 / numbers.chords))
    smooth = wp.constant(real(math.radians(numbers.smooth_degrees)))
    rounding_max = wp.constant(real(math.radians(numbers.rounding_degrees_max)))
    handle_error, length_min = wp.constant(real(numbers.handle_error)), wp.constant(real(numbers.length_min))
    fold_min, fold_width = wp.constant(real(numbers.fold_min)), wp.constant(real(numbers.fold_width))

    @wp.func
    def turn_of(handle: vec2, direction: vec2):
        found = wp.atan2(wp.abs(cross(handle, direction)), wp.dot(handle, direction))
        if handle[0] == zero and handle[1] == zero:
            found = real(wp.inf)
        return found

    @wp.func
    def rounded(handle: vec2, direction: vec2):
        """Return whole numbers near a handle that lie along a direction; see `warpvec.geometry.rounding`."""
        nearest = vec2(wp.rint(handle[0]), wp.rint(handle[1]))
        best = vec2(nearest)
        if turn_of(nearest, direction) > turn_max:
            least = real(wp.inf)
            for i in range(-reach, reach + 1):
                for j in range(-reach, reach + 1):
                    tried = nearest + vec2(real(i), real(j))
                    excess = wp.max(turn_of(tried, direction) - turn_max, zero)
                    cost = wp.length(tried - handle) + turn_cost * excess / turn_max
                    if cost < least:
                        least = cost
                        best = vec2(tried)
        return best

    @wp.kernel(module=module)
    def round_nodes(
        first: int,
        ticks: real,  # of the file in a pixel
        row_count: int,  # R
        points: wp.array2d(dtype=wp.vec2f),  # [R, 3] px
        row_next: wp.array(dtype=int),  # [R]
        row_previous: wp.array(dtype=int),  # [R]
        is_line: wp.array(dtype=wp.bool),  # [R]
        is_end: wp.array(dtype=wp.bool),  # [R] nodes at the ends of open lines, which are never smooth
        # outputs
        anchor: wp.array(dtype=vec2),  # [R] scratch: ticks
        leaving: wp.array(dtype=vec2),  # [R] scratch
        arriving: wp.array(dtype=vec2),  # [R] scratch
        written: wp.array2d(dtype=vec2),  # [R, 4] px: the control points and the end
    ):
        """Round the nodes as a file does; see `warpvec.geometry.rounding.round_nodes`."""
        for row in range(row_count):
            here = as_real(points[row, 0])
            anchor[row] = vec2(wp.rint(ticks * here[0]), wp.rint(ticks * here[1]))
        for row in range(row_count):
            before = row_previous[row]
            after = row_next[row]
            here = as_real(points[row, 0])
            out, back = as_real(points[row, 1]) - here, as_real(points[before, 2]) - here
            ahead, behind = vec2(out), -back
            if is_line[row]:
                ahead = as_real(points[after, 0]) - here
            if is_line[before]:
                behind = here - as_real(points[before, 0])
            shorter = wp.min(wp.length(ahead), wp.length(behind))
            slack = wp.min(handle_error / wp.max(shorter, real(1e-9)), rounding_max)
            is_smooth = (
                wp.dot(unit_of(ahead, shortest), unit_of(behind, shortest)) > wp.cos(smooth + slack)
                and shorter > length_min
            )
            is_smooth = is_smooth and not (is_line[row] and is_line[before]) and not is_end[row]
            out, back = ticks * out, ticks * back
            if is_smooth:
                along = out - back
                if is_line[row]:
                    along = anchor[after] - anchor[row]
                if is_line[before]:
                    along = anchor[row] - anchor[before]
                along = unit_of(along, shortest)
                leaving[row] = rounded(out, along)
                arriving[row] = -rounded(-back, along)
            else:
                leaving[row] = vec2(wp.rint(out[0]), wp.rint(out[1]))
                arriving[row] = vec2(wp.rint(back[0]), wp.rint(back[1]))
        for row in range(row_count):
            after = row_next[row]
            written[row, 0] = anchor[row] / ticks
            written[row, 1] = (anchor[row] + leaving[row]) / ticks
            written[row, 2] = (anchor[after] + arriving[after]) / ticks
            written[row, 3] = anchor[after] / ticks

    @wp.func
    def is_across(a: vec2, b: vec2, c: vec2, d: vec2):
        one_side = wp.sign(cross(b - a, c - a)) * wp.sign(cross(b - a, d - a))
        other_side = wp.sign(cross(d - c, a - c)) * wp.sign(cross(d - c, b - c))
        found = cross(b - a, c - a) != zero and cross(b - a, d - a) != zero
        found = found and cross(d - c, a - c) != zero and cross(d - c, b - c) != zero
        return found and one_side < zero and other_side < zero

    @wp.kernel(module=module)
    def count_crossings(
        first: int,
        row_count: int,  # R
        path_count: int,  # N
        written: wp.array2d(dtype=vec2),  # [R, 4] px
        row_next: wp.array(dtype=int),  # [R]
        row_loop: wp.array(dtype=int),  # [R]
        loop_first_row: wp.array(dtype=int),  # [loops + 1]
        path_first_row: wp.array(dtype=int),  # [N + 1]
        is_guarded: wp.array(dtype=wp.bool),  # [N]
        # outputs
        place: wp.array(dtype=vec2),  # [chords R] scratch: the start of each chord
        box: wp.array2d(dtype=vec2),  # [R, 2] scratch
        areas: wp.array(dtype=real),  # [chords R + 1] scratch: sums over the chords before
        lengths: wp.array(dtype=real),  # the same
        counts: wp.array(dtype=int),  # [R]
    ):
        """Count the crossings of each curve with others of its path; see `crossings_of_rows`."""
        for row in range(row_count):
            counts[row] = 0
            for k in range(chords):
                w = curves.weights(real(k) * chord_share)
                first_half = w[0] * written[row, 0] + w[1] * written[row, 1]
                place[row * chords + k] = first_half + (w[2] * written[row, 2] + w[3] * written[row, 3])
        areas[0] = zero
        lengths[0] = zero
        for row in range(row_count):
            least, most = vec2(place[row * chords]), vec2(place[row * chords])
            for k in range(chords):
                chord = row * chords + k
                following = chord + 1
                if k == chords - 1:
                    following = row_next[row] * chords
                areas[chord + 1] = areas[chord] + cross(place[chord], place[following])
                lengths[chord + 1] = lengths[chord] + wp.length(place[following] - place[chord])
                least, most = wp.min(least, place[following]), wp.max(most, place[following])
            box[row, 0] = least
            box[row, 1] = most
        for path in range(path_count):
            if is_guarded[path]:
                for row in range(path_first_row[path], path_first_row[path + 1]):
                    for other in range(row, path_first_row[path + 1]):
                        apart = box[row, 0][0] > box[other, 1][0] or box[other, 0][0] > box[row, 1][0]
                        apart = apart or box[row, 0][1] > box[other, 1][1] or box[other, 0][1] > box[row, 1][1]
                        if not apart:
                            for k in range(chords):
                                low = row * chords + k
                                low_end = low + 1
                                if k == chords - 1:
                                    low_end = row_next[row] * chords
                                a = place[low]
                                b = place[low_end]
                                for m in range(chords):
                                    high = other * chords + m
                                    if low < high:
                                        high_end = high + 1
                                        if m == chords - 1:
                                            high_end = row_next[other] * chords
                                        if is_across(a, b, place[high], place[high_end]):
                                            loop = row_loop[row]
                                            is_seen = loop != row_loop[other]
                                            if not is_seen:
                                                begin = loop_first_row[loop] * chords
                                                end = loop_first_row[loop + 1] * chords
                                                area = areas[high] - areas[low + 1] + cross(place[high], b)
                                                length = lengths[high] - lengths[low + 1]
                                                rest = areas[end] - areas[begin] - area
                                                if wp.abs(area) >= wp.abs(rest):
                                                    area = rest
                                                    length = lengths[end] - lengths[begin] - length
                                                thin = half * fold_width * length
                                                is_seen = half * wp.abs(area) >= wp.max(fold_min, thin)
                                            if is_seen:
                                                counts[row] = counts[row] + 1
                                                counts[other] = counts[other] + 1

    @wp.func
    def distance(a: vec2, begin: vec2, end: vec2):
        along = end - begin
        return wp.abs(cross(along, a - begin)) / wp.max(wp.length(along), real(1e-9))

    @wp.kernel(module=module)
    def find_overshoots(
        first: int,
        row_count: int,  # R
        written: wp.array2d(dtype=vec2),  # [R, 4] px
        row_path: wp.array(dtype=int),  # [R]
        path_width: wp.array(dtype=float),  # [N] px
        # outputs
        turns_back: wp.array(dtype=wp.bool),  # [R]
    ):
        """Tell which curves of strokes overshoot an end; see `warpvec.geometry.overshoots`."""
        for row in range(row_count):
            start, out = written[row, 0], written[row, 1]
            back, end = written[row, 2], written[row, 3]
            off = wp.max(distance(out, start, end), distance(back, start, end))
            is_straight = off < half * real(path_width[row_path[row]])
            is_past = wp.dot(out - start, back - start) < zero or wp.dot(end - back, end - out) < zero
            turns_back[row] = is_straight and is_past

    return bundle(round_nodes, count_crossings, find_overshoots)
