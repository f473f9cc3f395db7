"""The path model "sides": a path is two curves of one degree with common ends, as in the paper."""

from __future__ import annotations

import math

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.path_models import Regularizer
from warpvec.geometry.circles import circle_sides
from warpvec.paper.settings import paper_settings
from warpvec.paper.side_terms import SideTerms


class Sides:
    """Paths of two curves; see `warpvec.fit.path_models.PathModel`."""

    piece_count = 2

    def __init__(self, config: FitConfig) -> None:
        self.degree = paper_settings(config).degree

    def circles(self, center: Tensor, radius: Tensor) -> Tensor:
        """Return the control points [N, 2 M, 2] of circles."""
        return circle_sides(center, radius, self.degree)

    def regularizer(self, height: int, width: int, config: FitConfig, device: str) -> Regularizer:
        """Return the regularizers of two sides."""
        return SideTerms(height, width, config, device)


def birth_points(center: Tensor, reach: Tensor, degree: int, jitter: Tensor | None = None) -> Tensor:
    """Return the control points [N, 2 M, 2] of new paths as the code of the published methods makes them.

    They lie on an ellipse, at 2 M equal steps of the angle over a whole turn with both ends. So the last one is the
    first, the second side turns by less than the first, and both lie inside: a quintic path has the area of an ellipse
    of 0.825 times the half axes.

    Args:
        center: centres [N, 2] px.
        reach: half axes of the ellipse [2] px.
        degree: M.
        jitter: factor of the distance of each point from the centre [N, 2 M]; the last one is not used.
    """
    angle = torch.linspace(0.0, 2.0 * math.pi, 2 * degree, dtype=center.dtype, device=center.device)
    unit = torch.stack([angle.cos(), angle.sin()], -1).expand(len(center), -1, -1)
    points = center[:, None, :] + reach * (unit if jitter is None else jitter[..., None] * unit)
    return torch.cat([points[:, :-1], points[:, :1]], 1)
