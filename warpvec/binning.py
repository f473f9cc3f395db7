"""Host side of stage 2, binning: vertices -> classified (path, tile) pairs and each tile's list of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import warp as wp

from warpvec.flattening import Flattening
from warpvec.kernels import binning as kernels
from warpvec.kernels.constants import TILE
from warpvec.kernels.lanes import Lanes
from warpvec.launch import Buffers, Launcher, exclusive_scan


@dataclass(frozen=True)
class TileGrid:
    """The tiles of a canvas of ``height`` x ``width`` pixels."""

    height: int
    width: int

    @property
    def rows(self) -> int:
        return -(-self.height // TILE)

    @property
    def columns(self) -> int:
        return -(-self.width // TILE)

    @property
    def count(self) -> int:
        return self.rows * self.columns


class Binning:
    """The (path, tile) pairs of a scene; arrays are as ``kernels/binning.py`` says.

    Attributes:
        strip_count, pair_count, slot_count: strips, K pairs, and partial pairs, each of which has a coverage slot.
        hit_pair: [K] pairs sorted by tile, lowest path first; empty pairs last.
        tile_first_hit: [tiles + 1].
    """

    strip_count: int
    pair_count: int
    slot_count: int

    def __init__(self, launch: Launcher, lanes: Lanes, grid: TileGrid) -> None:
        self._launch, self._grid = launch, grid
        self._kernels = kernels.make_kernels(lanes)
        self._buffers = Buffers(launch.device)
        self.tile_first_hit = self._buffers.get("tile_first_hit", grid.count + 1, wp.int32)

    def run(self, flattening: Flattening, path_count: int, segment_count: int) -> None:
        """Bin the flattened paths."""
        polylines = [flattening.vertices, flattening.segment_first_vertex, segment_count]
        self._bound(path_count, self._kernels.bound_paths, [*polylines, self._grid.rows, self._grid.columns])
        arrays = self._pair_arrays()
        arguments = [*polylines, self._grid.columns, self._grid.count, *self._boxes(), *arrays.values()]
        self._launch.shared(self._kernels.classify_pairs, self.strip_count, arguments)
        self._number_slots(arrays["is_partial"])
        self._sort()

    def _bound(self, path_count: int, kernel: Any, arguments: list[Any]) -> None:
        """Boxes of tiles by ``kernel``, and the numbers of their strips and pairs."""
        get = self._buffers.get
        self.path_tile_box = get("path_tile_box", path_count, wp.vec4i)
        strip_count = get("path_strip_count", path_count + 1, wp.int32)
        pair_count = get("path_pair_count", path_count + 1, wp.int32)
        self._launch(kernel, path_count, [*arguments, self.path_tile_box, strip_count, pair_count])
        self.path_first_strip, self.strip_count = exclusive_scan(
            self._buffers, "path_first_strip", strip_count, path_count
        )
        self.path_first_pair, self.pair_count = exclusive_scan(self._buffers, "path_first_pair", pair_count, path_count)
        self.strip_path = get("strip_path", self.strip_count, wp.int32)
        self._launch(self._kernels.list_strips, path_count, [self.path_first_strip, self.strip_path])

    def _boxes(self) -> list[wp.array]:
        return [self.path_tile_box, self.path_first_strip, self.path_first_pair, self.strip_path]

    def _pair_arrays(self) -> dict[str, wp.array]:
        # The sort needs a second half of the same size behind its keys and values.
        lengths = {"path": 1, "class": 1, "winding": 1, "is_partial": 1, "key": 2, "index": 2}
        get = self._buffers.get
        arrays = {name: get(f"pair_{name}", n * self.pair_count + 1, wp.int32) for name, n in lengths.items()}
        self.pair_path, self.pair_class = arrays["path"], arrays["class"]
        self.hit_tile, self.hit_pair = arrays["key"], arrays["index"]
        return arrays

    def _number_slots(self, pair_is_partial: wp.array) -> None:
        self.pair_slot, self.slot_count = exclusive_scan(self._buffers, "pair_slot", pair_is_partial, self.pair_count)

    def _sort(self) -> None:
        key_bits = self._grid.count.bit_length()
        wp.utils.radix_sort_pairs(self.hit_tile, self.hit_pair, self.pair_count, end_bit=key_bits)
        arguments = [self.hit_tile, self.pair_count, self._grid.count, self.tile_first_hit]
        self._launch(self._kernels.find_tile_ranges, self.pair_count + 1, arguments)
