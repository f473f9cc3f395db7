"""Host side of stage 1, flattening: segments -> vertices, and the adjoint."""

from __future__ import annotations

import warp as wp
from torch import Tensor

from warpvec.geometry.strokes import Strokes
from warpvec.geometry.structure import Structure
from warpvec.kernels import capacity as capacity_kernels
from warpvec.kernels import flattening as kernels
from warpvec.kernels.constants import SEGMENT_CHORDS_MAX
from warpvec.kernels.lanes import Lanes
from warpvec.kernels.stroking import ROW_VERTICES_MAX
from warpvec.rendering.launch import Launcher, as_warp, check_total, exclusive_scan, read_total
from warpvec.rendering.stages.stroking import Stroking


class Flattening:
    """The vertices of a scene's paths. Those of strokes are made by `warpvec.rendering.stages.stroking.Stroking`.

    Attributes:
        vertices: [V] px.
        segment_first_vertex: [R + 1], index of each segment's first vertex.
        vertex_count: V, or the capacity if V is not read back.
        structure: that of the flattened segments; the arrays below are its arrays, as Warp arrays.
        has_strokes: whether the edges of a loop are not in the order of its vertices.
    """

    vertices: wp.array
    segment_first_vertex: wp.array
    vertex_count: int
    structure: Structure | None = None
    has_strokes = False
    loop_first_segment: wp.array
    path_first_loop: wp.array
    segment_path: wp.array
    segment_next: wp.array
    segment_previous: wp.array

    def __init__(self, launch: Launcher, lanes: Lanes) -> None:
        self._launch, self._lanes = launch, lanes
        self._kernels = kernels.make_kernels(lanes)
        self._buffers = launch.make_buffers()
        self._stroking: Stroking | None = None

    def run(self, segments: Tensor, structure: Structure, strokes: Strokes | None = None) -> None:
        """Flatten ``segments`` [R, 3, 2] px, of which ``strokes`` tells the stroked paths."""
        self._follow(structure)
        total, points = structure.segment_count, self._buffers.view("segments", segments, self._lanes.vec2, -1, 2)
        chord_count = self._buffers.get("segment_chord_count", total + 1, wp.int32)
        self._launch(self._kernels.count_chords, total, [points, self.segment_next, chord_count])
        self.has_strokes = strokes is not None
        if strokes is not None:
            self._stroking = self._stroking or Stroking(self._launch, self._lanes)
            self._stroking.begin(points, structure, strokes)
            self._stroking.count(chord_count)
        self._number_vertices(chord_count, total)
        self.vertices = self._buffers.get("vertices", self.vertex_count, self._lanes.vec2)
        self.edge_end = self._buffers.get("edge_end", self.vertex_count, wp.int32)
        self.edge_path = self._buffers.get("edge_path", self.vertex_count, wp.int32)
        rows = [self.segment_next, self.segment_path, self.segment_first_vertex]
        arguments = [points, *rows, self.vertices, self.edge_end, self.edge_path]
        self._launch(self._kernels.emit_vertices, total, arguments)
        if self.has_strokes:
            assert self._stroking is not None
            self._stroking.emit(self.segment_first_vertex, self.vertices, self.edge_end, self.edge_path)

    @property
    def path_count(self) -> int:
        """Number of paths of the structure."""
        assert self.structure is not None
        return len(self.structure.path_first_loop) - 1

    @property
    def polylines(self) -> list[wp.array]:
        """Vertices, and the first vertex of each segment, segment of each loop, and loop of each path."""
        return [self.vertices, self.segment_first_vertex, self.loop_first_segment, self.path_first_loop]

    def _follow(self, structure: Structure) -> None:
        """Take the arrays of ``structure``, unless they are the present ones."""
        if structure is self.structure:
            return
        self.structure = structure
        names = ("loop_first_segment", "path_first_loop", "segment_path", "segment_next", "segment_previous")
        for name in names:
            setattr(self, name, as_warp(getattr(structure, name), wp.int32, whole=True))

    def _number_vertices(self, chord_count: wp.array, total: int) -> None:
        limit = self._launch.capacity.limit
        row_max = ROW_VERTICES_MAX if self.has_strokes else SEGMENT_CHORDS_MAX
        check_total("vertices", chord_count, total, row_max, limit is None)
        if limit is None:
            self.segment_first_vertex = exclusive_scan(self._buffers, "segment_first_vertex", chord_count, total)
            self.vertex_count = read_total(self.segment_first_vertex, total)
            return
        sums = exclusive_scan(self._buffers, "segment_sums", chord_count, total)
        self.segment_first_vertex = self._buffers.get("segment_first_vertex", total + 1, wp.int32)
        self.vertex_count = limit.vertices
        arguments = [sums, total, limit.vertices, self.segment_first_vertex, self._launch.capacity.overflow]
        self._launch(capacity_kernels.make_kernels(self._lanes).admit_vertices, total + 1, arguments)

    def adjoint(self, adj_edges: wp.array, adj_segments: Tensor) -> None:
        """Overwrite ``adj_segments`` [R, 3, 2] with the adjoint for ``adj_edges`` [V] of vec4."""
        total = len(adj_segments)
        adj_points = self._buffers.view("adj_segments", adj_segments, self._lanes.vec2, -1, 2)
        adj_ends = self._buffers.get("adj_ends", total, self._lanes.vec2)
        arguments = [self.segment_first_vertex, adj_edges, adj_points, adj_ends]
        self._launch.shared(self._kernels.gather_segments_adjoint, total, arguments)
        if self.has_strokes:
            assert self._stroking is not None
            self._stroking.adjoint(
                self.segment_first_vertex, self.edge_end, self.vertex_count, adj_edges, adj_points, adj_ends
            )
        self._launch(self._kernels.add_arriving_adjoint, total, [self.segment_previous, adj_ends, adj_points])

    def widths_adjoint(self, adj_width: Tensor) -> None:
        """Overwrite ``adj_width`` [N] with the adjoint of the widths of strokes; `adjoint` must have run."""
        assert self._stroking is not None
        self._stroking.widths_adjoint(adj_width)
