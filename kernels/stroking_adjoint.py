"""Stage 1 for strokes, the adjoint: dL/d(vertices of the outline) -> dL/d(centre line) and dL/d(width).

With the angle a of the tangent, N' = dN/da is minus the unit tangent, and da = N . dT / abs(T) for a tangent T. A
vertex of a side is P +- h N minus a share of the second difference of its neighbours, so the adjoint of P +- h N at j
is that share's transpose. A vertex at an anchor, anchor + s h g(d) N(a + u d) with d = b - a, has

    dL/d(a) = s h ((1 - u) g N' - g' N) . adj    dL/d(b) = s h (u g N' + g' N) . adj    dL/d(h) = s g N . adj

A row takes the part of its own two tangents, and leaves the part of the tangent before to the row before. So every row
writes entries of its own only.
"""

import math
from types import SimpleNamespace

import warp as wp

from warpvec.geometry.strokes import END, FILLED, FIRST, INNER
from warpvec.kernels import bezier, stroking
from warpvec.kernels.lanes import Lanes, bundle, stage_module
from warpvec.kernels.making import made_once


@made_once
def make_kernels(lanes: Lanes) -> SimpleNamespace:
    """Return ``land_edges``, ``gather_rows_adjoint`` and ``gather_widths_adjoint``."""
    dtype, vec2, vec3, vec4 = lanes.dtype, lanes.vec2, lanes.vec3, lanes.vec4
    curve, line = bezier.make_functions(lanes), stroking.make_functions(lanes)
    zero, half, one, two = (wp.constant(dtype(value)) for value in (0.0, 0.5, 1.0, 2.0))
    pi = wp.constant(dtype(math.pi))
    module = stage_module("stroking_adjoint", lanes)

    @wp.kernel(module=module)
    def land_edges(
        first: int,
        edge_end: wp.array(dtype=int),  # [V]
        edge_count: wp.array(dtype=int),  # [R + 1] the last entry is the number of edges, E
        row_count: int,  # R
        adj_edges: wp.array(dtype=vec4),  # [V]
        # outputs
        adj_landing: wp.array(dtype=vec2),  # [V] dL/d(vertex) by the edge that ends there
    ):
        """Bring dL/d(end) of each edge to the vertex where it ends; one edge ends at each vertex."""
        edge = first + wp.tid()
        if edge < edge_count[row_count]:
            adj = adj_edges[edge]
            adj_landing[edge_end[edge]] = vec2(adj[2], adj[3])

    @wp.func
    def at_vertex(vertex: int, adj_edges: wp.array(dtype=vec4), adj_landing: wp.array(dtype=vec2)):
        adj = adj_edges[vertex]
        return vec2(adj[0], adj[1]) + adj_landing[vertex]

    @wp.func
    def node_sums(
        start: int,
        count: int,
        kind: int,
        normal: vec2,
        side: dtype,
        angle: dtype,
        is_back: bool,
        adj_edges: wp.array(dtype=vec4),
        adj_landing: wp.array(dtype=vec2),
    ):
        """Return dL/d(anchor), and dL/d(angle before) / h, dL/d(angle after) / h and dL/d(h) of one side of a node."""
        adj_anchor = vec2()
        sums = vec3()
        for i in range(count):
            v = line.node_vertex(kind, i, count, angle)
            share = v[0]
            if is_back:
                share = one - share
            adj = at_vertex(start + i, adj_edges, adj_landing)
            out = side * line.turned(normal, share * angle)
            along = adj[1] * out[0] - adj[0] * out[1]
            across = wp.dot(adj, out)
            adj_anchor += adj
            sums += vec3(
                (one - share) * v[1] * along - v[2] * across, share * v[1] * along + v[2] * across, v[1] * across
            )
        return vec4(adj_anchor[0], adj_anchor[1], sums[0], sums[1]), sums[2]

    @wp.func
    def node_adjoint(
        segment: int,
        role: int,
        before: vec3,
        after: vec3,
        plan: wp.vec4i,
        start: int,
        adj_edges: wp.array(dtype=vec4),
        adj_landing: wp.array(dtype=vec2),
    ):
        """Return what `node_sums` does, of all that stands at the anchor of a row."""
        total = vec4()
        width = dtype(0.0)
        if role == INNER:
            angle = line.turn(before, after)
            normal = line.normal_of(before)
            left, left_width = node_sums(start, plan[1], plan[0], normal, one, angle, False, adj_edges, adj_landing)
            back = start + plan[1]
            right, right_width = node_sums(back, plan[3], plan[2], normal, -one, angle, True, adj_edges, adj_landing)
            total = left + right
            width = left_width + right_width
        elif role == FIRST:
            normal = line.normal_of(after)
            cap, width = node_sums(start, plan[1], plan[0], normal, -one, -pi, False, adj_edges, adj_landing)
            total = vec4(cap[0], cap[1], zero, cap[2] + cap[3])
        else:
            normal = line.normal_of(before)
            cap, width = node_sums(start, plan[1], plan[0], normal, one, -pi, False, adj_edges, adj_landing)
            total = vec4(cap[0], cap[1], cap[2] + cap[3], zero)
        return total, width

    @wp.func
    def side_sum(
        vertex: int,
        j: int,
        chords: int,
        adj_edges: wp.array(dtype=vec4),
        adj_landing: wp.array(dtype=vec2),
    ):
        """Return dL/d(O) at point j of a side, whose vertex 0 is ``vertex``: the transpose of moving vertices out."""
        out = dtype(chords) / dtype(12 * wp.max(chords - 1, 1))
        total = at_vertex(vertex + j, adj_edges, adj_landing)
        if j > 0 and j < chords:
            total = (one + two * out) * total
        if j > 1:
            total -= out * at_vertex(vertex + j - 1, adj_edges, adj_landing)
        if j < chords - 1:
            total -= out * at_vertex(vertex + j + 1, adj_edges, adj_landing)
        return total

    @wp.func
    def finite(adj: vec2):
        """Return the adjoint, or 0 for a line that is not finite, which is not drawn."""
        result = vec2()
        if wp.isfinite(adj[0]) and wp.isfinite(adj[1]):
            result = vec2(adj[0], adj[1])
        return result

    @wp.kernel(module=module)
    def gather_rows_adjoint(
        first: int,
        points: wp.array(dtype=vec2),  # [3 R] px
        segment_next: wp.array(dtype=int),  # [R]
        segment_previous: wp.array(dtype=int),  # [R]
        segment_path: wp.array(dtype=int),  # [R]
        segment_role: wp.array(dtype=int),  # [R]
        path_width: wp.array(dtype=dtype),  # [N] px
        node_plan: wp.array(dtype=wp.vec4i),  # [R]
        segment_first_vertex: wp.array(dtype=int),  # [R + 1]
        adj_edges: wp.array(dtype=vec4),  # [V]
        adj_landing: wp.array(dtype=vec2),  # [V]
        # outputs
        adj_points: wp.array(dtype=vec2),  # [3 R] but for the anchors as ends of the rows before
        adj_ends: wp.array(dtype=vec2),  # [R]
        adj_radius: wp.array(dtype=dtype),  # [R] dL/d(half the width)
    ):
        """Sum dL/d(points) of one row of a stroke, and its part of dL/d(half the width)."""
        segment = first + wp.tid()
        role = segment_role[segment]
        adj_radius[segment] = zero
        if role == FILLED:
            return
        start, end = segment_first_vertex[segment], segment_first_vertex[segment + 1]
        a0 = vec2()
        a1 = vec2()
        a2 = vec2()
        a3 = vec2()
        adj_width = dtype(0.0)
        if start < end:
            previous, following = segment_previous[segment], segment_next[segment]
            radius = half * path_width[segment_path[segment]]
            plan = node_plan[segment]
            left = start + plan[1] + plan[3]
            chords = (end - left) // 2 - 1
            right = left + chords + 1
            p0, p1, p2 = points[3 * segment], points[3 * segment + 1], points[3 * segment + 2]
            p3 = points[3 * following]
            o = 3 * previous
            before = line.heading(points[o], points[o + 1], points[o + 2], p0, 1, 1)
            after = line.heading(p0, p1, p2, p3, 0, 1)
            node, node_width = node_adjoint(segment, role, before, after, plan, start, adj_edges, adj_landing)
            a0 = vec2(node[0], node[1])
            adj_width = node_width
            if role != END:
                o = 3 * following
                beyond = line.heading(p3, points[o + 1], points[o + 2], points[3 * segment_next[following]], 0, 1)
                arriving = line.heading(p0, p1, p2, p3, 1, 1)
                at_end, _width = node_adjoint(
                    following,
                    segment_role[following],
                    arriving,
                    beyond,
                    node_plan[following],
                    segment_first_vertex[following],
                    adj_edges,
                    adj_landing,
                )
                for j in range(chords + 1):
                    adj_left = side_sum(left, j, chords, adj_edges, adj_landing)
                    adj_right = side_sum(right, j, chords, adj_edges, adj_landing)
                    here = line.heading(p0, p1, p2, p3, j, chords)
                    normal = line.normal_of(here)
                    across = adj_left - adj_right
                    adj_width += wp.dot(normal, across)
                    adj_angle = -(here[0] * across[0] + here[1] * across[1])
                    if j == 0:
                        adj_angle += node[3]
                    if j == chords:
                        adj_angle += at_end[2]
                    adj_tangent = radius * adj_angle * here[2] * normal
                    t = line.tangent_weights(p0, p1, p2, p3, j, chords)
                    w = curve.weights(dtype(j) / dtype(chords))
                    adj_point = adj_left + adj_right
                    a0 += w[0] * adj_point + t[0] * adj_tangent
                    a1 += w[1] * adj_point + t[1] * adj_tangent
                    a2 += w[2] * adj_point + t[2] * adj_tangent
                    a3 += w[3] * adj_point + t[3] * adj_tangent
        adj_points[3 * segment] = finite(a0)
        adj_points[3 * segment + 1] = finite(a1)
        adj_points[3 * segment + 2] = finite(a2)
        adj_ends[segment] = finite(a3)
        if wp.isfinite(adj_width):
            adj_radius[segment] = adj_width

    @wp.kernel(module=module)
    def gather_widths_adjoint(
        first: int,
        loop_first_segment: wp.array(dtype=int),  # [L + 1]
        path_first_loop: wp.array(dtype=int),  # [N + 1]
        adj_radius: wp.array(dtype=dtype),  # [R]
        # outputs
        adj_width: wp.array(dtype=dtype),  # [N]
    ):
        """Sum dL/d(width) of one path, row after row."""
        path = first + wp.tid()
        total = dtype(0.0)
        for row in range(loop_first_segment[path_first_loop[path]], loop_first_segment[path_first_loop[path + 1]]):
            total += adj_radius[row]
        adj_width[path] = half * total

    return bundle(land_edges, gather_rows_adjoint, gather_widths_adjoint)
