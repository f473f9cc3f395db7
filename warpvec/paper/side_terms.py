"""The regularizers of paths of two sides, as the code of the published methods has them.

The Xing term is that of ironjr/vector-scaffolding at 2b11004, whose weight of 0.02 multiplies the bare term. The Bezier
term is `warpvec.fit.regularization.bezier_loss`; Vector Scaffolding has no projection, Bezier Splatting has.
"""

from __future__ import annotations

import torch
import warp as wp
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.opacity_columns import OpacityColumns
from warpvec.fit.parametrization import all_opacities
from warpvec.fit.regularization import bezier_loss, opacity_loss, tip_reach
from warpvec.geometry.scene import Scene
from warpvec.kernels import side_terms as kernels
from warpvec.kernels.constants import PROJECTION_WEIGHT, TILE, XING_NORM_ADDED, XING_TRIPLE
from warpvec.kernels.lanes import make_lanes
from warpvec.paper.settings import paper_settings
from warpvec.rendering.launch import Launcher, as_warp

TIP_SAMPLES = 5
"""Needle tips are looked for so many samples of a side before and after a joint."""


class SideTerms:
    """The adjoints of `side_terms` for a canvas and the weights of ``config``.

    Without the projection they are a kernel's, else autograd's.

    Attributes:
        can_record: whether a graph can record them: autograd makes memory of its own.
    """

    def __init__(self, height: int, width: int, config: FitConfig, device: str) -> None:
        self._height, self._width, self._config = height, width, config
        own = paper_settings(config)
        self._is_kernel = own.without_projection
        self._columns = OpacityColumns(device)
        self.can_record = self._is_kernel
        self._launch = Launcher(device, threads=1)
        self._buffers = self._launch.make_buffers()
        weights = tip_reach(own.degree, tip_parameter(own.samples))
        self._reach = torch.tensor(weights, dtype=torch.float64, device=device)

    def add_adjoint(
        self, scene: Scene, adj_segments: Tensor, adj_opacity: Tensor, counts: Tensor | None = None
    ) -> None:
        """Add dL/dsegments [R, M, 2] and dL/dopacity [N, 1 or 3, or N] of `side_terms`, in place.

        ``counts`` [1] (int32), on the device, is the number of paths that there are, if the scene has room for more.
        """
        if self._is_kernel:
            self._launch_terms(scene, adj_segments, adj_opacity, counts)
        else:
            self._derive_terms(scene, adj_segments, adj_opacity)

    def _launch_terms(self, scene: Scene, adj_segments: Tensor, adj_opacity: Tensor, counts: Tensor | None) -> None:
        config, view = self._config, self._buffers.view
        lanes = make_lanes(1 if self._launch.device.is_cuda else TILE, wp.dtype_from_torch(scene.segments.dtype))
        if self._reach.dtype != scene.segments.dtype:
            self._reach = self._reach.to(scene.segments.dtype)
        if counts is None:
            counts = torch.full((1,), len(scene), dtype=torch.int32, device=self._reach.device)
        points = view("points", scene.segments, lanes.vec2, -1, 2)
        sides = None if scene.side_opacity is None else scene.side_opacity.value
        opacities = as_warp(_as_columns(self._columns.joined(scene.opacity, sides)), lanes.dtype)
        inputs = [points, opacities, view("counts", counts, wp.int32)]
        weights = (config.xing_weight, config.bezier_weight, config.opacity_weight)
        settings = [lanes.vec2(2.0 / self._width, 2.0 / self._height), *map(lanes.dtype, weights)]
        reach = view("reach", self._reach, lanes.dtype)
        outputs = [view("adj_points", adj_segments, lanes.vec2, -1, 2)]
        outputs.append(as_warp(_as_columns(adj_opacity), lanes.dtype))
        kernel = kernels.make_kernels(lanes).add_side_terms
        self._launch(kernel, len(scene), [*inputs, reach, *settings, *outputs])

    @torch.enable_grad()
    def _derive_terms(self, scene: Scene, adj_segments: Tensor, adj_opacity: Tensor) -> None:
        points, opacity = scene.points.detach().requires_grad_(), all_opacities(scene).detach().requires_grad_()
        value = side_terms(points, opacity, self._width, self._height, self._config)
        gradients = torch.autograd.grad(value, (points, opacity))
        adj_segments += gradients[0].view_as(adj_segments)
        adj_opacity += gradients[1].view_as(adj_opacity)


def _as_columns(opacity: Tensor) -> Tensor:
    return opacity if opacity.dim() == 2 else opacity[:, None]


def side_terms(points: Tensor, opacity: Tensor, width: float, height: float, config: FitConfig) -> Tensor:
    """Return the weighted sum of the three regularizers, equation (6).

    Args:
        points: control points [N, 2 M, 2] in pixels.
        opacity: fill opacities [N, 1], or [N, 3] with those at the sides, in [0, 1].
        width, height: canvas in pixels.
        config: gives the weights, the degree M, and the samples of a side, which tips are measured by.
    """
    own = paper_settings(config)
    half_sides = points.new_tensor([width / 2.0, height / 2.0])
    tip = tip_parameter(own.samples)
    projection = 0.0 if own.without_projection else PROJECTION_WEIGHT
    return (
        config.opacity_weight * opacity_loss(opacity)
        + config.xing_weight * side_xing_loss(points / half_sides)
        + config.bezier_weight * bezier_loss(points, width, height, own.degree, tip, projection)
    )


def tip_parameter(samples: int) -> float:
    """Return the parameter along a side of ``samples`` at which tips are probed."""
    return TIP_SAMPLES / max(samples, 2 * TIP_SAMPLES)


def side_xing_loss(points: Tensor) -> Tensor:
    """Return the mean over paths and triples of how far the third leg of a triple turns back on the first.

    The legs are those of the open control polygon, from the first point to the last; the leg back to the first is
    absent. Each triple begins where the last one ended. So one of the three triples of two quintics lies across the
    joint of the sides. The loss of a triple is LIVE's, as in `warpvec.fit.regularization.xing_loss`.

    Args:
        points: control points [N, P, 2] in half sides.
    """
    legs = points.diff(dim=1)
    count = legs.shape[1] // XING_TRIPLE
    if count == 0 or not len(points):
        return points.sum() * 0.0
    first, second, third = legs[:, : count * XING_TRIPLE].reshape(-1, count, XING_TRIPLE, 2).unbind(2)
    turn = torch.where(_cross(first, second) >= 0.0, 1.0, -1.0).to(points.dtype)
    sine = _cross(first, third) / (first.norm(dim=-1) * third.norm(dim=-1) + XING_NORM_ADDED)
    return (turn * sine).neg().relu().mean()


def _cross(u: Tensor, v: Tensor) -> Tensor:
    return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
