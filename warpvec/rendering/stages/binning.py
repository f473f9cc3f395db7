"""Host side of stage 2, binning: vertices -> classified (path, tile) pairs and each tile's list of pairs."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import warp as wp

from warpvec.kernels import binning as kernels
from warpvec.kernels import capacity as capacity_kernels
from warpvec.kernels import softening as soft_kernels
from warpvec.kernels.constants import TILE
from warpvec.kernels.lanes import Lanes
from warpvec.rendering.launch import Launcher, check_total, exclusive_scan, read_total
from warpvec.rendering.stages.flattening import Flattening


@dataclass(frozen=True)
class TileGrid:
    """The tiles of a canvas of ``height`` x ``width`` pixels."""

    height: int
    width: int

    @property
    def rows(self) -> int:
        """Number of rows of tiles."""
        return -(-self.height // TILE)

    @property
    def columns(self) -> int:
        """Number of columns of tiles."""
        return -(-self.width // TILE)

    @property
    def count(self) -> int:
        """Number of tiles."""
        return self.rows * self.columns


class Binning:
    """The (path, tile) pairs of a scene; ``kernels/binning.py`` describes the arrays.

    Attributes:
        strip_count, pair_count, slot_count: number of strips, of pairs (K), and of partial pairs, each of which has a
            slot; or the capacities if the counts are not read back.
        hit_pair: [K] pairs sorted by tile, lowest path first; empty pairs last.
        tile_first_hit: [tiles + 1] first hit of each tile.
    """

    strip_count: int
    pair_count: int
    slot_count: int
    _widening: list[Any] | None = None

    def __init__(self, launch: Launcher, lanes: Lanes, grid: TileGrid) -> None:
        self._launch, self._grid, self._lanes = launch, grid, lanes
        self._kernels, self._capacity = kernels.make_kernels(lanes), capacity_kernels.make_kernels(lanes)
        self._needs_strips = lanes.width == 1  # on vector lanes a work item of the later stages is a path
        self._buffers = launch.make_buffers()
        self.tile_first_hit = self._buffers.get("tile_first_hit", grid.count + 1, wp.int32)

    def run(self, flattening: Flattening, path_count: int, path_reach: wp.array | None = None) -> None:
        """Bin the flattened paths, of which soft ones reach ``path_reach`` [N] px farther (int32; 0: a sharp path)."""
        polylines = flattening.polylines
        size = [self._grid.rows, self._grid.columns]
        self._widening = None if path_reach is None else [*polylines, path_reach, *size]
        arrays = self._bound(path_count, self._kernels.bound_paths, [*polylines, *size])
        classify = self._classify_by_edge if self._needs_strips else self._classify_by_path
        classify(flattening, path_count, arrays)
        if path_reach is not None:
            pairs = [arrays[name] for name in ("class", "is_partial", "key")]
            soft = [path_reach, self.path_tile_box, self.path_first_pair, self._grid.columns, *pairs]
            self._launch(soft_kernels.make_kernels(self._lanes).mark_soft_pairs, path_count, soft)
        self._number_slots(arrays["is_partial"])
        self._sort()

    def _classify_by_path(self, flattening: Flattening, path_count: int, arrays: dict[str, wp.array]) -> None:
        vertices, *rows = flattening.polylines
        size = [self._grid.columns, self._grid.count]
        boxes = [self.path_tile_box, self.path_first_pair]
        arguments = [vertices, flattening.edge_end, *rows, *size, *boxes, *arrays.values()]
        self._launch.shared(self._kernels.classify_pairs, path_count, arguments)

    def _classify_by_edge(self, flattening: Flattening, path_count: int, arrays: dict[str, wp.array]) -> None:
        assert flattening.structure is not None
        marks = [arrays["winding"], arrays["is_partial"]]
        marks[0].zero_()
        if self._launch.capacity.limit is None:  # else ``admit_pairs`` has cleared them
            marks[1].zero_()
        edges = [flattening.vertices, flattening.edge_end, flattening.edge_path]
        segments = [flattening.segment_first_vertex, flattening.structure.segment_count]
        arguments = [*edges, *segments, self.path_tile_box, self.path_first_pair, *marks]
        self._launch(self._kernels.mark_pairs, flattening.vertex_count, arguments)
        size = [self._grid.columns, self._grid.count]
        found = [arrays[name] for name in ("path", "class", "key", "index")]
        arguments = [*size, *self._boxes(), *marks, *found]
        self._launch(self._kernels.classify_strips, self.strip_count, arguments)

    def _bound(self, path_count: int, kernel: Any, arguments: list[Any]) -> dict[str, wp.array]:
        """Find the boxes of tiles with ``kernel``, number strips and pairs, and return the arrays of the pairs."""
        get = self._buffers.get
        self.path_tile_box = get("path_tile_box", path_count, wp.vec4i)
        strip_count = get("path_strip_count", path_count + 1, wp.int32)
        pair_count = get("path_pair_count", path_count + 1, wp.int32)
        boxes = [self.path_tile_box, strip_count, pair_count]
        self._launch(kernel, path_count, [*arguments, *boxes])
        if self._widening is not None:
            widen = soft_kernels.make_kernels(self._lanes).bound_soft_paths
            self._launch(widen, path_count, [*self._widening, *boxes])
        is_read = self._launch.capacity.limit is None
        # A strip has at least one pair, so there are no more strips than pairs.
        check_total("path_pair_count", pair_count, path_count, self._grid.count, is_read)
        number = self._number_pairs if is_read else self._admit_pairs
        return number(strip_count, pair_count, path_count)

    def _number_pairs(self, strip_count: wp.array, pair_count: wp.array, path_count: int) -> dict[str, wp.array]:
        self.path_first_strip = exclusive_scan(self._buffers, "path_first_strip", strip_count, path_count)
        self.path_first_pair = exclusive_scan(self._buffers, "path_first_pair", pair_count, path_count)
        self.strip_count = read_total(self.path_first_strip, path_count)
        self.pair_count = read_total(self.path_first_pair, path_count)
        self.strip_path = self._buffers.get("strip_path", self.strip_count, wp.int32)
        if self._needs_strips:
            self._launch(self._kernels.list_strips, path_count, [self.path_first_strip, self.strip_path])
        return self._pair_arrays()

    def _admit_pairs(self, strip_count: wp.array, pair_count: wp.array, path_count: int) -> dict[str, wp.array]:
        capacity, get = self._launch.capacity, self._buffers.get
        assert capacity.limit is not None
        _, self.strip_count, self.pair_count, _ = capacity.limit
        sums = [
            exclusive_scan(self._buffers, "strip_sums", strip_count, path_count),
            exclusive_scan(self._buffers, "pair_sums", pair_count, path_count),
        ]
        self.path_first_strip = get("path_first_strip", path_count + 1, wp.int32)
        self.path_first_pair = get("path_first_pair", path_count + 1, wp.int32)
        self.strip_path = get("strip_path", self.strip_count, wp.int32)
        arrays = self._pair_arrays()
        blank = [arrays[name] for name in ("class", "is_partial", "key", "index")]
        counts = [path_count, self.strip_count, self.pair_count, self._class_count]
        arguments = [*sums, *counts, self._grid.count, *self._boxes(), *blank, capacity.overflow]
        self._launch(self._capacity.admit_pairs, max(*counts) + 1, arguments)
        return arrays

    def _boxes(self) -> list[wp.array]:
        return [self.path_tile_box, self.path_first_strip, self.path_first_pair, self.strip_path]

    def _pair_arrays(self) -> dict[str, wp.array]:
        count = self.pair_count
        # The sort needs scratch space of the same size behind its keys and values.
        sizes = {"path": count, "class": self._class_count, "winding": count, "is_partial": count + 1}
        sizes |= {"key": 2 * count, "index": 2 * count}
        arrays = {name: self._buffers.get(f"pair_{name}", size, wp.int32) for name, size in sizes.items()}
        self.pair_path, self.pair_class = arrays["path"], arrays["class"]
        self.hit_tile, self.hit_pair = arrays["key"], arrays["index"]
        return arrays

    @property
    def _class_count(self) -> int:
        return max(self.pair_count, self._grid.columns)

    def _number_slots(self, pair_is_partial: wp.array) -> None:
        capacity, count = self._launch.capacity, self.pair_count
        if capacity.limit is None:
            self.pair_slot = exclusive_scan(self._buffers, "pair_slot", pair_is_partial, count)
            self.slot_count = read_total(self.pair_slot, count)
            return
        sums = exclusive_scan(self._buffers, "slot_sums", pair_is_partial, count)
        self.pair_slot = self._buffers.get("pair_slot", count + 1, wp.int32)
        self.slot_count = capacity.limit.slots
        pairs = [self.pair_class, self.hit_tile, self.pair_slot]
        arguments = [sums, count, self.slot_count, self._grid.count, *pairs, capacity.overflow]
        self._launch(self._capacity.admit_slots, count + 1, arguments)

    def _sort(self) -> None:
        key_bits = self._grid.count.bit_length()
        wp.utils.radix_sort_pairs(self.hit_tile, self.hit_pair, self.pair_count, end_bit=key_bits)
        arguments = [self.hit_tile, self.pair_count, self._grid.count, self.tile_first_hit]
        self._launch(self._kernels.find_tile_ranges, self.pair_count + 1, arguments)
