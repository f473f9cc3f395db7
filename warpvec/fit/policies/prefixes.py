"""Fit levels of detail so that each prefix of the layers is a picture of its own.

A prefix is all paths up to some generation. Each step fits the whole picture and one prefix; the prefixes take turns.
Recycling in a generation looks at the picture up to that generation. Otherwise a prefix would be no more than the paths
that later generations build on.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit import schedule
from warpvec.fit.policies.scaffolding import Scaffolding
from warpvec.fit.population import Population
from warpvec.fit.state import State
from warpvec.fit.state_form import Form, integer
from warpvec.fit.target import Target
from warpvec.geometry.scene import Scene
from warpvec.rendering.tile_renderer import Adjoints

PREFIX_WEIGHT = 1.0
"""Weight of a prefix's loss beside the loss of all paths."""

TURN_GROWTH = 1.5
"""Turns of a generation for each turn of the generation below. A path takes part in the prefixes of its own and all
higher generations, so paths of higher generations take part in fewer. With equal turns the prefixes of 256 and 512
paths were 1.8 dB below fits of as many paths (kodim07), those of 32 and 64 only 0.5 dB."""

# The fractional parts of its multiples fill the unit interval evenly, however many there are.
_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)


def with_prefix(adjoints: Adjoints, scene: Scene, target: Target, count: int) -> Adjoints:
    """Return ``adjoints``, those of all paths, plus the weighted adjoints of a picture of the first ``count`` paths."""
    if count == len(scene):
        return adjoints
    names = ["color", "opacity", *(name for name in ("end_color", "geometry") if getattr(adjoints, name) is not None)]
    # The renderer writes into the same memory again.
    sums = {name: getattr(adjoints, name).clone() for name in ("segments", *names, "canvas_sums")}
    part = target.fit_step(scene.prefix(count), False)
    sums["segments"][: len(part.segments)] += PREFIX_WEIGHT * part.segments
    for name in names:
        sums[name][:count] += PREFIX_WEIGHT * getattr(part, name)
    sums["canvas_sums"][:3] += PREFIX_WEIGHT * part.background
    return replace(adjoints, **sums)


def prefix_length(counts: list[int], turn: int) -> int:
    """Return the number of paths in the prefix of this turn.

    ``counts`` are the paths up to each generation. All but the last take turns; a single generation has no prefix.
    """
    return counts[generation_at_turn(turn, len(counts) - 1) if len(counts) > 1 else -1]


def generation_at_turn(turn: int, count: int) -> int:
    """Return which of ``count`` generations has this turn."""
    total = sum(TURN_GROWTH**k for k in range(count))
    point = turn * _GOLDEN % 1.0 * total
    return next((k for k in range(count) if point < sum(TURN_GROWTH**j for j in range(k + 1))), count - 1)


class PrefixScaffolding(Scaffolding):
    """Algorithm 1 with recyclings that stay within one generation; the generations take turns."""

    def __init__(self, image: Tensor, config: FitConfig, first_generation: int, target: Target) -> None:
        super().__init__(image, config, first_generation)
        self._target = target
        self._turn = 0

    def state(self) -> State:
        """Return everything that :meth:`restore` needs to continue to the same bits."""
        return {**super().state(), "turn": self._turn}

    def _forms(self, iteration: int) -> dict[str, Form]:
        return {**super()._forms(iteration), "turn": integer(0, iteration)}

    def restore(self, state: State) -> None:
        """Continue from ``state``, which :meth:`check` has accepted."""
        super().restore(state)
        self._turn = state["turn"]

    def _recycle(self, population: Population, removal_cost: Tensor, squared_error: Callable[[Scene], Tensor]) -> None:
        """Move the least useful paths of one generation to where the picture of its prefix is worst.

        Paths whose ``removal_cost`` [N] is -inf go first: no picture wants them.
        """
        scene = population.scene
        generation = self._next_generation(scene)
        prefix = (scene.generation <= generation).nonzero().flatten()
        own = scene.generation[prefix] == generation
        cost = self._target.removal_costs(scene.select(prefix))
        cost = torch.where(removal_cost[prefix] == -torch.inf, -torch.inf, cost)
        count = int(int(own.sum()) * self._config.recycle_share)
        removed = cost.masked_fill(~own, torch.inf).topk(count, largest=False).indices
        if not len(removed):
            return
        keep = torch.ones(len(scene), dtype=torch.bool, device=cost.device)
        keep[removed] = False
        picture = scene.select(prefix[keep[prefix]])
        radius = schedule.recycling_radius(replace(self._config, curves=len(prefix)), self._height, self._width)
        new = self._spawn(len(removed), radius, squared_error(picture), scene.background)
        population.keep(keep)
        population.append(replace(new, generation=torch.full_like(new.generation, generation)))
        population.keep(population.live.generation.argsort(stable=True))

    def _next_generation(self, scene: Scene) -> int:
        """Return the generation whose turn it is, and end its turn."""
        generations = sorted(set(scene.generation.tolist()))
        self._turn += 1
        return generations[generation_at_turn(self._turn - 1, len(generations))]
