"""Stage 1 for strokes: the centre line and width of a stroked path -> vertices of its outline, and the adjoint.

The outline of an open line is its left side, the cap at its end, its right side back, and the cap at its start. That of
a closed line is two loops: the left side, and the right side back. All other stages see edges like those of a fill.

A side is the curve O(t) = P(t) +- h N(t), with h half the width and N the unit normal, the tangent turned by 90
degrees from x to y. It has n chords at equal steps of t. Vertex j is O(j / n), moved out like those of a fill
(``bezier.py``), with the second difference of O in place of P'' / n^2.

A row owns what stands at its anchor: a join, or a cap. Its vertices are anchor + s h g N(angle), with the side s, the
reach g, and an angle between those of the tangents before and after. The inner side of a join goes through the anchor,
so that no part of the outline runs the other way round. This is how Skia and resvg draw strokes.

Sources: SVG 2, section 13.5; R. Levien and A. Uguray, "GPU-friendly Stroke Expansion" (2024), section 3.

A row has its vertices in this order: those at its anchor on the left (or of the cap), those at its anchor on the right,
the n + 1 of its left side, and the n + 1 of its right side. The last row of an open line is its end: it has only a cap.
"""

import math
from types import SimpleNamespace

import warp as wp

from warpvec.geometry.strokes import END, FILLED, FIRST, INNER, MITER, ROUND, SQUARE
from warpvec.kernels import bezier
from warpvec.kernels.constants import (
    ARC_CHORDS_MAX,
    CHORD_TOLERANCE,
    JOIN_ANGLE_MIN,
    LEG_MIN,
    SEGMENT_CHORDS_MAX,
    TURN_SAMPLES,
)
from warpvec.kernels.lanes import Lanes, bundle, stage_module
from warpvec.kernels.making import made_once

NOTHING, ARC, CORNER, PIVOT, BOX = range(5)
"""What stands at an anchor on one side: no vertex; those of an arc; a miter; the anchor; two corners of a cap."""

ROW_VERTICES_MAX = 2 * (SEGMENT_CHORDS_MAX + 1) + ARC_CHORDS_MAX
"""Most vertices of a row: its two sides, and what stands at its anchor."""


@made_once
def make_functions(lanes: Lanes) -> SimpleNamespace:
    """Return the geometry of a row: ``tangent_weights``, ``heading``, ``turn``, ``chord_count`` and ``node_vertex``."""
    dtype, vec2, vec3, vec4 = lanes.dtype, lanes.vec2, lanes.vec3, lanes.vec4
    curve = bezier.make_functions(lanes)
    zero, half, one, two, three = (wp.constant(dtype(value)) for value in (0.0, 0.5, 1.0, 2.0, 3.0))
    leg_min, root_two = wp.constant(dtype(LEG_MIN)), wp.constant(dtype(math.sqrt(2.0)))
    chords_per_radian = wp.constant(dtype((0.125 / CHORD_TOLERANCE) ** 0.5))
    samples, chords_max = wp.constant(dtype(TURN_SAMPLES)), wp.constant(dtype(ARC_CHORDS_MAX))

    @wp.func
    def is_leg(leg: vec2):
        return wp.length(leg) >= leg_min

    @wp.func
    def tangent_weights(p0: vec2, p1: vec2, p2: vec2, p3: vec2, j: int, count: int):
        """Return the weights of the control points in the tangent at t = j / n; all 0 if it has no direction.

        An end whose handle has no length has the direction to the next control point that lies apart.
        """
        t = dtype(j) / dtype(count)
        u = one - t
        w = three * vec4(-u * u, u * u - two * u * t, two * u * t - t * t, t * t)
        if j == 0 and not is_leg(p1 - p0):
            w = vec4(-one, zero, one, zero)
            if not is_leg(p2 - p0):
                w = vec4(-one, zero, zero, one)
        if j == count and not is_leg(p3 - p2):
            w = vec4(zero, -one, zero, one)
            if not is_leg(p3 - p1):
                w = vec4(-one, zero, zero, one)
        if not is_leg(w[0] * p0 + w[1] * p1 + w[2] * p2 + w[3] * p3):
            w = vec4()
        return w

    @wp.func
    def heading(p0: vec2, p1: vec2, p2: vec2, p3: vec2, j: int, count: int):
        """Return the unit tangent at t = j / n and 1 / its length before; x and 0 for a tangent of no direction."""
        w = tangent_weights(p0, p1, p2, p3, j, count)
        tangent = w[0] * p0 + w[1] * p1 + w[2] * p2 + w[3] * p3
        length = wp.length(tangent)
        result = vec3(one, zero, zero)
        if length > zero or not wp.isfinite(length):
            result = vec3(tangent[0] / length, tangent[1] / length, one / length)
        return result

    @wp.func
    def normal_of(heading: vec3):
        return vec2(-heading[1], heading[0])

    @wp.func
    def turn(before: vec3, after: vec3):
        """Return the angle from one heading to the next, in (-pi, pi]."""
        cross = before[0] * after[1] - before[1] * after[0]
        return wp.atan2(cross, before[0] * after[0] + before[1] * after[1])

    @wp.func
    def turned(direction: vec2, angle: dtype):
        c, s = wp.cos(angle), wp.sin(angle)
        return vec2(c * direction[0] - s * direction[1], s * direction[0] + c * direction[1])

    @wp.func
    def arc_chords(angle: dtype, radius: dtype):
        """Return the chords of an arc that stay within CHORD_TOLERANCE; at most ``ARC_CHORDS_MAX``."""
        chords = wp.abs(angle) * chords_per_radian * wp.sqrt(radius)
        if not wp.isfinite(chords):
            return 1
        return int(wp.clamp(wp.ceil(chords), one, chords_max))

    @wp.func
    def chord_count(p0: vec2, p1: vec2, p2: vec2, p3: vec2, radius: dtype):
        """Return the chords of both sides: enough for the curve, and for the fastest turn of its tangent."""
        fastest = dtype(0.0)
        before = heading(p0, p1, p2, p3, 0, 1)
        for j in range(wp.static(TURN_SAMPLES)):
            after = heading(p0, p1, p2, p3, j + 1, wp.static(TURN_SAMPLES))
            fastest = wp.max(fastest, wp.abs(turn(before, after)))
            before = vec3(after[0], after[1], after[2])
        by_turn = arc_chords(samples * fastest, radius)
        return wp.max(curve.chord_count(p0, p1, p2, p3), by_turn)

    @wp.func
    def node_vertex(kind: int, i: int, count: int, angle: dtype):
        """Return the share of ``angle`` at vertex i of ``count``, its reach g, and dg/d(angle).

        The vertices of an arc are moved out, so that the polygon has the arc's area.
        """
        chords = dtype(count + 1)
        result = vec3(half, zero, zero)
        if kind == ARC:
            bulge = one / (dtype(6.0) * chords * (chords - one))
            result = vec3(dtype(i + 1) / chords, one + half * angle * angle * bulge, angle * bulge)
        if kind == CORNER:
            c = wp.cos(half * angle)
            result = vec3(half, one / c, half * wp.sin(half * angle) / (c * c))
        if kind == BOX:
            result = vec3(dtype(0.25) + half * dtype(i), root_two, zero)
        return result

    return bundle(tangent_weights, heading, normal_of, turn, turned, arc_chords, chord_count, node_vertex)


@made_once
def make_kernels(lanes: Lanes) -> SimpleNamespace:
    """Return ``count_vertices`` and ``emit_vertices``."""
    dtype, vec2 = lanes.dtype, lanes.vec2
    curve, line = bezier.make_functions(lanes), make_functions(lanes)
    half, one, pi = wp.constant(dtype(0.5)), wp.constant(dtype(1.0)), wp.constant(dtype(math.pi))
    angle_min = wp.constant(dtype(JOIN_ANGLE_MIN))
    module = stage_module("stroking", lanes)

    @wp.func
    def cap_plan(cap: int, radius: dtype):
        """Return what makes a cap, and its number of vertices, twice: the right side has none."""
        if cap == wp.static(ROUND):
            return wp.vec4i(ARC, line.arc_chords(pi, radius), 0, 0)
        if cap == wp.static(SQUARE):
            return wp.vec4i(BOX, 2, 0, 0)
        return wp.vec4i(0, 0, 0, 0)

    @wp.func
    def join_plan(join: int, angle: dtype, radius: dtype, miter_limit: dtype):
        """Return what makes the left and the right side of a join, and their numbers of vertices."""
        kind = int(NOTHING)
        count = int(0)
        if wp.abs(angle) < angle_min or not wp.isfinite(angle):
            return wp.vec4i(0, 0, 0, 0)
        if join == wp.static(ROUND):
            kind = ARC
            count = line.arc_chords(angle, radius) - 1
        if join == wp.static(MITER) and one <= miter_limit * wp.cos(half * angle):
            kind = CORNER
            count = 1
        if angle > dtype(0.0):
            return wp.vec4i(PIVOT, 1, kind, count)
        return wp.vec4i(kind, count, PIVOT, 1)

    @wp.kernel(module=module)
    def count_vertices(
        first: int,
        points: wp.array(dtype=vec2),  # [3 R] px
        segment_next: wp.array(dtype=int),  # [R]
        segment_previous: wp.array(dtype=int),  # [R]
        segment_path: wp.array(dtype=int),  # [R]
        segment_role: wp.array(dtype=int),  # [R]
        path_width: wp.array(dtype=dtype),  # [N] px
        path_cap: wp.array(dtype=int),  # [N]
        path_join: wp.array(dtype=int),  # [N]
        path_miter_limit: wp.array(dtype=dtype),  # [N]
        # outputs
        segment_vertex_count: wp.array(dtype=int),  # [R + 1] those of strokes only
        node_plan: wp.array(dtype=wp.vec4i),  # [R] kind and number on the left, and on the right
    ):
        """Count the vertices of each row of a stroke, and plan what stands at its anchor."""
        segment = first + wp.tid()
        role = segment_role[segment]
        if role == FILLED:
            return
        path, previous, following = segment_path[segment], segment_previous[segment], segment_next[segment]
        radius = half * path_width[path]
        p0, p1, p2 = points[3 * segment], points[3 * segment + 1], points[3 * segment + 2]
        p3 = points[3 * following]
        plan = wp.vec4i(0, 0, 0, 0)
        if role == INNER:
            o = 3 * previous
            before = line.heading(points[o], points[o + 1], points[o + 2], p0, 1, 1)
            angle = line.turn(before, line.heading(p0, p1, p2, p3, 0, 1))
            plan = join_plan(path_join[path], angle, radius, path_miter_limit[path])
        else:
            plan = cap_plan(path_cap[path], radius)
            if plan[0] == ARC:
                plan = wp.vec4i(ARC, plan[1] - 1, 0, 0)
        count = plan[1] + plan[3]
        if role != END:
            count += 2 * (line.chord_count(p0, p1, p2, p3, radius) + 1)
        node_plan[segment] = plan
        segment_vertex_count[segment] = count

    @wp.func
    def put_node(
        start: int,
        count: int,
        kind: int,
        anchor: vec2,
        normal: vec2,
        reach: dtype,
        angle: dtype,
        is_back: bool,
        vertices: wp.array(dtype=vec2),
        edge_end: wp.array(dtype=int),
    ):
        """Write the vertices of one side of a join, or of a cap; ``normal`` points to the first of them if i = -1."""
        for i in range(count):
            v = line.node_vertex(kind, i, count, angle)
            share = v[0]
            if is_back:
                share = one - share
            vertices[start + i] = anchor + reach * v[1] * line.turned(normal, share * angle)
            edge_end[start + i] = start + i + 1

    @wp.kernel(module=module)
    def emit_vertices(
        first: int,
        points: wp.array(dtype=vec2),  # [3 R] px
        segment_next: wp.array(dtype=int),  # [R]
        segment_previous: wp.array(dtype=int),  # [R]
        segment_path: wp.array(dtype=int),  # [R]
        segment_role: wp.array(dtype=int),  # [R]
        path_width: wp.array(dtype=dtype),  # [N] px
        node_plan: wp.array(dtype=wp.vec4i),  # [R]
        segment_first_vertex: wp.array(dtype=int),  # [R + 1]
        # outputs
        vertices: wp.array(dtype=vec2),  # [V] px
        edge_end: wp.array(dtype=int),  # [V]
        edge_path: wp.array(dtype=int),  # [V]
    ):
        """Write the vertices of each row of a stroke, and the end and path of the edge of each vertex."""
        segment = first + wp.tid()
        role = segment_role[segment]
        start, end = segment_first_vertex[segment], segment_first_vertex[segment + 1]
        if role == FILLED or start == end:
            return
        path, previous, following = segment_path[segment], segment_previous[segment], segment_next[segment]
        for vertex in range(start, end):
            edge_path[vertex] = path
        radius = half * path_width[path]
        plan = node_plan[segment]
        left = start + plan[1] + plan[3]
        chords = (end - left) // 2 - 1
        right = left + chords + 1
        p0, p1, p2 = points[3 * segment], points[3 * segment + 1], points[3 * segment + 2]
        p3 = points[3 * following]
        previous_end = segment_first_vertex[previous + 1] - 1  # the last vertex of its right side

        o = 3 * previous
        before = line.heading(points[o], points[o + 1], points[o + 2], p0, 1, 1)
        after = line.heading(p0, p1, p2, p3, 0, 1)
        if role == INNER:
            angle = line.turn(before, after)
            normal = line.normal_of(before)
            put_node(start, plan[1], plan[0], p0, normal, radius, angle, False, vertices, edge_end)
            back = start + plan[1]
            put_node(back, plan[3], plan[2], p0, normal, -radius, angle, True, vertices, edge_end)
            if plan[1] > 0:
                edge_end[back - 1] = left
            if plan[3] > 0:
                edge_end[left - 1] = previous_end
        elif role == FIRST:
            put_node(start, plan[1], plan[0], p0, line.normal_of(after), -radius, -pi, False, vertices, edge_end)
        else:
            put_node(start, plan[1], plan[0], p0, line.normal_of(before), radius, -pi, False, vertices, edge_end)
            if plan[1] > 0:
                edge_end[left - 1] = previous_end
            return

        before_p = vec2()
        before_n = vec2()
        here_p = vec2(p0[0], p0[1])
        here_n = line.normal_of(after)
        for j in range(chords + 1):
            next_p = vec2()
            next_n = vec2()
            if j < chords:
                w = curve.weights(dtype(j + 1) / dtype(chords))
                next_p = w[0] * p0 + w[1] * p1 + w[2] * p2 + w[3] * p3
                next_n = line.normal_of(line.heading(p0, p1, p2, p3, j + 1, chords))
            out = dtype(0.0)
            if j > 0 and j < chords:
                out = dtype(chords) / dtype(12 * (chords - 1))
            point = here_p - out * (before_p - dtype(2.0) * here_p + next_p)
            offset = radius * (here_n - out * (before_n - dtype(2.0) * here_n + next_n))
            vertices[left + j] = point + offset
            vertices[right + j] = point - offset
            edge_end[left + j] = left + j + 1
            edge_end[right + j] = right + j - 1
            before_p = vec2(here_p[0], here_p[1])
            before_n = vec2(here_n[0], here_n[1])
            here_p = vec2(next_p[0], next_p[1])
            here_n = vec2(next_n[0], next_n[1])

        # Where the two sides go on.
        if role == FIRST:
            edge_end[right] = wp.where(plan[1] > 0, start, left)
        else:
            edge_end[right] = wp.where(plan[3] > 0, start + plan[1], previous_end)
        ahead = node_plan[following]
        beyond = segment_first_vertex[following]
        if segment_role[following] == END:
            edge_end[left + chords] = wp.where(ahead[1] > 0, beyond, right + chords)
        else:
            edge_end[left + chords] = wp.where(ahead[1] > 0, beyond, beyond + ahead[1] + ahead[3])

    return bundle(count_vertices, emit_vertices)
