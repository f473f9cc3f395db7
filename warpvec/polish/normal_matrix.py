"""The host side of ``kernels/normal_matrix.py``: products of derivatives of pixels, as blocks and as a matrix."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
import warp as wp
from numpy.typing import NDArray
from scipy import sparse

from warpvec.geometry.scene import Scene
from warpvec.geometry.strokes import BUTT, roles_of
from warpvec.kernels.constants import TILE
from warpvec.kernels.crossed_pixels import ENTRIES, LEFT_OUT, PIXELS, vec9
from warpvec.kernels.normal_matrix import COLOR_PAIRS, ROW_COLORS, ROW_PAIRS, TRIPLES
from warpvec.kernels.pixel_weights import vec4
from warpvec.polish.curve_rows import RowSlopes
from warpvec.polish.machine import machine_of_thread, on_host
from warpvec.rendering.launch import as_warp
from warpvec.rendering.stages.pixel_slopes import HitSlopes

TILE_PIXELS = TILE * TILE
"""Pixels of a tile."""


class NormalMatrix:
    """Sums the products of derivatives over the pixels that outlines cross. Add all tiles, then ask for the matrix.

    Args:
        scene: the drawing, on the CPU.
        size: height and width of the canvas.
        is_free: paths whose outlines count [N]; None for all.
        matte_scale: see `warpvec.fit.target.Target.matte_scale`.
        value_count: number of values of the paints.
        is_flat: whether all paints are flat; their derivatives are then known.

    Attributes:
        pixels: the crossed pixels [P], in ascending order: ``TILE_PIXELS`` times the tile plus the place in it, which
            is counted column by column.
    """

    def __init__(
        self,
        scene: Scene,
        size: tuple[int, int],
        is_free: NDArray[np.bool_] | None,
        matte_scale: float,
        value_count: int,
        is_flat: bool,
    ) -> None:
        self._machine = machine_of_thread()
        self._scene, self._size, self._matte_scale, self._is_flat = scene, size, matte_scale, is_flat
        self._columns = -(-size[1] // TILE)
        self._row_count, self._path_count = scene.structure.segment_count, len(scene)
        self._group_count = -(-value_count // 3)
        self._first_paint = 6 * self._row_count
        structure = scene.structure
        names = ("segment_next", "segment_previous", "segment_path")
        self._rows = [as_warp(getattr(structure, name), wp.int32) for name in names]
        self._cross(is_free)
        self._squares = np.zeros(self._path_count + 1)
        self._begin_shares()

    def _cross(self, is_free: NDArray[np.bool_] | None) -> None:
        machine, scene, (height, width) = self._machine, self._scene, self._size
        path = scene.structure.segment_path.long()
        kind = torch.zeros(len(path), dtype=torch.int32)
        widths, is_round = torch.zeros(1), torch.zeros(1, dtype=torch.int32)
        if scene.strokes is not None:
            kind = roles_of(scene.strokes, scene.structure)
            widths, is_round = scene.strokes.width.float(), (scene.strokes.cap != BUTT).int()
        if is_free is not None:
            kind = torch.where(torch.from_numpy(is_free)[path], kind, LEFT_OUT).int()
        points = as_warp(scene.segments.float().reshape(-1, 2), wp.vec2f)
        strokes = [as_warp(kind, wp.int32), as_warp(widths, wp.float32), as_warp(is_round, wp.int32)]
        canvas = wp.vec3i(self._columns, width, height)
        counts = np.zeros(2, np.int32)
        self._pixel_entry = machine.pixel_entry(self._columns * -(-height // TILE) * TILE_PIXELS)
        while True:
            room = machine.entry_room
            shapes = {"entry_row": wp.int32, "entry_pixel": wp.int32, "entry_next": wp.int32, "entry_slopes": vec9}
            arrays = {name: machine.get(name, room, dtype) for name, dtype in shapes.items()}
            pixels = machine.get("pixels", room, wp.int32)
            counts[:] = 0
            outputs = [*arrays.values(), self._pixel_entry, pixels, on_host(counts)]
            machine.run("cross_pixels", [self._row_count, points, *self._rows, *strokes, canvas, *outputs])
            if counts[ENTRIES] <= arrays["entry_row"].shape[0]:
                break
            machine.entry_room = 2 * arrays["entry_row"].shape[0]
            self._pixel_entry.fill_(-1)
        self._entries, self._entry_count, self._pixels = arrays, int(counts[ENTRIES]), pixels
        self.pixels = pixels.numpy()[: counts[PIXELS]]
        self.pixels.sort()

    @property
    def entries(self) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
        """The row [M] of each pair of a curve and a pixel, and the change of the winding with its values [M, 9]."""
        row, slopes = (self._entries[name].numpy()[: self._entry_count] for name in ("entry_row", "entry_slopes"))
        return row, slopes

    def _begin_shares(self) -> None:
        get, count = self._machine.get, len(self.pixels)
        self._planes = get("entry_planes", max(self._entry_count, 1), vec4)
        self._share_bounds = get("share_bounds", count + 1, wp.int32)
        self._share_bounds.numpy()[0] = 0
        self._open = get("pixel_open", max(count, 1), wp.float64)
        self._share_count = 0
        self._shares = [get("share_path", 1, wp.int32), get("share_value", 1, wp.float64)]

    def add(self, part: HitSlopes) -> None:
        """Add the derivatives in some more tiles."""
        machine, (begin, end) = self._machine, np.searchsorted(self.pixels, TILE_PIXELS * np.array(part.tiles)).tolist()
        tile_hit = np.searchsorted(part.tile, np.arange(part.tiles[0], part.tiles[1] + 1)).astype(np.int32)
        per_tile = np.diff(tile_hit)[self.pixels[begin:end] // TILE_PIXELS - part.tiles[0]]
        self._make_room(int(per_tile.sum()))
        hits = [on_host(part.path.astype(np.int32)), on_host(part.is_partial.view(np.uint8))]
        shares = [on_host(part.share.reshape(-1)), on_host(part.slopes.reshape(-1))]
        squares = on_host(self._squares)
        entries = self._entries
        into = [self._planes, self._share_bounds, *self._shares, self._open, squares]
        tiles = [part.tiles[0], on_host(tile_hit)]
        chain = [self._pixels, self._pixel_entry, entries["entry_next"], entries["entry_row"], self._rows[2]]
        machine.run("weigh_pixels", [begin, end, *tiles, *hits, *shares, self._matte_scale, *chain, *into])
        self._share_count = int(self._share_bounds.numpy()[end])
        if self._is_flat:
            canvas = [self._columns, self._size[1], self._size[0], int(not self._scene.transparent)]
            first, last = part.tiles
            machine.run("measure_tiles", [first, last - first, *canvas, tiles[1], hits[0], shares[0], squares])

    def _make_room(self, more: int) -> None:
        """Make room for so many more shares of paths in pixels."""
        before, count = self._shares, self._share_count
        get = self._machine.get
        self._shares = [
            get("share_path", count + more + 1, wp.int32),
            get("share_value", count + more + 1, wp.float64),
        ]
        for old, new in zip(before, self._shares, strict=True):
            if old is not new:
                new.numpy()[:count] = old.numpy()[:count]

    def entries_of(
        self, rows: RowSlopes, count: int, factor: float, by_paints: sparse.csr_matrix | None
    ) -> sparse.coo_matrix:
        """Return ``factor`` times the matrix [V, V] of ``count`` values; some entries are in parts.

        Args:
            rows: how the rows follow the values.
            count: V.
            factor: of the matrix.
            by_paints: derivatives of red, then of green, then of blue of the crossed pixels by the values of the paints
                [3 P, U]; None if all are flat. The products of two paints are then left out.
        """
        machine = self._machine
        counts = self._multiply(by_paints)
        self._pixel_entry.numpy()[self.pixels] = -1
        machine.is_clean = True
        blocks = machine.blocks
        most = int(rows.count.numpy()[: self._row_count].max(initial=1))
        pair_count, color_count, colored = (int(counts[number]) for number in (ROW_PAIRS, ROW_COLORS, COLOR_PAIRS))
        room = 2 * most * (most * pair_count + 3 * color_count) + 6 * colored + 1
        triples = [machine.get(name, room, dtype) for name, dtype in _TRIPLES.items()]
        sizes = [self._row_count, self._path_count, self._group_count, self._first_paint, factor]
        machine.run(
            "write_matrix", [*sizes, *blocks[1:], rows.count, rows.value, rows.slopes, on_host(counts), *triples]
        )
        found = [array.numpy()[: counts[TRIPLES]] for array in triples]
        if self._is_flat:
            paths = np.arange(self._path_count)
            color = (3 * paths[:, None] + np.arange(3)).ravel()
            own = self._first_paint + np.append(color, 4 * self._path_count + np.arange(3)).astype(np.int32)
            squares = factor * np.append(self._squares[:-1].repeat(3), np.full(3, max(self._squares[-1], 0.0)))
            more: list[NDArray[Any]] = [own, own, squares]
            found = [np.append(one, other) for one, other in zip(found, more, strict=True)]
        return sparse.coo_matrix((found[2], (found[0], found[1])), shape=(count, count))

    def _multiply(self, by_paints: sparse.csr_matrix | None) -> NDArray[np.int32]:
        """Make the blocks, and return how many there are."""
        machine, entries = self._machine, self._entries
        chain = [self._pixels, self._pixel_entry, entries["entry_next"], entries["entry_row"]]
        chain += [entries["entry_slopes"], self._planes]
        counts = np.zeros(4, np.int32)
        while True:
            table, keys, pairs, colors, colored = machine.begin_blocks()
            counts[:] = 0
            sizes = [len(self.pixels), self._row_count, self._path_count, self._group_count, int(self._is_flat)]
            shares = [self._share_bounds, *self._shares, self._open]
            into = [table, keys, on_host(counts), pairs, colors, colored]
            machine.run("multiply_pixels", [*sizes, *chain, *shares, *into])
            if by_paints is not None:
                own = [by_paints.indptr.astype(np.int32), by_paints.indices.astype(np.int32), by_paints.data]
                known = [on_host(each if len(each) else np.zeros(1, each.dtype)) for each in own]
                sizes = [len(self.pixels), self._group_count]
                machine.run("multiply_paints", [*sizes, *known, *chain, *into[:3], colors])
            if counts.max() <= keys.shape[1]:
                return counts
            machine.block_room = 2 * keys.shape[1]


_TRIPLES = {"triple_row": wp.int32, "triple_column": wp.int32, "triple_value": wp.float64}
