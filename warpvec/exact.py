"""The exact renderer: a path is its area. What it draws is what an SVG renderer draws, up to anti-aliasing."""

from __future__ import annotations

from dataclasses import dataclass

import torch
import warp as wp
from torch import Tensor

from warpvec.binning import Binning, TileGrid
from warpvec.compositing import Compositing, Paint, from_tiles, to_tiles
from warpvec.coverage import Coverage
from warpvec.flattening import Flattening
from warpvec.kernels.constants import TILE, TRANSMITTANCE_MIN
from warpvec.kernels.lanes import make_lanes
from warpvec.launch import Launcher, as_warp, start_warp


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


class Renderer:
    """Renders scenes of one canvas size; keeps its buffers between calls.

    Inputs of every method are points [N, 3 S, 2] px, color [N, 3], opacity [N] and background [3], on the renderer's
    device in its dtype (torch.float32, or torch.float64 for checks).
    """

    def __init__(
        self,
        height: int,
        width: int,
        *,
        device: str = "cpu",
        threads: int | None = None,
        dtype: torch.dtype = torch.float32,
        lane_width: int | None = None,
        transmittance_min: float = TRANSMITTANCE_MIN,
    ) -> None:
        start_warp()
        self.grid = TileGrid(height, width)
        self._launch = Launcher(device, threads)
        self._lanes = make_lanes(lane_width or (1 if self._launch.device.is_cuda else TILE), wp.dtype_from_torch(dtype))
        self.dtype = dtype
        self.device = torch.device(wp.device_to_torch(self._launch.device))
        self._flattening = Flattening(self._launch, self._lanes)
        self._binning = Binning(self._launch, self._lanes, self.grid)
        self._coverage = Coverage(self._launch, self._lanes)
        self._compositing = Compositing(self._launch, self._lanes, self.grid, transmittance_min)

    def render(self, points: Tensor, color: Tensor, opacity: Tensor, background: Tensor) -> Tensor:
        """The image [h, w, 3]."""
        self._cover(points)
        paint = self._paint(color, opacity, background)
        tiles = torch.empty((self.grid.count, 3, TILE, TILE), dtype=self.dtype, device=self.device)
        self._compositing.run(*self._hits(paint), tiles)
        return from_tiles(tiles, self.grid)

    def adjoint(
        self, points: Tensor, color: Tensor, opacity: Tensor, background: Tensor, adj_image: Tensor
    ) -> Adjoints:
        """Adjoints of a render for ``adj_image`` = dL/d(image) [h, w, 3]."""
        self._cover(points)
        paint = self._paint(color, opacity, background)
        reference = to_tiles(adj_image.to(self.dtype), self.grid)
        sums = self._compositing.adjoint(*self._hits(paint), reference)
        return self._collect(points, *sums)

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
        self._cover(points)
        paint = self._paint(color, opacity, background)
        scale = 1.0 / (3 * self.grid.height * self.grid.width)
        path_sums, canvas_sums = self._compositing.adjoint(*self._hits(paint), prepared_target, scale, removal)
        adjoints = self._collect(points, path_sums, canvas_sums)
        # L without path i, minus L: the image is affine in one opacity, the loss a parabola.
        o, adj_o = opacity.detach(), adjoints.opacity
        gain = o * o * path_sums[:, 4] * scale - o * adj_o if removal else None
        return Adjoints(adjoints.points, adjoints.color, adj_o, adjoints.background, canvas_sums[3] * scale, gain)

    def _cover(self, points: Tensor) -> None:
        path_count, segment_count = points.shape[0], points.shape[1] // 3
        array = as_warp(points, self._lanes.vec2)
        self._flattening.run(array)
        self._binning.run(self._flattening, path_count, segment_count)
        self._coverage.run(self._flattening, self._binning, segment_count)

    def _paint(self, color: Tensor, opacity: Tensor, background: Tensor) -> Paint:
        return Paint(color, opacity, background, self._lanes)

    def _hits(self, paint: Paint) -> tuple[Binning, wp.array, wp.array, Paint]:
        visible = self._compositing.find_visible(self._binning, paint)
        return self._binning, visible, self._coverage.slot_winding, paint

    def _collect(self, points: Tensor, path_sums: Tensor, canvas_sums: Tensor) -> Adjoints:
        path_count, segment_count = points.shape[0], points.shape[1] // 3
        adj_edges = self._coverage.adjoint(self._flattening, self._binning, path_count, segment_count)
        adj_points = torch.empty(points.shape, dtype=self.dtype, device=self.device)
        self._flattening.adjoint(adj_edges, as_warp(adj_points, self._lanes.vec2))
        return Adjoints(adj_points, path_sums[:, :3], path_sums[:, 3], canvas_sums[:3])
