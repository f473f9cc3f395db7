"""Host side of stage 3, coverage: the winding of every pixel of the partial pairs, and the adjoint."""

from __future__ import annotations

import warp as wp

from warpvec.kernels import coverage as kernels
from warpvec.kernels import coverage_adjoint as adjoint_kernels
from warpvec.kernels.constants import COLUMNS, TILE
from warpvec.kernels.lanes import Lanes
from warpvec.rendering.launch import Launcher
from warpvec.rendering.stages.binning import Binning
from warpvec.rendering.stages.flattening import Flattening


class Coverage:
    """The windings of the partial pairs.

    Attributes:
        slot_winding: [slots, COLUMNS, TILE] as lane values; the compositing adjoint overwrites it with dL/d(winding).
    """

    slot_winding: wp.array

    def __init__(self, launch: Launcher, lanes: Lanes) -> None:
        self._launch, self._lanes = launch, lanes
        self._adjoint = adjoint_kernels.make_kernels(lanes)
        self._buffers = launch.make_buffers()

    def run(self, flattening: Flattening, binning: Binning) -> None:
        """Fill ``slot_winding``."""
        lanes, value_count = self._lanes, binning.slot_count * COLUMNS * self._lanes.blocks
        is_by_path = lanes.width > 1
        size = value_count + binning.strip_count * is_by_path
        self.slot_winding = self._buffers.get("slot_winding", size, lanes.vector)
        boxes = [binning.path_tile_box, binning.path_first_strip, binning.path_first_pair]
        if is_by_path:
            pairs, item_count = [*boxes, binning.pair_slot, binning.slot_count], flattening.path_count
        else:
            pairs, item_count = [*boxes[::2], binning.pair_path, binning.pair_slot], binning.pair_count * TILE
        vertices, *rows = flattening.polylines
        arguments = [vertices, flattening.edge_end, *rows, *pairs, self.slot_winding]
        kernel = kernels.make_kernels(self._lanes, flattening.has_strokes and not is_by_path).accumulate_winding
        self._launch.shared(kernel, item_count, arguments)

    def adjoint(self, flattening: Flattening, binning: Binning, segment_count: int) -> wp.array:
        """Return dL/d(start), dL/d(end) of every edge [V] of vec4; ``slot_winding`` must hold dL/d(winding)."""
        adj_edges = self._buffers.get("adj_edges", flattening.vertex_count, self._lanes.vec4)
        rows = [flattening.edge_end, flattening.edge_path, flattening.segment_first_vertex, segment_count]
        pairs = [binning.path_tile_box, binning.path_first_pair, binning.pair_class, binning.pair_slot]
        arguments = [flattening.vertices, *rows, *pairs, self.slot_winding, adj_edges]
        groups = -(-flattening.vertex_count // self._lanes.width)
        self._launch.shared(self._adjoint.integrate_edges, groups, arguments)
        return adj_edges
