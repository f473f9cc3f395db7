"""What the renderers share: paths cover the pixels of their (path, tile) pairs, and the pairs are composited."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace

import torch
import warp as wp
from torch import Tensor

from warpvec.binning import Binning, TileGrid
from warpvec.compositing import Compositing, Paint, from_tiles, to_tiles
from warpvec.kernels.constants import TILE
from warpvec.kernels.lanes import make_lanes
from warpvec.launch import Launcher, start_warp

Hits = tuple[Binning, wp.array, wp.array, Paint]
"""Pairs, the lowest hit of each tile that is seen, coverage of the pairs' pixels, and what they are painted with."""


@dataclass(frozen=True)
class Adjoints:
    """dL/d(each input) of a render, in the inputs' shapes.

    Attributes:
        loss: the mean squared error, of a fused step.
        removal: what that loss gains when a path is removed [N], where it was asked for.
    """

    points: Tensor
    color: Tensor
    opacity: Tensor
    background: Tensor
    loss: Tensor | None = None
    removal: Tensor | None = None


class TileRenderer(ABC):
    """Renders scenes of one canvas size; keeps its buffers between calls.

    Inputs of every method are points [N, P, 2] px, color [N, 3], opacity [N] and background [3], on the renderer's
    device in its dtype (torch.float32, or torch.float64 for checks).
    """

    def __init__(
        self,
        height: int,
        width: int,
        device: str,
        threads: int | None,
        dtype: torch.dtype,
        lane_width: int | None,
        transmittance_min: float,
    ) -> None:
        start_warp()
        self.grid = TileGrid(height, width)
        self._launch = Launcher(device, threads)
        self._lanes = make_lanes(lane_width or (1 if self._launch.device.is_cuda else TILE), wp.dtype_from_torch(dtype))
        self.dtype = dtype
        self.device = torch.device(wp.device_to_torch(self._launch.device))
        self._compositing = Compositing(self._launch, self._lanes, self.grid, transmittance_min)

    def render(self, points: Tensor, color: Tensor, opacity: Tensor, background: Tensor) -> Tensor:
        """The image [h, w, 3]."""
        hits = self._cover(points, color, opacity, background)
        tiles = torch.empty((self.grid.count, 3, TILE, TILE), dtype=self.dtype, device=self.device)
        self._compositing.run(*hits, tiles)
        return from_tiles(tiles, self.grid)

    def adjoint(
        self, points: Tensor, color: Tensor, opacity: Tensor, background: Tensor, adj_image: Tensor
    ) -> Adjoints:
        """Adjoints of a render for ``adj_image`` = dL/d(image) [h, w, 3]."""
        hits = self._cover(points, color, opacity, background)
        sums = self._compositing.adjoint(*hits, to_tiles(adj_image.to(self.dtype), self.grid))
        return self._collect(points, opacity, *sums)

    def prepare_target(self, target: Tensor) -> Tensor:
        """A target image [h, w, 3] in the form that :meth:`fit_step` takes."""
        return to_tiles(target.to(self.device, self.dtype), self.grid)

    def fit_step(
        self,
        points: Tensor,
        color: Tensor,
        opacity: Tensor,
        background: Tensor,
        prepared_target: Tensor,
        removal: bool = False,
    ) -> Adjoints:
        """Render, mean squared error and adjoint in one pass; ``removal`` asks for each path's importance."""
        hits = self._cover(points, color, opacity, background)
        scale = 1.0 / (3 * self.grid.height * self.grid.width)
        path_sums, canvas_sums = self._compositing.adjoint(*hits, prepared_target, scale, removal)
        adjoints = self._collect(points, opacity, path_sums, canvas_sums)
        # L without path i, minus L: the image is affine in one path's painted opacity, the loss a parabola.
        o = hits[-1].opacity
        gain = o * o * path_sums[:, 4] * scale - o * path_sums[:, 3] if removal else None
        return replace(adjoints, loss=canvas_sums[3] * scale, removal=gain)

    @abstractmethod
    def _cover(self, points: Tensor, color: Tensor, opacity: Tensor, background: Tensor) -> Hits:
        """What is composited."""

    @abstractmethod
    def _collect(self, points: Tensor, opacity: Tensor, path_sums: Tensor, canvas_sums: Tensor) -> Adjoints:
        """Adjoints of the inputs from the sums of compositing, once the coverage holds its adjoint."""
