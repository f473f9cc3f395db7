"""Run kernels of one work item each, which stand for many small steps, and keep their buffers.

These last as long as their thread, because drawings are made one after another.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
import warp as wp
from numpy.typing import NDArray

from warpvec.kernels import (
    crossed_pixels,
    cubic_fitting,
    damped_steps,
    near_errors,
    normal_matrix,
    part_choice,
    pixel_weights,
    row_slopes,
)
from warpvec.kernels.crossed_pixels import ROW_VALUES, vec9
from warpvec.kernels.row_slopes import COLUMNS_MAX
from warpvec.rendering.launch import Launcher, as_warp, once_per_thread, start_warp

_ENTRIES_FIRST, _BLOCKS_FIRST = 2**13, 2**9
"""Room for pairs of a curve and a pixel, and for blocks, at the beginning."""


class Machine:
    """The kernels and buffers of a thread on one device.

    Attributes:
        launch: launches kernels.
        get: returns a buffer; see `warpvec.rendering.launch.Buffers.get`.
        entry_room, block_room: room for pairs of a curve and a pixel, and for blocks of the matrix.
        blocks: those of the last matrix; see `begin_blocks`.
        is_clean: whether `pixel_entry` was put back.
    """

    def __init__(self, device: str) -> None:
        start_warp()
        self.launch = Launcher(device, 1)
        self.get = self.launch.make_buffers().get
        self.kernels = {name: kernel for each in _SOURCES for name, kernel in vars(each.make_kernels()).items()}
        self.entry_room, self.block_room = _ENTRIES_FIRST, _BLOCKS_FIRST
        self.blocks: list[wp.array] = []
        self._pixel_entry: wp.array | None = None
        self.is_clean = False

    def run(self, name: str, arguments: list[Any]) -> None:
        """Run the kernel ``name`` as one work item."""
        self.launch(self.kernels[name], 1, arguments)

    def pixel_entry(self, count: int) -> wp.array:
        """Return an array of -1 for ``count`` pixels. Callers reset what they changed, then set ``is_clean``."""
        array = self.get("pixel_entry", count, wp.int32)
        if array is not self._pixel_entry or not self.is_clean:
            array.fill_(-1)
            self._pixel_entry = array
        self.is_clean = False
        return array

    def row_slopes(self, count: int) -> tuple[wp.array, wp.array, wp.array]:
        """Return room for the derivatives of ``count`` rows, their values, and the number of these."""
        slopes, values = (self.get(f"row_{name}", (count, COLUMNS_MAX), of) for name, of in _ROW_ARRAYS.items())
        return slopes, values, self.get("row_count", count, wp.int32)

    def begin_blocks(self) -> list[wp.array]:
        """Return an empty hash table, its keys, and the blocks that these number."""
        room, get = self.block_room, self.get
        size = 4 << room.bit_length()
        table = get("table", (3, size), wp.int32)
        table.fill_(-1)
        keys = get("keys", (3, room), wp.int64)
        pairs, colors = get("row_pairs", (room, ROW_VALUES), vec9), get("row_colors", 3 * room, vec9)
        self.blocks = [table, keys, pairs, colors, get("color_pairs", room, wp.float64)]
        return self.blocks


_SOURCES: tuple[Any, ...] = (
    crossed_pixels, pixel_weights, normal_matrix, row_slopes, damped_steps, near_errors, cubic_fitting, part_choice,
)  # fmt: skip

_machine = once_per_thread(Machine)


def machine_of_thread(device: str = "cpu") -> Machine:
    """Return the kernels and buffers of this thread on a ``device``."""
    return _machine(device)


_ROW_ARRAYS = {"slopes": vec9, "values": wp.int32}


def on_host(array: NDArray[Any], dtype: Any = None, *, whole: bool = False) -> Any:
    """Return an argument of a kernel over the memory of a contiguous array.

    Its elements are vectors if ``dtype`` says so. Structures take a ``whole`` Warp array; see `as_warp`.
    """
    assert array.flags.c_contiguous, "a kernel would write to a copy"
    return as_warp(torch.from_numpy(array), dtype or wp.dtype_from_numpy(array.dtype), whole=whole)


def vectors_on_host(array: NDArray[Any], *, whole: bool = False) -> Any:
    """Return plane vectors [..., 2] as an argument of a kernel, over their memory if they are contiguous float64."""
    return on_host(np.ascontiguousarray(array, np.float64), wp.vec2d, whole=whole)
