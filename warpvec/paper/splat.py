"""The splat renderer of the paper: Gaussians along a path's boundary and through its interior.

Its soft edge lies up to a pixel outside the curve, so the SVG of a scene does not look like this image. Quality is
therefore reported for both. The positions of interior samples are attached to the control points (Interior Gradient
Aggregation, section 3.2). Detached, they are those of Bezier Splatting.
"""

from __future__ import annotations

from typing import Any

import torch
import warp as wp
from torch import Tensor

from warpvec.errors import InputError
from warpvec.geometry.scene import Scene
from warpvec.kernels.constants import TRANSMITTANCE_MIN
from warpvec.paper.stages.row_opacity import RowOpacity
from warpvec.paper.stages.splat_binning import SplatBinning
from warpvec.paper.stages.splat_coverage import SplatCoverage, color_weights
from warpvec.paper.stages.splatting import Splatting
from warpvec.rendering.capacity import Counts
from warpvec.rendering.tile_renderer import Adjoints, Hits, TileRenderer


class SplatRenderer(TileRenderer):
    """Renderer of uniform scenes: pieces of ``degree`` in a closed loop.

    The first half of a path's pieces, rounded down, is one side of the path; the rest is the other side.

    Args:
        samples: Gaussians along each side and along each line between them, at least 2.
        lines: lines between the sides, at least 1.
        interior_gradient: whether the Gaussians of the lines are attached to the control points.
        covariance_gradient: whether the covariances of attached Gaussians are attached as well as their centers.
        released_adjoint: whether opacities are clipped in the adjoint as in the code of Vector Scaffolding.
        color_falloff: whether Gaussians near the middle of a path count less for the gradient of its colour.
        transmittance_min, machine: as every `TileRenderer` has them.
    """

    def __init__(
        self,
        height: int,
        width: int,
        *,
        samples: int = 64,
        lines: int = 40,
        interior_gradient: bool = True,
        covariance_gradient: bool = False,
        released_adjoint: bool = False,
        color_falloff: bool = False,
        transmittance_min: float = TRANSMITTANCE_MIN,
        **machine: Any,
    ) -> None:
        super().__init__(height, width, transmittance_min=transmittance_min, **machine)
        launch, lanes, covariance = self._launch, self._lanes, covariance_gradient
        self._splatting = Splatting(launch, lanes, samples, lines, self.degree, interior_gradient, covariance)
        self._row_opacity = RowOpacity(launch, lanes, lines)
        self._binning = SplatBinning(launch, lanes, self.grid, samples)
        weight = color_weights(lines, samples) if color_falloff else None
        limits = (transmittance_min, released_adjoint)
        self._coverage = SplatCoverage(launch, lanes, self.grid, covariance, *limits, weight)
        self._buffers = launch.make_buffers()
        self._ones = torch.ones(0)

    def _cover(self, scene: Scene) -> Hits:
        if scene.gradients is not None:
            raise InputError(
                "scene", "must have flat fills for the renderer splat", "gradients", "render it with exact"
            )
        if scene.softness is not None:
            raise InputError(
                "scene", "must have sharp paths for the renderer splat", "soft ones", "render it with exact"
            )
        self._row_opacity.run(scene.opacity, scene.side_opacity)
        self._splatting.run(scene.points, self._row_opacity.values)
        self._binning.bin_splats(self._splatting, len(scene))
        self._coverage.run(self._splatting, self._binning, self._row_opacity.values)
        # The Gaussians contain the path's opacity already, so coverage is composited as opaque.
        paint = self._compositing.paint(scene.color, self._opaque(len(scene)), scene.background)
        paint.share = self._coverage.slot_share
        return self._binning, self._coverage.tile_first_visible, self._coverage.slot_coverage, paint

    def _collect(self, scene: Scene, adjoints: Adjoints) -> None:
        points, adj_points = scene.points, adjoints.segments.view(scene.points.shape)
        splat_sums = self._coverage.adjoint(self._splatting, self._binning, self._row_opacity.values, len(scene))
        # This overwrites the adjoint of the paint's opacity, which is constant.
        self._splatting.adjoint(points, scene.opacity, splat_sums, adj_points, adjoints.opacity)
        if scene.side_opacity is not None and adjoints.side_opacity is not None:
            own = [adjoints.opacity, adjoints.side_opacity]
            self._row_opacity.adjoint(scene.opacity, scene.side_opacity, self._splatting, splat_sums, own)

    @property
    def counts(self) -> Counts:
        """Sizes of the last step."""
        return Counts(0, self._binning.strip_count, self._binning.pair_count, self._binning.slot_count)

    def _opaque(self, path_count: int) -> Tensor:
        growth = self._buffers.growth
        ones = self._buffers.get("ones", path_count, self._lanes.dtype)
        if self._buffers.growth > growth:
            ones.fill_(1.0)
            self._ones = wp.to_torch(ones)
        return self._ones[:path_count]
