"""Remove paths below the smallest area that the settings allow, early enough to fit the others without them."""

from __future__ import annotations

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.population import Population
from warpvec.fit.target import Target
from warpvec.fit.visibility import FAINT, faint

CUTS = (0.75, 0.85, 0.95)
"""Shares of the iterations at which small paths are removed: after the last recycling, then what has shrunk since."""

MARGIN = 1.2
"""A cut removes paths smaller than this many times the allowed area. Paths shrink and grow until the end, and a path
that ends below the allowed area is left out of the file without a fit of the others."""


class SmallPaths:
    """The paths of less than ``config.min_area`` square pixels of ``target``."""

    def __init__(self, target: Target, config: FitConfig) -> None:
        self._target, self._area_min = target, MARGIN * config.min_area

    def prefer(self, population: Population, removal_cost: Tensor | None) -> Tensor | None:
        """Return ``removal_cost`` [N] with -inf for small paths, so that they are recycled first."""
        if self._area_min == 0.0 or removal_cost is None:
            return removal_cost
        return removal_cost.masked_fill(self._are_small(population), -torch.inf)

    def is_due(self, iteration: int, iterations: int) -> bool:
        """Return whether a cut is due after ``iteration`` of ``iterations``."""
        return self._area_min > 0.0 and iteration in [round(share * iterations) for share in CUTS]

    def cut(self, population: Population, iteration: int, iterations: int) -> bool:
        """Remove the small paths if a cut is due after ``iteration`` of ``iterations``; return whether it removed any.

        If all paths are small, it removes none.
        """
        if not self.is_due(iteration, iterations):
            return False
        small = self._are_small(population)
        if small.all() or not small.any():
            return False
        population.keep(~small)
        return True

    def _are_small(self, population: Population) -> Tensor:
        return self._target.visible_areas(faint(population.scene))[:-1] / FAINT < self._area_min
