"""Host side of `kernels/recycling.py`: where paths and their segments lie after some have gone and others have come."""

from __future__ import annotations

from typing import Any, NamedTuple

import torch
import warp as wp
from torch import Tensor

from warpvec.geometry.structure import Structure
from warpvec.kernels.lanes import make_lanes
from warpvec.kernels.recycling import make_kernels
from warpvec.rendering.launch import Launcher, as_warp, exclusive_scan, start_warp


class Sources(NamedTuple):
    """Which path and which segment comes to each place.

    Attributes:
        path: [paths that there is room for] int64; from that number on they count the new ones.
        segment: [segments that there is room for] int64, likewise; the number after the new ones is for the room.
    """

    path: Tensor
    segment: Tensor


class Recycling:
    """Changes of the paths in memory with room for ``path_room`` paths and ``segment_room`` segments on ``device``."""

    def __init__(self, path_room: int, segment_room: int, device: torch.device) -> None:
        start_warp()
        self._path_room, self._segment_room, self._device = path_room, segment_room, device
        self._launch = Launcher(str(device), threads=1)
        self._buffers = self._launch.make_buffers()

    def drop(self, count: int, cost: Tensor, structure: Structure, counts: Tensor) -> Sources:
        """Let the ``count`` paths of the lowest ``cost`` [N] go; of equal ones the first.

        ``structure`` is that of the whole memory, and ``counts`` [1] is the number of the paths in it. Both change.
        """
        return self.change(count, cost, 0, 0, structure, counts)

    def add(self, count: int, segment_count: int, structure: Structure, counts: Tensor) -> Sources:
        """Let ``count`` paths of ``segment_count`` segments each come after the others."""
        return self.change(0, counts.to(torch.float32), count, segment_count, structure, counts)

    def change(
        self, drop_count: int, cost: Tensor, new_count: int, new_segments: int, structure: Structure, counts: Tensor
    ) -> Sources:
        """Do both; arguments as above."""
        lanes = make_lanes(1, wp.dtype_from_torch(cost.dtype))
        kernels, paths, rows = make_kernels(lanes), self._path_room, self._segment_room
        count, first = as_warp(counts, wp.int32), as_warp(structure.path_first_segment, wp.int32)
        kept, segments, start = (self._buffers.get(name, paths + 1, wp.int32) for name in ("kept", "segments", "start"))
        chosen = [drop_count, paths, count, as_warp(cost, lanes.dtype), first, kept, segments, start]
        self._launch(kernels.choose_paths, paths + 1, chosen)
        path_sums, segment_sums = (
            exclusive_scan(self._buffers, f"sums of {name}", each, paths)
            for name, each in (("paths", kept), ("segments", segments))
        )
        sources = Sources(*(torch.empty(n, dtype=torch.int64, device=self._device) for n in (paths, rows)))
        written = [*(as_warp(each, wp.int64) for each in sources), *_tables(structure)]
        places = [new_count, new_segments, paths, rows, kept, path_sums, segments, segment_sums, start, count]
        self._launch(kernels.place_paths, paths + new_count, [*places, *written])
        room = [new_count * new_segments, paths, rows, count, segment_sums]
        self._launch(kernels.place_room, max(paths + 1, rows), [*room, *written])
        return sources


def _tables(structure: Structure) -> list[Any]:
    """Return the tables of segments that follow the paths; those of equal paths stay, and others take their place."""
    names = ("path_first_segment", "segment_path", "segment_next", "segment_previous")
    tables = [getattr(structure, name) for name in names]
    if structure.uniform_count is not None:
        tables = [torch.empty_like(table) for table in tables]
    return [as_warp(table, wp.int32) for table in tables]
