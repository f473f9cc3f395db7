"""The number of paths for a file of a given PSNR, corrected while a fit still adds and removes paths."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from torch import Tensor

from warpvec.fit.population import Population
from warpvec.fit.trimming import is_trim_due, remove_cheapest
from warpvec.geometry.scene import Scene
from warpvec.image.metrics import psnr_from_mse

AIM = 0.25
"""Decibels above the target that the corrections lead to. What is left of them near the end pays for fewer paths."""

TRIM_AIM, TRIM_SHARE = 0.06, 0.7
"""Decibels above the target at which no more paths are removed near the end, and the share of the error up to there
that one removal may add. Each cost is that of one path alone; together they cost more."""

SLOPE = 2.5
"""Decibels gained by doubling the paths. It decides how fast the corrections settle, not where."""

STEP_MAX = 1.25
"""Largest factor by which one correction changes the number of paths, as the new ones show their worth later."""

LATER_GAIN = 2000.0
"""Decibels times iterations that a fit of constant paths still gains at its start, about. After a share s it is
(1 - s)^3 of that: with 400 iterations three photos of 150 paths gained 1.2 (0.5 to 1.7) from 0.4 on, and with 1,200
iterations 0.3."""


@dataclass
class PsnrBudget:
    """The PSNR that a file must reach, with as few paths as possible.

    Attributes:
        target: PSNR in dB of the file.
        curves_max: most paths.
        measure: returns the PSNR in dB of the file of a scene in pixels of the fitted image. It is called twice.
    """

    target: float
    curves_max: int
    measure: Callable[[Scene], float]
    _offset: float | None = None
    _is_trimmed: bool = False

    def wanted_count(self, scene: Scene, loss: float, iteration: int, iterations: int) -> int:
        """Return how many paths would have the PSNR at the end, from the ``loss`` of ``scene`` after ``iteration``."""
        if self._offset is None:
            self._offset = self._offset_of(scene, loss)
        later = LATER_GAIN / iterations * (1.0 - iteration / iterations) ** 3
        missing = self.target + AIM - (psnr_from_mse(loss) + self._offset + later)
        factor = 2.0 ** max(-8.0, min(missing / SLOPE, 8.0))
        count = round(max(len(scene), 1) * max(1.0 / STEP_MAX, min(factor, STEP_MAX)))
        return max(1, min(count, self.curves_max))

    def is_trimming(self, iteration: int, iterations: int) -> bool:
        """Return whether :meth:`trim` is due after ``iteration`` (the first is 1), and needs each removal cost."""
        return is_trim_due(iteration, iterations)

    def trim(self, population: Population, removal_cost: Tensor, loss: float) -> bool:
        """Remove the paths of lowest ``removal_cost`` [N] that the PSNR does not need; return whether any were."""
        scene = population.live
        if not self._is_trimmed:  # the drawing is rounded since, and so the file is near
            self._offset, self._is_trimmed = self._offset_of(scene, loss), True
        assert self._offset is not None
        allowed = 10.0 ** (-(self.target + TRIM_AIM - self._offset) / 10.0)
        costs = removal_cost.clamp_min(0.0).sort().values
        count = int((costs.cumsum(0) <= TRIM_SHARE * (allowed - loss)).sum())
        return remove_cheapest(population, removal_cost, count)

    def _offset_of(self, scene: Scene, loss: float) -> float:
        """Return by how much the PSNR of the file is above that of the ``loss``; 0 if one of them is infinite."""
        offset = self.measure(scene) - psnr_from_mse(loss)
        return offset if math.isfinite(offset) else 0.0
