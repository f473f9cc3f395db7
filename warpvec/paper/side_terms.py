"""The regularizers of paths of two sides, as the code of the published methods has them.

The Xing term is that of ironjr/vector-scaffolding at 2b11004, whose weight of 0.02 multiplies the bare term. The Bezier
term is `warpvec.fit.regularization.bezier_loss`; Vector Scaffolding has no projection, Bezier Splatting has.
"""

from __future__ import annotations

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.parametrization import all_opacities
from warpvec.fit.regularization import bezier_loss, opacity_loss
from warpvec.geometry.scene import Scene
from warpvec.kernels.constants import PROJECTION_WEIGHT
from warpvec.paper.settings import paper_settings

TIP_SAMPLES = 5
"""Needle tips are looked for so many samples of a side before and after a joint."""

NORM_ADDED = 1e-8
"""Added to the product of the lengths of two legs, in half sides, before a sine is divided by it."""

TRIPLE = 3
"""Legs of the control polygon that are looked at together."""


class SideTerms:
    """The adjoints of `side_terms` for a canvas and the weights of ``config``.

    Attributes:
        can_record: False: autograd makes memory of its own.
    """

    can_record = False

    def __init__(self, height: int, width: int, config: FitConfig) -> None:
        self._height, self._width, self._config = height, width, config

    @torch.enable_grad()
    def add_adjoint(
        self, scene: Scene, adj_segments: Tensor, adj_opacity: Tensor, counts: Tensor | None = None
    ) -> None:
        """Add dL/dsegments [R, M, 2] and dL/dopacity [N, 1 or 3, or N] of `side_terms`, in place.

        ``counts`` must be None.
        """
        assert counts is None
        points, opacity = scene.points.detach().requires_grad_(), all_opacities(scene).detach().requires_grad_()
        value = side_terms(points, opacity, self._width, self._height, self._config)
        gradients = torch.autograd.grad(value, (points, opacity))
        adj_segments += gradients[0].view_as(adj_segments)
        adj_opacity += gradients[1].view_as(adj_opacity)


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
    tip = TIP_SAMPLES / max(own.samples, 2 * TIP_SAMPLES)
    projection = 0.0 if own.without_projection else PROJECTION_WEIGHT
    return (
        config.opacity_weight * opacity_loss(opacity)
        + config.xing_weight * side_xing_loss(points / half_sides)
        + config.bezier_weight * bezier_loss(points, width, height, own.degree, tip, projection)
    )


def side_xing_loss(points: Tensor) -> Tensor:
    """Return the mean over paths and triples of how far the third leg of a triple turns back on the first.

    The legs are those of the open control polygon, from the first point to the last; the leg back to the first is
    absent. Each triple begins where the last one ended. So one of the three triples of two quintics lies across the
    joint of the sides. The loss of a triple is LIVE's, as in `warpvec.fit.regularization.xing_loss`.

    Args:
        points: control points [N, P, 2] in half sides.
    """
    legs = points.diff(dim=1)
    count = legs.shape[1] // TRIPLE
    if count == 0 or not len(points):
        return points.sum() * 0.0
    first, second, third = legs[:, : count * TRIPLE].reshape(-1, count, TRIPLE, 2).unbind(2)
    turn = torch.where(_cross(first, second) >= 0.0, 1.0, -1.0).to(points.dtype)
    sine = _cross(first, third) / (first.norm(dim=-1) * third.norm(dim=-1) + NORM_ADDED)
    return (turn * sine).neg().relu().mean()


def _cross(u: Tensor, v: Tensor) -> Tensor:
    return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
