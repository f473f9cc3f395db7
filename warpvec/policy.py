"""Who decides when paths come and go, and what a fit that begins with given paths asks of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

from torch import Tensor

from warpvec import schedule
from warpvec.canvas import Canvas
from warpvec.checkpoint import State
from warpvec.config import FitConfig
from warpvec.errors import InputError
from warpvec.levels import LeveledScaffolding
from warpvec.population import Population
from warpvec.replacement import Replacement
from warpvec.scaffolding import Scaffolding
from warpvec.scene import Scene


class Policy(Protocol):
    """Made for one target, one configuration, and the number of its first generation."""

    def first_paths(self, background: Tensor) -> Scene:
        """The paths at the start, over ``background`` [3]."""

    def state(self) -> State:
        """What :meth:`restore` needs to go on as if nothing had happened."""

    def restore(self, state: State) -> None:
        """Go on from ``state``."""

    def wants_removal(self, iteration: int, iterations: int) -> bool:
        """Whether :meth:`update` after ``iteration`` (the first is 1) needs what each path's removal costs."""

    def update(
        self,
        population: Population,
        iteration: int,
        iterations: int,
        removal: Tensor | None,
        squared_error: Callable[[Scene], Tensor],
    ) -> bool:
        """Remove and add what is due after ``iteration`` of ``iterations``; whether anything was.

        ``removal`` [N] is there if it was wanted; ``squared_error`` gives a scene's error in each pixel [h, w].
        """


POLICIES: dict[str, Callable[[Tensor, FitConfig, int], Policy]] = {
    "scaffolding": Scaffolding,
    "replacement": Replacement,
}
"""The name of a policy in the settings -> the policy."""


def make_policy(target: Tensor, config: FitConfig, first_generation: int, canvas: Canvas) -> Policy:
    """The policy of ``config`` for ``target`` [h, w, 3 or 4], which ``canvas`` compares with."""
    if config.lod:
        return LeveledScaffolding(target, config, first_generation, canvas)
    return POLICIES[config.policy](target, config, first_generation)


def going_on(config: FitConfig, start: Scene, height: int, width: int) -> FitConfig:
    """The settings for a fit of a canvas [height, width] that begins with ``start``.

    Raises:
        InputError: the policy does not go on from given paths, or the paths are not of the model of ``config``.
    """
    if config.policy != "scaffolding":
        raise InputError(f"policy must be scaffolding to go on from a scene, got {config.policy!r}; give scaffolding")
    pieces = config.segments if config.path_model == "segments" else 2
    if (start.degree, start.piece_count) != (config.point_degree, pieces):
        raise InputError(
            f"start must have {pieces} curves of degree {config.point_degree} a path, as the settings say, got"
            f" {start.piece_count} of degree {start.degree}; change path_model, segments or degree"
        )
    return schedule.continued(config, len(start), height, width)
