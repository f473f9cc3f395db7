"""Host side of stage 1 for strokes: centre lines and widths -> vertices of outlines, and the adjoint."""

from __future__ import annotations

from typing import Any

import warp as wp
from torch import Tensor

from warpvec.geometry.strokes import Strokes, roles_of
from warpvec.geometry.structure import Structure
from warpvec.kernels import stroking as kernels
from warpvec.kernels import stroking_adjoint as adjoint_kernels
from warpvec.kernels.lanes import Lanes
from warpvec.rendering.launch import Launcher, as_warp


class Stroking:
    """The rows of strokes, which `warpvec.rendering.stages.flattening.Flattening` leaves to this stage.

    ``begin`` takes a scene's strokes; the other methods take the arrays of the flattening.
    """

    def __init__(self, launch: Launcher, lanes: Lanes) -> None:
        self._launch, self._lanes = launch, lanes
        self._kernels, self._adjoint = kernels.make_kernels(lanes), adjoint_kernels.make_kernels(lanes)
        self._buffers = launch.make_buffers()

    def begin(self, points: wp.array, structure: Structure, strokes: Strokes) -> None:
        """Take the control ``points`` [3 R] and the ``strokes`` of a scene."""
        strokes.check_kinds()
        self._row_count, self._points = structure.segment_count, points
        names = ("segment_next", "segment_previous", "segment_path")
        rows = [as_warp(getattr(structure, name), wp.int32) for name in names]
        self._rows: list[Any] = [*rows, as_warp(roles_of(strokes, structure), wp.int32)]
        self._loops = [as_warp(first, wp.int32) for first in (structure.loop_first_segment, structure.path_first_loop)]
        self._width = as_warp(strokes.width, self._lanes.dtype)
        kinds = [as_warp(kind, wp.int32) for kind in (strokes.cap, strokes.join)]
        self._looks = [*kinds, as_warp(strokes.miter_limit, self._lanes.dtype)]
        self._plan = self._buffers.get("node_plan", self._row_count, wp.vec4i)

    def count(self, segment_vertex_count: wp.array) -> None:
        """Replace the numbers of vertices of the rows of strokes."""
        arguments = [self._points, *self._rows, self._width, *self._looks, segment_vertex_count, self._plan]
        self._launch(self._kernels.count_vertices, self._row_count, arguments)

    def emit(self, segment_first_vertex: wp.array, vertices: wp.array, edge_end: wp.array, edge_path: wp.array) -> None:
        """Overwrite the vertices of the rows of strokes, and their edges."""
        inputs = [self._points, *self._rows, self._width, self._plan, segment_first_vertex]
        self._launch(self._kernels.emit_vertices, self._row_count, [*inputs, vertices, edge_end, edge_path])

    def adjoint(
        self,
        segment_first_vertex: wp.array,
        edge_end: wp.array,
        vertex_count: int,
        adj_edges: wp.array,
        adj_points: wp.array,
        adj_ends: wp.array,
    ) -> None:
        """Overwrite the adjoints of the rows of strokes: of their points, and of their ends."""
        landing = self._buffers.get("adj_landing", vertex_count, self._lanes.vec2)
        edges = [edge_end, segment_first_vertex, self._row_count, adj_edges, landing]
        self._launch(self._adjoint.land_edges, vertex_count, edges)
        self._adj_radius = self._buffers.get("adj_radius", self._row_count, self._lanes.dtype)
        inputs = [self._points, *self._rows, self._width, self._plan, segment_first_vertex, adj_edges, landing]
        outputs = [adj_points, adj_ends, self._adj_radius]
        self._launch.shared(self._adjoint.gather_rows_adjoint, self._row_count, [*inputs, *outputs])

    def widths_adjoint(self, adj_width: Tensor) -> None:
        """Overwrite ``adj_width`` [N] with the adjoint of the widths; `adjoint` must have run."""
        arguments = [*self._loops, self._adj_radius, as_warp(adj_width, self._lanes.dtype)]
        self._launch(self._adjoint.gather_widths_adjoint, len(adj_width), arguments)
