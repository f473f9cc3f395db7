"""The interface of a policy, which decides when paths are added and removed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from torch import Tensor

from warpvec.fit.population import Population
from warpvec.fit.state import State
from warpvec.geometry.scene import Scene


class Policy(Protocol):
    """A policy for one fit, made from the image, the settings and the number of the first generation."""

    def first_paths(self, background: Tensor) -> Scene:
        """Return the paths at the start, over ``background`` [3]."""

    def state(self) -> State:
        """Return everything that :meth:`restore` needs to continue to the same bits."""

    def check(self, state: State, iteration: int, path_count: int) -> int:
        """Return the highest generation that the fit's ``path_count`` paths may have after ``iteration``.

        Raises:
            InputError: ``state`` is none that :meth:`state` can have returned then.
        """

    def restore(self, state: State) -> None:
        """Continue from ``state``, which :meth:`check` has accepted."""

    def look(
        self, population: Population, iteration: int, iterations: int, squared_error: Callable[[Scene], Tensor]
    ) -> None:
        """Look at the paths before ``iteration`` (the first is 1) steps them; arguments as in :meth:`update`."""

    def looks_before(self, iteration: int, iterations: int) -> bool:
        """Return whether :meth:`look` before ``iteration`` (the first is 1) does something."""

    def is_due(self, iteration: int, iterations: int) -> bool:
        """Return whether :meth:`update` after ``iteration`` changes paths without their removal costs."""

    def wants_removal_cost(self, iteration: int, iterations: int) -> bool:
        """Return whether :meth:`update` after ``iteration`` (the first is 1) needs each path's removal cost."""

    def update(
        self,
        population: Population,
        iteration: int,
        iterations: int,
        removal_cost: Tensor | None,
        squared_error: Callable[[Scene], Tensor],
    ) -> bool:
        """Remove and add the paths that are due after ``iteration`` of ``iterations``; return whether any were due.

        Args:
            population: the paths to change.
            iteration: iterations done; the first is 1.
            iterations: iterations of the whole run.
            removal_cost: what the removal of each path [N] adds to the loss, if it was wanted.
            squared_error: returns a scene's squared error in each pixel [h, w].
        """
