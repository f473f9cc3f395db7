"""Stage 1, flattening: segments -> vertices of closed polylines, and the adjoint.

A segment is a row of three control points: its anchor, the handle that leaves it, and the handle that arrives at the
anchor of the loop's next segment, where it ends. Vertex j of n in a segment is the segment's point at t = j / n, moved
out slightly so that the polygon has the curve's area (``bezier.vertex_weights``). The vertices of a loop's segments are
stored one after another. The edge of vertex v runs to the loop's next vertex.
"""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels import bezier
from warpvec.kernels.lanes import Lanes, bundle, stage_module
from warpvec.kernels.making import made_once


@made_once
def make_kernels(lanes: Lanes) -> SimpleNamespace:
    """Return ``count_chords``, ``emit_vertices``, ``gather_segments_adjoint`` and ``add_arriving_adjoint``."""
    vec2, vec4 = lanes.vec2, lanes.vec4
    curve = bezier.make_functions(lanes)
    module = stage_module("flattening", lanes)

    @wp.kernel(module=module)
    def count_chords(
        first: int,
        points: wp.array(dtype=vec2),  # [3 R] px
        segment_next: wp.array(dtype=int),  # [R]
        # outputs
        segment_chord_count: wp.array(dtype=int),  # [R + 1]
    ):
        """Count the chords of each segment."""
        segment = first + wp.tid()
        point = 3 * segment
        segment_chord_count[segment] = curve.chord_count(
            points[point], points[point + 1], points[point + 2], points[3 * segment_next[segment]]
        )

    @wp.kernel(module=module)
    def emit_vertices(
        first: int,
        points: wp.array(dtype=vec2),  # [3 R] px
        segment_next: wp.array(dtype=int),  # [R]
        segment_path: wp.array(dtype=int),  # [R]
        segment_first_vertex: wp.array(dtype=int),  # [R + 1]
        # outputs
        vertices: wp.array(dtype=vec2),  # [V] px
        edge_end: wp.array(dtype=int),  # [V] the vertex where the edge of a vertex ends
        edge_path: wp.array(dtype=int),  # [V]
    ):
        """Write the vertices of each segment, and the end and path of the edge of each vertex."""
        segment = first + wp.tid()
        point = 3 * segment
        p0 = points[point]
        p1 = points[point + 1]
        p2 = points[point + 2]
        p3 = points[3 * segment_next[segment]]
        start = segment_first_vertex[segment]
        count = segment_first_vertex[segment + 1] - start
        path = segment_path[segment]
        for j in range(count):
            w = curve.vertex_weights(j, count)
            vertices[start + j] = w[0] * p0 + w[1] * p1 + w[2] * p2 + w[3] * p3
            edge_end[start + j] = start + j + 1
            edge_path[start + j] = path
        if count > 0:
            edge_end[start + count - 1] = segment_first_vertex[segment_next[segment]]

    @wp.kernel(module=module)
    def gather_segments_adjoint(
        first: int,
        segment_first_vertex: wp.array(dtype=int),  # [R + 1]
        adj_edges: wp.array(dtype=vec4),  # [V] dL/d(start), dL/d(end) of each edge
        # outputs
        adj_points: wp.array(dtype=vec2),  # [3 R] of the anchors by the segments that leave them, and of the handles
        adj_ends: wp.array(dtype=vec2),  # [R] of the anchors by the segments that arrive at them
    ):
        """Sum dL/d(points) of one segment. An edge starts and ends on one segment, at t = j / n and t = (j + 1) / n."""
        segment = first + wp.tid()
        start = segment_first_vertex[segment]
        count = segment_first_vertex[segment + 1] - start
        a0 = vec2()
        a1 = vec2()
        a2 = vec2()
        a3 = vec2()
        w = curve.vertex_weights(0, count)
        for j in range(count):
            adj = adj_edges[start + j]
            adj_start = vec2(adj[0], adj[1])
            adj_end = vec2(adj[2], adj[3])
            v = curve.vertex_weights(j + 1, count)
            a0 += w[0] * adj_start + v[0] * adj_end
            a1 += w[1] * adj_start + v[1] * adj_end
            a2 += w[2] * adj_start + v[2] * adj_end
            a3 += w[3] * adj_start + v[3] * adj_end
            w = vec4(v[0], v[1], v[2], v[3])
        adj_points[3 * segment] = a0
        adj_points[3 * segment + 1] = a1
        adj_points[3 * segment + 2] = a2
        adj_ends[segment] = a3

    @wp.kernel(module=module)
    def add_arriving_adjoint(
        first: int,
        segment_previous: wp.array(dtype=int),  # [R]
        adj_ends: wp.array(dtype=vec2),  # [R]
        # in and out
        adj_points: wp.array(dtype=vec2),  # [3 R]
    ):
        """Add to the adjoint of each anchor that of the segment which arrives at it."""
        segment = first + wp.tid()
        adj_points[3 * segment] = adj_points[3 * segment] + adj_ends[segment_previous[segment]]

    return bundle(count_chords, emit_vertices, gather_segments_adjoint, add_arriving_adjoint)
