"""No small paths: they are the first to be recycled, and go while there is time to fit the others without them."""

from __future__ import annotations

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.population import Population
from warpvec.fit.target import Target
from warpvec.fit.visibility import FAINT, faint

CUTS = (0.75, 0.85, 0.95)
"""Shares of the iterations at which small paths go: after the last recycling, and what has shrunk since."""

MARGIN = 1.2
"""What is cut is smaller than this many times the least area: paths go on shrinking and growing until the end, and what
ends up below the least area goes from the file without a fit of the others."""


class SmallPaths:
    """The paths of less than ``config.min_area`` square pixels of ``canvas``."""

    def __init__(self, canvas: Target, config: FitConfig) -> None:
        self._canvas, self._least = canvas, MARGIN * config.min_area

    def prefer(self, population: Population, removal_cost: Tensor | None) -> Tensor | None:
        """The costs of removal [N], those of small paths the least."""
        if self._least == 0.0 or removal_cost is None:
            return removal_cost
        return removal_cost.masked_fill(self._are_small(population), -torch.inf)

    def cut(self, population: Population, iteration: int, iterations: int) -> bool:
        """Remove the small paths if that is due after ``iteration`` of ``iterations``; whether any were."""
        if self._least == 0.0 or iteration not in [round(share * iterations) for share in CUTS]:
            return False
        small = self._are_small(population)
        if small.all() or not small.any():
            return False
        population.keep(~small)
        return True

    def _are_small(self, population: Population) -> Tensor:
        return self._canvas.visible_areas(faint(population.live))[:-1] / FAINT < self._least
