"""The three opacities of each path side by side, by launches that a graph can record."""

from __future__ import annotations

import torch
import warp as wp
from torch import Tensor

from warpvec.geometry.side_opacity import SideOpacity
from warpvec.kernels.lanes import make_lanes
from warpvec.kernels.opacity_columns import make_kernels
from warpvec.rendering.launch import Launcher, as_warp


class OpacityColumns:
    """Opacities of paths, or their adjoints, side by side in memory that stays while no more come."""

    def __init__(self, device: str) -> None:
        self._launch = Launcher(device, threads=1)
        self._memory = torch.empty(0, 3)

    def joined(self, opacity: Tensor, sides: Tensor | None) -> Tensor:
        """Return ``opacity`` [N] with those at the ``sides`` [N, 2] as [N, 3], which the next call overwrites.

        Without any at the sides, return ``opacity`` itself.
        """
        if sides is None:
            return opacity
        if len(self._memory) < len(opacity) or self._memory.dtype != opacity.dtype:
            self._memory = opacity.new_empty(len(opacity), 3)  # a graph may write to it while fewer paths are joined
        memory = self._memory[: len(opacity)]
        lanes = make_lanes(1, wp.dtype_from_torch(opacity.dtype))
        arguments = [as_warp(values, lanes.dtype) for values in (opacity, sides, memory)]
        self._launch(make_kernels(lanes).join_opacities, len(opacity), arguments)
        return memory

    def part(self, joined: Tensor, opacity: Tensor, sides: SideOpacity) -> None:
        """Write ``joined`` [N, 3] to ``opacity`` [N] and ``sides``."""
        lanes = make_lanes(1, wp.dtype_from_torch(opacity.dtype))
        arguments = [as_warp(values, lanes.dtype) for values in (joined, opacity, sides.value)]
        self._launch(make_kernels(lanes).part_opacities, len(opacity), arguments)
