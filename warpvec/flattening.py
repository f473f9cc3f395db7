"""Host side of stage 1, flattening: control points -> vertices, and back."""

from __future__ import annotations

import warp as wp

from warpvec.kernels import flattening as kernels
from warpvec.kernels.lanes import Lanes
from warpvec.launch import Buffers, Launcher, exclusive_scan


class Flattening:
    """The vertices of a scene's paths.

    Attributes:
        vertices: [V] px.
        segment_first_vertex: [N S + 1], where each segment's vertices begin.
        vertex_count: V.
    """

    vertices: wp.array
    segment_first_vertex: wp.array
    vertex_count: int

    def __init__(self, launch: Launcher, lanes: Lanes) -> None:
        self._launch, self._lanes = launch, lanes
        self._kernels = kernels.make_kernels(lanes)
        self._buffers = Buffers(launch.device)

    def run(self, points: wp.array) -> None:
        """Flatten ``points`` [N, 3 S] of vec2."""
        path_count, segment_count = points.shape[0], points.shape[1] // 3
        total = path_count * segment_count
        chord_count = self._buffers.get("segment_chord_count", total + 1, wp.int32)
        self._launch(self._kernels.count_chords, total, [points, segment_count, chord_count])
        self.segment_first_vertex, self.vertex_count = exclusive_scan(
            self._buffers, "segment_first_vertex", chord_count, total
        )
        self.vertices = self._buffers.get("vertices", self.vertex_count, self._lanes.vec2)
        arguments = [points, self.segment_first_vertex, segment_count, self.vertices]
        self._launch(self._kernels.emit_vertices, total, arguments)

    def adjoint(self, adj_edges: wp.array, adj_points: wp.array) -> None:
        """``adj_edges`` [V] of vec4 -> ``adj_points`` [N, 3 S] of vec2, overwritten."""
        path_count, segment_count = adj_points.shape[0], adj_points.shape[1] // 3
        arguments = [self.segment_first_vertex, adj_edges, segment_count, adj_points]
        self._launch(self._kernels.gather_points_adjoint, path_count, arguments)
