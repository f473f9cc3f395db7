"""Who decides when paths come and go, and what a fit that begins with given paths asks of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from torch import Tensor

from warpvec.fit.population import Population
from warpvec.fit.state import State
from warpvec.geometry.scene import Scene


class Policy(Protocol):
    """Made for one target, one configuration, and the number of its first generation."""

    def first_paths(self, background: Tensor) -> Scene:
        """The paths at the start, over ``background`` [3]."""

    def state(self) -> State:
        """What :meth:`restore` needs to go on as if nothing had happened."""

    def restore(self, state: State) -> None:
        """Go on from ``state``."""

    def wants_removal_cost(self, iteration: int, iterations: int) -> bool:
        """Whether :meth:`update` after ``iteration`` (the first is 1) needs what each path's removal costs."""

    def update(
        self,
        population: Population,
        iteration: int,
        iterations: int,
        removal_cost: Tensor | None,
        squared_error: Callable[[Scene], Tensor],
    ) -> bool:
        """Remove and add what is due after ``iteration`` of ``iterations``; whether anything was.

        ``removal_cost`` [N] is there if it was wanted; ``squared_error`` gives a scene's error in each pixel [h, w].
        """
