"""Levels of detail that each make a picture: the paths up to any generation are fitted as a picture of their own too.

With every step on all paths goes one on the paths up to a lower generation, each in its turn, and the recycling of a
generation looks at the picture that ends with it. So a prefix of the layers is not what a later one left of it.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit import schedule
from warpvec.fit.policies.scaffolding import Scaffolding
from warpvec.fit.population import Population
from warpvec.fit.state import State
from warpvec.fit.target import Target
from warpvec.geometry.scene import Scene

PREFIX_WEIGHT = 1.0
"""Of the error of a prefix, beside that of all paths."""

TURN_GROWTH = 1.5
"""A generation has so many turns for each one of the generation below: a path is in the prefixes of all generations
from its own on, so the paths of the higher ones take part in fewer. With equal turns the prefixes of 256 and 512 paths
were 1.8 dB below fits of as many paths (kodim07), those of 32 and 64 only 0.5."""

# The last tensor of generations, and the paths up to each: a population has a new one when paths come or go.
_counted: tuple[Tensor, list[int]] | None = None

# Multiples of it, without their whole part, fill the unit interval evenly however many there are.
_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


def with_prefix(adjoints: Any, scene: Scene, canvas: Target, iteration: int) -> Any:
    """``adjoints`` of all paths, and those of the paths up to the generation whose turn it is at ``iteration``."""
    count = _prefix_count(scene, iteration)
    if count == len(scene):
        return adjoints
    names = ("points", "color", "opacity")
    # The renderer writes into the same memory again.
    sums = {name: getattr(adjoints, name).clone() for name in (*names, "canvas")}
    part = canvas.fit_step(scene.select(torch.arange(count, device=scene.points.device)), False)
    for name in names:
        sums[name][:count] += PREFIX_WEIGHT * getattr(part, name)
    sums["canvas"][:3] += PREFIX_WEIGHT * part.background
    return replace(adjoints, **sums)


def _prefix_count(scene: Scene, turn: int) -> int:
    """Paths up to one of the generations but the last, which take turns; all if there is one only."""
    counts = _prefix_counts(scene.generation)
    if len(counts) < 2:
        return len(scene)
    return counts[_whose_turn(turn, len(counts) - 1)]


def _prefix_counts(generation: Tensor) -> list[int]:
    """Paths up to each of the generations; read from the device once for every tensor, which nobody writes into."""
    global _counted
    known = _counted
    if known is None or known[0] is not generation:
        values = sorted(generation.tolist())
        known = _counted = generation, [bisect_right(values, level) for level in sorted(set(values))]
    return known[1]


def _whose_turn(turn: int, count: int) -> int:
    """Which of ``count`` generations has this turn."""
    total = sum(TURN_GROWTH**k for k in range(count))
    point = turn * _GOLDEN % 1.0 * total
    return next((k for k in range(count) if point < sum(TURN_GROWTH**j for j in range(k + 1))), count - 1)


def _generations(scene: Scene) -> list[int]:
    """Those of the paths, ascending."""
    return sorted(set(scene.generation.tolist()))


class PrefixScaffolding(Scaffolding):
    """Algorithm 1, with recyclings that stay within a generation: the generations take turns, the last every other."""

    def __init__(self, target: Tensor, config: FitConfig, first_generation: int, canvas: Target) -> None:
        super().__init__(target, config, first_generation)
        self._canvas = canvas
        self._turn = 0

    def state(self) -> State:
        """What :meth:`restore` needs to go on as if nothing had happened."""
        return {**super().state(), "turn": self._turn}

    def restore(self, state: State) -> None:
        """Go on from ``state``."""
        super().restore(state)
        self._turn = state["turn"]

    def _recycle(self, population: Population, removal_cost: Tensor, squared_error: Callable[[Scene], Tensor]) -> None:
        """Move paths of one generation that are missed least, there, to where its picture is worst.

        Those whose ``removal_cost`` [N] is -inf go first: they are not wanted in any picture.
        """
        scene = population.scene
        level = self._next_level(scene)
        prefix = (scene.generation <= level).nonzero().flatten()
        own = scene.generation[prefix] == level
        cost = self._canvas.fit_step(scene.select(prefix), True).removal_cost
        cost = torch.where(removal_cost[prefix] == -torch.inf, -torch.inf, cost)
        removed = cost.masked_fill(~own, torch.inf).topk(
            int(int(own.sum()) * self._config.recycle_share), largest=False
        )
        if not len(removed.indices):
            return
        keep = torch.ones(len(scene), dtype=torch.bool, device=cost.device)
        keep[removed.indices] = False
        picture = scene.select(prefix[keep[prefix]])
        radius = schedule.recycling_radius(replace(self._config, curves=len(prefix)), self._height, self._width)
        new = self._spawn(len(removed.indices), radius, squared_error(picture), scene.background)
        population.keep(keep)
        population.append(replace(new, generation=torch.full_like(new.generation, level)))
        population.keep(population.live.generation.argsort(stable=True))

    def _next_level(self, scene: Scene) -> int:
        """The generation whose turn it is."""
        generations = _generations(scene)
        self._turn += 1
        return generations[_whose_turn(self._turn - 1, len(generations))]
