"""Remove paths near the end of a fit, when its file is known exactly."""

from __future__ import annotations

import math

import torch
from torch import Tensor

from warpvec.fit.population import Population
from warpvec.fit.written_grid import ROUNDING_START

TRIM_GAP = 0.02
"""Share of the iterations between two removals."""


def is_trim_due(iteration: int, iterations: int) -> bool:
    """Return whether paths are removed after ``iteration`` (the first is 1): the drawing is rounded by then."""
    first = math.ceil(ROUNDING_START * iterations)
    return iteration >= first and (iteration - first) % max(1, int(TRIM_GAP * iterations)) == 0


def remove_cheapest(population: Population, removal_cost: Tensor, count: int) -> bool:
    """Remove the ``count`` paths of lowest ``removal_cost`` [N], but not the last path; return whether any were."""
    count = min(count, len(population.live) - 1)
    if count < 1:
        return False
    keep = torch.ones(len(removal_cost), dtype=torch.bool, device=removal_cost.device)
    keep[removal_cost.topk(count, largest=False).indices] = False
    population.keep(keep)
    return True
