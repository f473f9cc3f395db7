"""Stage 1, flattening: control points -> vertices of closed polylines, and the adjoint.

Vertex j of n in a segment is the segment's point at t = j / n, moved out slightly so that the polygon has the curve's
area (``bezier.vertex_weights``). A path stores the vertices of its segments one after another. The edge of vertex v
runs to the path's next vertex.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warpvec.kernels import bezier
from warpvec.kernels.lanes import Lanes, stage_module


@cache
def make_kernels(lanes: Lanes) -> SimpleNamespace:
    """Return ``count_chords``, ``emit_vertices`` and ``gather_points_adjoint``."""
    vec2, vec4 = lanes.vec2, lanes.vec4
    functions = bezier.make_functions(lanes)
    vertex_weights, chord_count = functions.vertex_weights, functions.chord_count
    module = stage_module("flattening", lanes)

    @wp.kernel(module=module)
    def count_chords(
        first: int,
        points: wp.array2d(dtype=vec2),  # [N, 3 S] px
        segment_count: int,  # S
        # outputs
        segment_chord_count: wp.array(dtype=int),  # [N S + 1]
    ):
        """Count the chords of each segment."""
        segment = first + wp.tid()
        path = segment // segment_count
        point = (segment % segment_count) * 3
        last = (point + 3) % (3 * segment_count)
        segment_chord_count[segment] = chord_count(
            points[path, point], points[path, point + 1], points[path, point + 2], points[path, last]
        )

    @wp.kernel(module=module)
    def emit_vertices(
        first: int,
        points: wp.array2d(dtype=vec2),  # [N, 3 S] px
        segment_first_vertex: wp.array(dtype=int),  # [N S + 1]
        segment_count: int,  # S
        # outputs
        vertices: wp.array(dtype=vec2),  # [V] px
    ):
        """Write the vertices of each segment."""
        segment = first + wp.tid()
        path = segment // segment_count
        point = (segment % segment_count) * 3
        p0 = points[path, point]
        p1 = points[path, point + 1]
        p2 = points[path, point + 2]
        p3 = points[path, (point + 3) % (3 * segment_count)]
        start = segment_first_vertex[segment]
        count = segment_first_vertex[segment + 1] - start
        for j in range(count):
            w = vertex_weights(j, count)
            vertices[start + j] = w[0] * p0 + w[1] * p1 + w[2] * p2 + w[3] * p3

    @wp.kernel(module=module)
    def gather_points_adjoint(
        first: int,
        segment_first_vertex: wp.array(dtype=int),  # [N S + 1]
        adj_edges: wp.array(dtype=vec4),  # [V] dL/d(start), dL/d(end) of each edge
        segment_count: int,  # S
        # outputs
        adj_points: wp.array2d(dtype=vec2),  # [N, 3 S]
    ):
        """Sum dL/d(points) of one path. An edge starts and ends on one segment, at t = j / n and t = (j + 1) / n."""
        path = first + wp.tid()
        for s in range(segment_count):
            adj_points[path, 3 * s] = vec2()
        for s in range(segment_count):
            start = segment_first_vertex[path * segment_count + s]
            count = segment_first_vertex[path * segment_count + s + 1] - start
            a0 = vec2()
            a1 = vec2()
            a2 = vec2()
            a3 = vec2()
            for j in range(count):
                adj = adj_edges[start + j]
                adj_start = vec2(adj[0], adj[1])
                adj_end = vec2(adj[2], adj[3])
                w = vertex_weights(j, count)
                v = vertex_weights(j + 1, count)
                a0 += w[0] * adj_start + v[0] * adj_end
                a1 += w[1] * adj_start + v[1] * adj_end
                a2 += w[2] * adj_start + v[2] * adj_end
                a3 += w[3] * adj_start + v[3] * adj_end
            following = (3 * s + 3) % (3 * segment_count)
            adj_points[path, 3 * s] = adj_points[path, 3 * s] + a0
            adj_points[path, 3 * s + 1] = a1
            adj_points[path, 3 * s + 2] = a2
            adj_points[path, following] = adj_points[path, following] + a3

    return SimpleNamespace(
        count_chords=count_chords, emit_vertices=emit_vertices, gather_points_adjoint=gather_points_adjoint
    )
