"""Vector Scaffolding's policy: add paths in generations, each smaller and on top of the last; then recycle paths.

Recycling goes beyond the paper.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit import schedule
from warpvec.fit.placement import colors_at, new_paths, sample_positions
from warpvec.fit.places import Places
from warpvec.fit.policies.generator import generator_state
from warpvec.fit.population import Population
from warpvec.fit.state import State
from warpvec.fit.state_form import Form, check_fields, integer, require
from warpvec.fit.target import blank_error, opaque_colors
from warpvec.generators import generator_of
from warpvec.geometry.scene import Scene

# Opacity of a new path: enough for a useful gradient at once, and too little to hide the paths below.
_NEW_OPACITY = 0.5

GENERATION_MAX = 999_999_999
"""Highest number of the first generation: the ids of groups in a file, from which a fit may begin, have nine digits."""


class Scaffolding:
    """Algorithm 1 of the paper for ``image`` [h, w, 3 or 4], and the recycling of ``config`` once there are N paths.

    The first generation has the number ``first_generation``.
    """

    def __init__(self, image: Tensor, config: FitConfig, first_generation: int = 0) -> None:
        self._image, self._config, self._first_generation = image, config, first_generation
        self._colors = opaque_colors(image)
        self._height, self._width = image.shape[:2]
        self._generator = generator_of(config.seed)
        self._generation = 0
        self._places: Places | None = None  # where paths have memory with room, as for a graph
        self._added = 0  # paths that the next recycling adds beyond those that it removes, if it is positive

    def first_paths(self, background: Tensor) -> Scene:
        """Return the first generation, placed where the image differs most from ``background`` [3]."""
        error = blank_error(self._image, background)
        return self._spawn(schedule.population(0, self._config), self._radius(0), error, background)

    def look(
        self, population: Population, iteration: int, iterations: int, squared_error: Callable[[Scene], Tensor]
    ) -> None:
        """Do nothing: new paths lie where the image is wrong after the step."""

    def looks_before(self, iteration: int, iterations: int) -> bool:
        """Return False: :meth:`look` does nothing."""
        return False

    def is_due(self, iteration: int, iterations: int) -> bool:
        """Return whether an inflation follows ``iteration``."""
        return self._generation_due(iteration, iterations) > self._generation

    def wants_removal_cost(self, iteration: int, iterations: int) -> bool:
        """Return whether a recycling follows ``iteration`` (the first is 1); it needs each path's removal cost."""
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
        """Recycle or add the paths that are due after ``iteration``; return whether any were due."""
        generation = self._generation_due(iteration, iterations)
        if removal_cost is not None:
            self._recycle(population, removal_cost, squared_error)
        elif generation > self._generation:
            self._inflate(population, generation, squared_error)
        else:
            return False
        return True

    def resize(self, count: int, present: int) -> None:
        """Let the next recycling lead from ``present`` paths to ``count``."""
        self._config = replace(self._config, curves=count)
        self._added = count - present

    def state(self) -> State:
        """Return everything that :meth:`restore` needs to continue to the same bits."""
        return {
            "generator": self._generator.get_state(),
            "generation": self._generation,
            "first_generation": self._first_generation,
        }

    def check(self, state: State, iteration: int, path_count: int) -> int:
        """Return the highest generation that the fit's ``path_count`` paths may have after ``iteration``.

        Raises:
            InputError: ``state`` is none that :meth:`state` can have returned then.
        """
        check_fields("policy", state, **self._forms(iteration))
        generation: int = state["generation"]
        is_possible = 1 <= path_count <= schedule.population(generation, self._config)
        require(is_possible, "policy.generation", f"cannot have {path_count} paths")
        return generation + int(state["first_generation"])

    def _forms(self, iteration: int) -> dict[str, Form]:
        return {
            "generator": generator_state(self._config.seed),
            "generation": integer(0, schedule.inflation_count(self._config) + 1),  # recycled paths are the last one
            "first_generation": integer(0, GENERATION_MAX),
        }

    def restore(self, state: State) -> None:
        """Continue from ``state``, which :meth:`check` has accepted."""
        self._generator.set_state(state["generator"])
        self._generation, self._first_generation = state["generation"], state["first_generation"]

    def _generation_due(self, iteration: int, iterations: int) -> int:
        """Return the generation that the schedule has reached; a very short run may skip some."""
        steps = schedule.inflation_steps(self._config, iterations)
        return max(self._generation, sum(step <= iteration for step in steps))

    def _inflate(self, population: Population, generation: int, squared_error: Callable[[Scene], Tensor]) -> None:
        """Do one inflation of Algorithm 1: prune, halve the radius, add paths where the residual is large."""
        config = self._config
        before = len(population)
        population.keep(population.scene.opacity > config.prune_opacity)
        count = self._added_count(generation, before, before - len(population))
        self._generation = generation
        self._append(population, count, self._radius(generation), squared_error)

    def _added_count(self, generation: int, before: int, pruned: int) -> int:
        """Return how many paths the inflation to ``generation`` adds, after ``pruned`` of ``before`` were removed."""
        config = self._config
        grown = schedule.population(generation, config) - schedule.population(self._generation, config)
        return grown + (pruned if config.compensate else 0)

    def _recycle(self, population: Population, removal_cost: Tensor, squared_error: Callable[[Scene], Tensor]) -> None:
        """Move the paths with the lowest removal cost to where the residual is large."""
        count = max(int(len(population) * self._config.recycle_share), -self._added)
        population.remove_cheapest(removal_cost, count)
        self._generation = schedule.inflation_count(self._config) + 1
        radius = schedule.recycling_radius(self._config, self._height, self._width)
        self._append(population, count + self._added, radius, squared_error)
        self._added = 0

    def _append(
        self, population: Population, count: int, radius: float, squared_error: Callable[[Scene], Tensor]
    ) -> None:
        shown = population.shown
        if population.padded is not None and self._places is None:
            self._places = Places(str(shown.color.device))
        population.append(self._spawn(count, radius, squared_error(shown), shown.background))

    def _spawn(self, count: int, radius: float, error: Tensor, background: Tensor) -> Scene:
        """Make ``count`` circles at points drawn by the squared ``error`` [h, w], in the image's colours there."""
        centers = self._centers(error, count).to(self._image)
        color = colors_at(self._colors, centers)
        opacity = torch.full_like(centers[:, 0], _NEW_OPACITY)
        generation = self._first_generation + self._generation
        return new_paths(centers, (radius, radius), color, opacity, background, generation, self._config)

    def _centers(self, error: Tensor, count: int) -> Tensor:
        """Draw ``count`` positions [count, 2] by the squared ``error`` [h, w]."""
        draw = sample_positions if self._places is None else self._places.draw
        return draw(error, count, self._generator)

    def _radius(self, generation: int) -> float:
        return schedule.radius(generation, self._config, self._height, self._width)
