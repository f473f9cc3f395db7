"""Host side of ``kernels/pixel_slopes.py``: how pixels change with the paints and the windings of the paths."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import warp as wp
from numpy.typing import NDArray

from warpvec.kernels import pixel_slopes as kernels
from warpvec.kernels.constants import PARTIAL, TILE
from warpvec.kernels.lanes import Lanes
from warpvec.kernels.pixel_slopes import SLOPE_PLANES
from warpvec.rendering.launch import Launcher
from warpvec.rendering.stages.binning import Binning, TileGrid
from warpvec.rendering.stages.compositing import Paint, hits_of, tile_ranges

HITS_AT_ONCE = 2**14
"""Hits whose derivatives are held at a time, if no tile has more: 80 MB."""


class HitSlopes(NamedTuple):
    """Derivatives in some tiles, tile by tile; a hit is a path in a tile. The next part overwrites the memory.

    Attributes:
        tiles: the first tile, and the one after the last.
        tile, path: of each hit [H], sorted by tile and then by path.
        slot: where ``slot_winding`` has the windings of a partial hit [H].
        is_partial: whether an edge of the path lies in the tile [H].
        share: derivative of the pixels by the colour of the path [H, TILE TILE], column by column, 0 outside of the
            canvas.
        slopes: derivative by the winding of the path [H, 4, TILE TILE], of red, green, blue and transmittance. Only
            partial hits have these.
    """

    tiles: tuple[int, int]
    tile: NDArray[np.int64]
    path: NDArray[np.int64]
    slot: NDArray[np.int64]
    is_partial: NDArray[np.bool_]
    share: NDArray[np.float32]
    slopes: NDArray[np.float32]


class PixelSlopes:
    """The derivatives of the pixels of a canvas."""

    def __init__(self, launch: Launcher, lanes: Lanes, grid: TileGrid) -> None:
        self._launch, self._lanes, self._grid = launch, lanes, grid
        self._buffers = launch.make_buffers()

    def run(
        self, binning: Binning, tile_first_visible: wp.array, slot_winding: wp.array, paint: Paint
    ) -> Iterator[HitSlopes]:
        """Yield the derivatives of the tiles in order, for at most `HITS_AT_ONCE` hits at a time."""
        lanes, grid = self._lanes, self._grid
        kernel = kernels.make_kernels(lanes, *paint.variant).derive_pixels
        first_hit = binning.tile_first_hit.numpy()[: grid.count + 1].astype(np.int64)
        hit_pair = binning.hit_pair.numpy()[: first_hit[-1]]
        tile = binning.hit_tile.numpy()[: first_hit[-1]].astype(np.int64)
        path = binning.pair_path.numpy()[hit_pair].astype(np.int64)
        slot = binning.pair_slot.numpy()[hit_pair].astype(np.int64)
        is_partial = binning.pair_class.numpy()[hit_pair] == PARTIAL
        inputs = [
            *hits_of(binning, tile_first_visible),
            slot_winding,
            *paint.arrays,
            *paint.gradients,
            *paint.stop_arrays,
        ]
        inputs += [grid.columns, grid.height, grid.width]
        vectors = lanes.tile_vectors * lanes.tile_threads
        most = max(HITS_AT_ONCE, int(np.diff(first_hit).max()))
        for part in tile_ranges(first_hit, most):
            start, end = int(first_hit[part.start]), int(first_hit[part.end])
            size = max(end - start, 1) * vectors
            outputs = [
                self._buffers.get("hit_share", size, lanes.vector),
                self._buffers.get("hit_slopes", size * SLOPE_PLANES, lanes.vector),
            ]
            threads = lanes.tile_threads
            count = part.end - part.start
            chunk = self._launch.chunk_items(count) * threads
            self._launch.shared(kernel, count * threads, [*inputs, start, *outputs], chunk, part.start * threads)
            share, slopes = (array.numpy().reshape(-1) for array in outputs)
            own, pixel_count = slice(start, end), (end - start) * TILE * TILE
            yield HitSlopes(
                (part.start, part.end), tile[own], path[own], slot[own], is_partial[own],
                share[:pixel_count].reshape(-1, TILE * TILE),
                slopes[: SLOPE_PLANES * pixel_count].reshape(-1, SLOPE_PLANES, TILE * TILE),
            )  # fmt: skip
