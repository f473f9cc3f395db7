"""The number of paths for a file of a given size, corrected while a fit still adds and removes paths."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from torch import Tensor

from warpvec.fit.population import Population
from warpvec.fit.trimming import is_trim_due, remove_cheapest
from warpvec.geometry.scene import Scene

STEP_MAX = 1.25
"""Largest factor by which one correction changes the number of paths. Young paths may take fewer bytes than
old ones."""


@dataclass
class ByteBudget:
    """The bytes of a file, and what its paths take of them.

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

        Those that turn out to be too many at the end of the fit are the ones that it misses least.
        """
        del loss, iteration, iterations
        per_path = self._bytes_per_path(scene, self.count_bytes(scene))
        wanted = (self.limit - self._empty_bytes(scene)) / per_path
        return max(1, min(math.floor(min(wanted, STEP_MAX * max(len(scene), 1))), self.curves_max))

    def is_trimming(self, iteration: int, iterations: int) -> bool:
        """Return whether :meth:`trim` is due after ``iteration`` (the first is 1), and needs each removal cost."""
        return is_trim_due(iteration, iterations)

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


class Budget(Protocol):
    """A rule for the number of paths while a fit runs: see `ByteBudget` and `warpvec.fit.psnr_budget`."""

    def wanted_count(self, scene: Scene, loss: float, iteration: int, iterations: int) -> int:
        """Return the number of paths for ``scene`` with ``loss`` after ``iteration`` of ``iterations``."""
        ...

    def is_trimming(self, iteration: int, iterations: int) -> bool:
        """Return whether paths are removed after ``iteration`` (the first is 1)."""
        ...

    def trim(self, population: Population, removal_cost: Tensor, loss: float) -> bool:
        """Remove paths that are too many, those of lowest ``removal_cost`` [N]; return whether there were any."""
        ...


class Written(NamedTuple):
    """Requirements of a file on the paths of a fit.

    Attributes:
        step: distance of the file's coordinates in pixels of the fitted image, across and down; None if the fit does
            not round.
        budget: the file's bytes or PSNR, None for any.
    """

    step: tuple[float, float] | None = None
    budget: Budget | None = None


ANY_FILE = Written()
"""Nothing is asked: the number of paths stays, and only the file rounds them."""
