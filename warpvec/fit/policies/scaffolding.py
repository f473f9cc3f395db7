"""Vector Scaffolding: paths come in generations, each smaller and above the last; and recycling, which goes past it."""

from __future__ import annotations

from collections.abc import Callable

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit import schedule
from warpvec.fit.placement import colors_at, new_paths, sample_positions
from warpvec.fit.population import Population
from warpvec.fit.state import State
from warpvec.fit.target import blank_error, paint_colors
from warpvec.geometry.scene import Scene

# Opacity of a new path: enough to be seen by the gradient at once, not enough to hide what it stands on.
_NEW_OPACITY = 0.5


class Scaffolding:
    """Algorithm 1 of the paper for ``target`` [h, w, 3 or 4]; when full, the recycling that ``config`` asks for.

    The first generation has the number ``first_generation``.
    """

    def __init__(self, target: Tensor, config: FitConfig, first_generation: int = 0) -> None:
        self._target, self._config, self._first_generation = target, config, first_generation
        self._colors = paint_colors(target)
        self._height, self._width = target.shape[:2]
        self._generator = torch.Generator().manual_seed(config.seed)
        self._generation = 0

    def first_paths(self, background: Tensor) -> Scene:
        """The first generation, where the target differs most from ``background`` [3]."""
        error = blank_error(self._target, background)
        return self._spawn(schedule.population(0, self._config), self._radius(0), error, background)

    def wants_removal_cost(self, iteration: int, iterations: int) -> bool:
        """Whether a recycling follows on ``iteration``, the first being 1: it needs each path's removal cost."""
        full = self._generation >= schedule.inflation_count(self._config)
        return full and schedule.is_recycling(iteration, self._config, iterations)

    def update(
        self,
        population: Population,
        iteration: int,
        iterations: int,
        removal_cost: Tensor | None,
        squared_error: Callable[[Scene], Tensor],
    ) -> bool:
        """What is due after ``iteration``; whether anything was."""
        generation = self._generation_due(iteration, iterations)
        if removal_cost is not None:
            self._recycle(population, removal_cost, squared_error)
        elif generation > self._generation:
            self._inflate(population, generation, squared_error)
        else:
            return False
        return True

    def state(self) -> State:
        """What :meth:`restore` needs to go on as if nothing had happened."""
        return {
            "generator": self._generator.get_state(),
            "generation": self._generation,
            "first_generation": self._first_generation,
        }

    def restore(self, state: State) -> None:
        """Go on from ``state``."""
        self._generator.set_state(state["generator"])
        self._generation, self._first_generation = state["generation"], state["first_generation"]

    def _generation_due(self, iteration: int, iterations: int) -> int:
        """The generation that the schedule has reached; several may fall on one iteration of a very short run."""
        steps = schedule.inflation_steps(self._config, iterations)
        return max(self._generation, sum(step <= iteration for step in steps))

    def _inflate(self, population: Population, generation: int, squared_error: Callable[[Scene], Tensor]) -> None:
        """One inflation of Algorithm 1: prune, halve the radius, spawn at the residual."""
        config = self._config
        before = len(population)
        population.keep(population.scene.opacity > config.prune_opacity)
        pruned = before - len(population)
        grown = schedule.population(generation, config) - schedule.population(self._generation, config)
        self._generation = generation
        count = grown + (pruned if config.compensate else 0)
        self._append(population, count, self._radius(generation), squared_error)

    def _recycle(self, population: Population, removal_cost: Tensor, squared_error: Callable[[Scene], Tensor]) -> None:
        """Move the paths whose removal costs least to where the residual is large."""
        count = int(len(population) * self._config.recycle_share)
        keep = torch.ones(len(removal_cost), dtype=torch.bool, device=removal_cost.device)
        keep[removal_cost.topk(count, largest=False).indices] = False
        population.keep(keep)
        self._generation = schedule.inflation_count(self._config) + 1
        radius = schedule.recycling_radius(self._config, self._height, self._width)
        self._append(population, count, radius, squared_error)

    def _append(
        self, population: Population, count: int, radius: float, squared_error: Callable[[Scene], Tensor]
    ) -> None:
        scene = population.scene
        population.append(self._spawn(count, radius, squared_error(scene), scene.background))

    def _spawn(self, count: int, radius: float, error: Tensor, background: Tensor) -> Scene:
        """``count`` circles at points drawn from the squared ``error`` [h, w], in the target's colours there."""
        centers = sample_positions(error, count, self._generator).to(self._target)
        color = colors_at(self._colors, centers)
        opacity = torch.full_like(centers[:, 0], _NEW_OPACITY)
        generation = self._first_generation + self._generation
        return new_paths(centers, (radius, radius), color, opacity, background, generation, self._config)

    def _radius(self, generation: int) -> float:
        return schedule.radius(generation, self._config, self._height, self._width)
