"""The number of paths of a fit that follows a goal, corrected while the fit still adds and removes paths."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from torch import Tensor

from warpvec.fit.population import Population
from warpvec.fit.written_grid import ROUNDING_START
from warpvec.geometry.scene import Scene
from warpvec.image.metrics import psnr_from_mse

STEP_MAX = 1.25
"""Largest factor by which one correction changes the number of paths. Young paths may take fewer bytes than old paths,
and show their worth later."""

TRIM_GAP = 0.02
"""Share of the iterations between two removals near the end."""

AIM = 0.25
"""Decibels above the target that the corrections lead to. What is left of them near the end pays for fewer paths."""

TRIM_AIM, TRIM_SHARE = 0.06, 0.7
"""Decibels above the target at which no more paths are removed near the end, and the share of the error up to there
that one removal may add. Each cost is that of one path alone; together they cost more."""

SLOPE = 2.5
"""Decibels gained by doubling the paths. It decides how fast the corrections settle, not where."""

LATER_GAIN = 2000.0
"""Decibels times iterations that a fit of constant paths still gains at its start, about. After a share s it is
(1 - s)^3 of that: with 400 iterations three photos of 150 paths gained 1.2 (0.5 to 1.7) from 0.4 on, and with 1,200
iterations 0.3."""


class Budget(Protocol):
    """A rule for the number of paths while a fit runs: see `ByteBudget` and `QualityBudget`."""

    def wanted_count(self, scene: Scene, loss: float, iteration: int, iterations: int) -> int:
        """Return the number of paths for ``scene`` with ``loss`` after ``iteration`` of ``iterations``."""
        ...

    def trim(self, population: Population, removal_cost: Tensor, loss: float) -> bool:
        """Remove paths that are too many, those of lowest ``removal_cost`` [N]; return whether there were any."""
        ...


@dataclass
class ByteBudget:
    """A budget of bytes for a file, and the bytes of its paths.

    Attributes:
        limit: most bytes of the file.
        count_bytes: returns the bytes of the file of a scene in pixels of the fitted image.
        curves_max: most paths.
    """

    limit: int
    count_bytes: Callable[[Scene], int]
    curves_max: int
    _empty: int | None = None

    def wanted_count(self, scene: Scene, loss: float, iteration: int, iterations: int) -> int:
        """Return how many paths like those of ``scene`` the file has room for.

        Paths that are too many at the end of the fit are removed by `trim`.
        """
        del loss, iteration, iterations
        per_path = self._bytes_per_path(scene, self.count_bytes(scene))
        wanted = (self.limit - self._empty_bytes(scene)) / per_path
        return max(1, min(math.floor(min(wanted, STEP_MAX * max(len(scene), 1))), self.curves_max))

    def trim(self, population: Population, removal_cost: Tensor, loss: float) -> bool:
        """Remove the paths of lowest ``removal_cost`` [N] that are too many; return whether there were any."""
        del loss
        scene = population.live
        bytes_used = self.count_bytes(scene)
        excess = bytes_used - self.limit
        if excess <= 0:
            return False
        return remove_cheapest(population, removal_cost, math.ceil(excess / self._bytes_per_path(scene, bytes_used)))

    def _bytes_per_path(self, scene: Scene, bytes_used: int) -> float:
        """Return the mean bytes of a path of ``scene``, whose file has ``bytes_used``; more than 0."""
        return max(bytes_used - self._empty_bytes(scene), 1) / max(len(scene), 1)

    def _empty_bytes(self, scene: Scene) -> int:
        if self._empty is None:
            self._empty = self.count_bytes(scene.prefix(0))
        return self._empty


@dataclass
class QualityBudget:
    """The quality that a file must reach, with as few paths as possible.

    Attributes:
        target: quality of the file in decibels, as the PSNR is; see `warpvec.goals.quantity.Quantity.decibels`.
        curves_max: most paths.
        measure: returns the quality of the file of a scene in pixels of the fitted image. It is called twice.
    """

    target: float
    curves_max: int
    measure: Callable[[Scene], float]
    _offset: float | None = None
    _is_trimmed: bool = False

    def wanted_count(self, scene: Scene, loss: float, iteration: int, iterations: int) -> int:
        """Return how many paths would have the quality at the end, from the ``loss`` of ``scene``."""
        if self._offset is None:
            self._offset = self._offset_of(scene, loss)
        later = LATER_GAIN / iterations * (1.0 - iteration / iterations) ** 3
        missing = self.target + AIM - (psnr_from_mse(loss) + self._offset + later)
        factor = 2.0 ** max(-8.0, min(missing / SLOPE, 8.0))
        count = round(max(len(scene), 1) * max(1.0 / STEP_MAX, min(factor, STEP_MAX)))
        return max(1, min(count, self.curves_max))

    def trim(self, population: Population, removal_cost: Tensor, loss: float) -> bool:
        """Remove the paths of lowest ``removal_cost`` [N] that the quality does not need; return whether any were."""
        scene = population.live
        if not self._is_trimmed:  # the drawing is rounded since, and so the file is near
            self._offset, self._is_trimmed = self._offset_of(scene, loss), True
        assert self._offset is not None
        allowed = 10.0 ** (-(self.target + TRIM_AIM - self._offset) / 10.0)
        costs = removal_cost.clamp_min(0.0).sort().values
        count = int((costs.cumsum(0) <= TRIM_SHARE * (allowed - loss)).sum())
        return remove_cheapest(population, removal_cost, count)

    def _offset_of(self, scene: Scene, loss: float) -> float:
        """Return the quality of the file minus the PSNR of the ``loss``; 0 if one of them is infinite."""
        offset = self.measure(scene) - psnr_from_mse(loss)
        return offset if math.isfinite(offset) else 0.0


class Written(NamedTuple):
    """Requirements of a file on the paths of a fit.

    Attributes:
        step: distance of the file's coordinates in pixels of the fitted image, across and down; None if the fit does
            not round.
        budget: rule for the number of paths; None to keep the number.
    """

    step: tuple[float, float] | None = None
    budget: Budget | None = None


ANY_FILE = Written()
"""Nothing is asked: the number of paths stays, and only the file rounds them."""


def is_trim_due(iteration: int, iterations: int) -> bool:
    """Return whether paths are removed after ``iteration`` (the first is 1): the drawing is rounded by then."""
    first = math.ceil(ROUNDING_START * iterations)
    return iteration >= first and (iteration - first) % max(1, int(TRIM_GAP * iterations)) == 0


def remove_cheapest(population: Population, removal_cost: Tensor, count: int) -> bool:
    """Remove the ``count`` paths of lowest ``removal_cost`` [N], but not the last path; return whether any were."""
    count = min(count, len(population.live) - 1)
    if count < 1:
        return False
    population.remove(removal_cost.topk(count, largest=False).indices)
    return True
