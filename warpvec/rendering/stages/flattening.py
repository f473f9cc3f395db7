"""Host side of stage 1, flattening: control points -> vertices, and the adjoint."""

from __future__ import annotations

import warp as wp

from warpvec.kernels import capacity as capacity_kernels
from warpvec.kernels import flattening as kernels
from warpvec.kernels.constants import SEGMENT_CHORDS_MAX
from warpvec.kernels.lanes import Lanes
from warpvec.rendering.launch import Launcher, check_total, exclusive_scan, read_total


class Flattening:
    """The vertices of a scene's paths.

    Attributes:
        vertices: [V] px.
        segment_first_vertex: [N S + 1], index of each segment's first vertex.
        vertex_count: V, or the capacity if V is not read back.
    """

    vertices: wp.array
    segment_first_vertex: wp.array
    vertex_count: int

    def __init__(self, launch: Launcher, lanes: Lanes) -> None:
        self._launch, self._lanes = launch, lanes
        self._kernels = kernels.make_kernels(lanes)
        self._buffers = launch.make_buffers()

    def run(self, points: wp.array) -> None:
        """Flatten ``points`` [N, 3 S] of vec2."""
        path_count, segment_count = points.shape[0], points.shape[1] // 3
        total = path_count * segment_count
        chord_count = self._buffers.get("segment_chord_count", total + 1, wp.int32)
        self._launch(self._kernels.count_chords, total, [points, segment_count, chord_count])
        self._number_vertices(chord_count, total)
        self.vertices = self._buffers.get("vertices", self.vertex_count, self._lanes.vec2)
        arguments = [points, self.segment_first_vertex, segment_count, self.vertices]
        self._launch(self._kernels.emit_vertices, total, arguments)

    def _number_vertices(self, chord_count: wp.array, total: int) -> None:
        limit = self._launch.capacity.limit
        check_total("vertices", chord_count, total, SEGMENT_CHORDS_MAX, limit is None)
        if limit is None:
            self.segment_first_vertex = exclusive_scan(self._buffers, "segment_first_vertex", chord_count, total)
            self.vertex_count = read_total(self.segment_first_vertex, total)
            return
        sums = exclusive_scan(self._buffers, "segment_sums", chord_count, total)
        self.segment_first_vertex = self._buffers.get("segment_first_vertex", total + 1, wp.int32)
        self.vertex_count = limit.vertices
        arguments = [sums, total, limit.vertices, self.segment_first_vertex, self._launch.capacity.overflow]
        self._launch(capacity_kernels.make_kernels(self._lanes).admit_vertices, total + 1, arguments)

    def adjoint(self, adj_edges: wp.array, adj_points: wp.array) -> None:
        """Overwrite ``adj_points`` [N, 3 S] of vec2 with the adjoint for ``adj_edges`` [V] of vec4."""
        path_count, segment_count = adj_points.shape[0], adj_points.shape[1] // 3
        arguments = [self.segment_first_vertex, adj_edges, segment_count, adj_points]
        self._launch.shared(self._kernels.gather_points_adjoint, path_count, arguments)
