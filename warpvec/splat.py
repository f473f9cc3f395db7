"""The splat renderer, the paper's: a path is the Gaussians along its boundary and through its interior.

Its soft edge lies outside the curve by up to a pixel, so the SVG of a scene does not look like this image: quality is
reported for both. Positions of interior samples are attached to the control points (Interior Gradient Aggregation,
section 3.2); detached, they are as in Bezier Splatting.
"""

from __future__ import annotations

import torch
import warp as wp
from torch import Tensor

from warpvec.binning import TileGrid
from warpvec.compositing import Compositing, Paint, from_tiles, to_tiles
from warpvec.exact import Adjoints
from warpvec.kernels.constants import TILE, TRANSMITTANCE_MIN
from warpvec.kernels.lanes import make_lanes
from warpvec.launch import Launcher, start_warp
from warpvec.splat_binning import SplatBinning
from warpvec.splat_coverage import SplatCoverage
from warpvec.splatting import Splatting


class Renderer:
    """Renders scenes of one canvas size; keeps its buffers between calls.

    Inputs of every method are as :class:`warpvec.exact.Renderer` has them, but points are [N, P, 2] px, pieces of
    ``degree`` in a closed loop. A path's first half of pieces, rounded down, is one side, the others are the other.

    Args:
        samples: Gaussians along each side and each line between them, at least 2.
        lines: lines between the sides, at least 1.
        degree: of the pieces.
        interior_gradient: whether the lines' Gaussians are attached to the control points.
        covariance_gradient: whether the covariances of attached Gaussians are attached too, not their centers alone.
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
        samples: int = 64,
        lines: int = 40,
        degree: int = 3,
        interior_gradient: bool = True,
        covariance_gradient: bool = False,
    ) -> None:
        start_warp()
        self.grid = TileGrid(height, width)
        launch = Launcher(device, threads)
        lanes = make_lanes(lane_width or (1 if launch.device.is_cuda else TILE), wp.dtype_from_torch(dtype))
        self._launch, self._lanes = launch, lanes
        self.dtype = dtype
        self.device = torch.device(wp.device_to_torch(launch.device))
        self._splatting = Splatting(launch, lanes, samples, lines, degree, interior_gradient, covariance_gradient)
        self._binning = SplatBinning(launch, lanes, self.grid, samples)
        self._coverage = SplatCoverage(launch, lanes, self.grid, covariance_gradient, transmittance_min)
        self._compositing = Compositing(launch, lanes, self.grid)

    def render(self, points: Tensor, color: Tensor, opacity: Tensor, background: Tensor) -> Tensor:
        """The image [h, w, 3]."""
        self._cover(points, opacity)
        tiles = torch.empty((self.grid.count, 3, TILE, TILE), dtype=self.dtype, device=self.device)
        self._compositing.run(*self._hits(color, background), tiles)
        return from_tiles(tiles, self.grid)

    def adjoint(
        self, points: Tensor, color: Tensor, opacity: Tensor, background: Tensor, adj_image: Tensor
    ) -> Adjoints:
        """Adjoints of a render for ``adj_image`` = dL/d(image) [h, w, 3]."""
        self._cover(points, opacity)
        reference = to_tiles(adj_image.to(self.dtype), self.grid)
        sums = self._compositing.adjoint(*self._hits(color, background), reference)
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
        self._cover(points, opacity)
        scale = 1.0 / (3 * self.grid.height * self.grid.width)
        hits = self._hits(color, background)
        path_sums, canvas_sums = self._compositing.adjoint(*hits, prepared_target, scale, removal)
        adjoints = self._collect(points, opacity, path_sums, canvas_sums)
        # L without path i, minus L: the image is affine in a factor of one path's coverage, the loss a parabola.
        gain = path_sums[:, 4] * scale - path_sums[:, 3] if removal else None
        loss = canvas_sums[3] * scale
        return Adjoints(adjoints.points, adjoints.color, adjoints.opacity, adjoints.background, loss, gain)

    def _cover(self, points: Tensor, opacity: Tensor) -> None:
        self._splatting.run(points, opacity)
        self._binning.bin_splats(self._splatting, len(points))
        self._coverage.run(self._splatting, self._binning, opacity)

    def _hits(self, color: Tensor, background: Tensor) -> tuple[SplatBinning, wp.array, wp.array, Paint]:
        # The path's opacity is in its Gaussians: coverage is composited as it is.
        paint = Paint(color, torch.ones_like(color[:, 0]), background, self._lanes)
        return self._binning, self._coverage.tile_first_visible, self._coverage.slot_coverage, paint

    def _collect(self, points: Tensor, opacity: Tensor, path_sums: Tensor, canvas_sums: Tensor) -> Adjoints:
        splat_sums = self._coverage.adjoint(self._splatting, self._binning, opacity)
        adj_points, adj_opacity = self._splatting.adjoint(points, opacity, splat_sums)
        return Adjoints(adj_points, path_sums[:, :3], adj_opacity, canvas_sums[:3])
