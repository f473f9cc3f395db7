"""Vector Scaffolding's policy as its authors' code has it, where the paper does not say otherwise.

Source: ironjr/vector-scaffolding at 2b11004: train_withsvg.py (the order of a step, pruning and spawning) and
gaussianimage_cholesky_svg.py (the first paths and the shape of new ones). What differs from
`warpvec.fit.policies.scaffolding`:

- The first paths lie at random places, in muted random colours, and each control point is jittered.
- R_base is half the mean distance of their centres to their nearest neighbours. Radii are in units of half a side on
  each axis, and have no floor.
- The control points of a new path lie on an ellipse, and so its outline lies inside of it: see `birth_points`.
- A new path has an opacity of 0.73, and lies at the centre of a pixel.
- The residual that places new paths is that of the image before the step and before the pruning.
- With ``side_opacities`` a path has three opacities, at one side, in the middle and at the other side. Pruning looks at
  that in the middle.
- Without ``compensate`` an inflation adds as many paths as there were before the pruning, times ``growth`` - 1. Removed
  paths are then missing for good, and the fit ends with fewer than N. The code does this; Algorithm 1 replaces them.

Places are drawn without replacement here, with replacement there. A generation of 512 paths on kodim07 would draw about
one pixel in a thousand twice.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit import schedule
from warpvec.fit.placement import colors_at
from warpvec.fit.policies.scaffolding import Scaffolding
from warpvec.fit.population import Population
from warpvec.generators import generator_of
from warpvec.geometry.scene import Scene
from warpvec.geometry.side_opacity import SideOpacity
from warpvec.paper.settings import paper_settings
from warpvec.paper.sides import Sides, birth_points

OPACITY_LOGIT = 1.0
"""Opacity logit of a new path: an opacity of 0.731."""

JITTER_LEAST = 0.5
"""The radius of each control point of the first paths is multiplied by a random number from this to 1."""

LONE_RADIUS = 0.5
"""R_base of a fit that starts with one path, which has no neighbour."""


class Stratification(Scaffolding):
    """Algorithm 1 for ``image`` [h, w, 3 or 4], by the rules of the authors' code; it never recycles."""

    def __init__(self, image: Tensor, config: FitConfig, first_generation: int = 0) -> None:
        super().__init__(image, config, first_generation)
        self._degree = Sides(config).degree
        self._half_sides = self._colors.new_tensor([self._width / 2, self._height / 2])
        # The first paths draw the same numbers from a generator of the same seed.
        first = _uniform((schedule.population(0, config), 2), generator_of(config.seed))
        self._base = base_radius(first)
        self._error: Tensor | None = None

    def first_paths(self, background: Tensor) -> Scene:
        """Return the first generation; nothing depends on the image."""
        count = schedule.population(0, self._config)
        center = 2.0 * self._half_sides * self._random(count, 2)
        color = self._random(count, 3).sigmoid()
        jitter = JITTER_LEAST + (1.0 - JITTER_LEAST) * self._random(count, 2 * self._degree)
        return self._paths(center, color, background, self._base, jitter)

    def look(
        self, population: Population, iteration: int, iterations: int, squared_error: Callable[[Scene], Tensor]
    ) -> None:
        """Keep the error of the present paths if an inflation follows ``iteration``, which is about to step them."""
        if self.looks_before(iteration, iterations):
            self._error = squared_error(population.scene)

    def looks_before(self, iteration: int, iterations: int) -> bool:
        """Return whether an inflation follows ``iteration``."""
        return self.is_due(iteration, iterations)

    def wants_removal_cost(self, iteration: int, iterations: int) -> bool:
        """Return False: nothing is recycled."""
        return False

    def _added_count(self, generation: int, before: int, pruned: int) -> int:
        if self._config.compensate:
            return super()._added_count(generation, before, pruned)
        return math.floor((self._config.growth - 1.0) * before + 0.5)

    def _append(
        self, population: Population, count: int, radius: float, squared_error: Callable[[Scene], Tensor]
    ) -> None:
        assert self._error is not None  # `look` came first
        population.append(self._spawn(count, radius, self._error, population.shown.background))
        self._error = None

    def _spawn(self, count: int, radius: float, error: Tensor, background: Tensor) -> Scene:
        center = self._centers(error, count).to(self._image).floor() + 0.5
        return self._paths(center, colors_at(self._colors, center), background, radius)

    def _paths(
        self, center: Tensor, color: Tensor, background: Tensor, radius: float, jitter: Tensor | None = None
    ) -> Scene:
        """Return paths at ``center`` [N, 2] px with a ``radius`` in half sides; ``jitter`` [N, P] scales each point."""
        reach = radius * self._half_sides
        points = birth_points(center, reach, self._degree, jitter)
        opacity = torch.full_like(center[:, 0], OPACITY_LOGIT).sigmoid()
        generation = torch.full((len(center),), self._first_generation + self._generation, device=center.device)
        scene = Scene.uniform(points, color, opacity, background, generation, self._degree)
        if self._config.opacity != "free" or not paper_settings(self._config).side_opacities:
            return scene
        return replace(scene, side_opacity=SideOpacity(opacity[:, None].repeat(1, 2)))

    def _radius(self, generation: int) -> float:
        """Return R_k in half sides."""
        return self._base * self._config.radius_decay**generation

    def _random(self, *shape: int) -> Tensor:
        return _uniform(shape, self._generator).to(self._colors)


def base_radius(center: Tensor) -> float:
    """Return R_base in half sides, from centres [N, 2] in sides: half the mean distance to the nearest neighbour."""
    if len(center) < 2:
        return LONE_RADIUS
    distance = torch.cdist(2.0 * center, 2.0 * center).fill_diagonal_(math.inf)
    return 0.5 * float(distance.min(1).values.mean())


def _uniform(shape: tuple[int, ...], generator: torch.Generator) -> Tensor:
    return torch.rand(shape, generator=generator, dtype=torch.float64)
