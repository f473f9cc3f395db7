"""The path model "sides": a path is two curves of one degree with common ends, as in the paper."""

from __future__ import annotations

from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.geometry.circles import circle_sides
from warpvec.paper.settings import paper_settings


class Sides:
    """Paths of two curves; see `warpvec.fit.path_models.PathModel`."""

    piece_count = 2

    def __init__(self, config: FitConfig) -> None:
        self.degree = paper_settings(config).degree

    def circles(self, center: Tensor, radius: Tensor) -> Tensor:
        """Return the control points [N, 2 M, 2] of circles."""
        return circle_sides(center, radius, self.degree)
