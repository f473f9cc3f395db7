"""Move nodes to where they pay: replace the least valuable nodes by new ones where the residual is large.

`warpvec.fit.node_gains` predicts both. The number of segments stays at its mean for the paths, ``config.segments``.
"""

from __future__ import annotations

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.node_gains import merge_costs, node_values
from warpvec.fit.population import Population
from warpvec.fit.state import State
from warpvec.fit.state_form import check_fields, integer
from warpvec.geometry.quick_merge import quick_merges
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure
from warpvec.rendering.outline_adjoint import OutlineAdjoint

SEGMENTS_MIN = 2
"""Fewest segments of a loop that loses a node: a loop of one cubic is a drop with a tip."""

SHARE_MAX = 0.06
"""Largest share of the segments that one exchange moves."""

GAIN_MARGIN = 0.7
"""An exchange must gain this many times what it costs. Below 1, as a prediction sees only a moment of the fit."""

SEGMENTS_MAX = 32
"""Most segments of a path that gets a new node. The gains of a large path that others hide are guessed too high, as its
contrast is spread over all of its area: one such path along the frame of a photo got 200 segments. In fits of 256 paths
to kodim07 and kodim23 at 384 x 256 no path has more than 25, and the limit changes nothing."""

LENGTH_MIN = 4.0
"""Shortest segment in pixels that is divided; a shorter one cannot be told from its chord."""

SURPLUS_MAX = 2**24
"""Most segments beyond the mean that a saved fit can have."""


class NodeExchange:
    """Exchanges nodes of the paths of a fit.

    Args:
        config: the settings of the fit.
        start: the given paths that the fit begins with, if any: their segments beyond the mean are kept.
    """

    def __init__(self, config: FitConfig, start: Scene | None) -> None:
        self._config = config
        self._surplus = 0
        if start is not None:
            self._surplus = max(curve_count(start.structure) - config.segments * len(start), 0)

    def state(self) -> State:
        """Return everything that :meth:`restore` needs to continue to the same bits."""
        return {"surplus": self._surplus}

    def check(self, state: State) -> None:
        """Refuse ``state`` unless :meth:`state` can have returned it.

        Raises:
            InputError: it cannot.
        """
        check_fields("nodes", state, surplus=integer(0, SURPLUS_MAX))

    def restore(self, state: State) -> None:
        """Continue from ``state``, which :meth:`check` has accepted."""
        self._surplus = state["surplus"]

    def update(self, population: Population, outline: OutlineAdjoint, contrast: Tensor) -> bool:
        """Exchange nodes of the paths of ``population``; return whether any changed.

        The adjoint of their ``outline`` and their ``contrast`` are those of the last step, as in
        `warpvec.fit.node_gains.node_values`.
        """
        scene = population.scene.cpu()
        values = node_values(scene.structure, outline, contrast)
        merges = quick_merges(scene)
        gain, cost = self._eligible(scene.structure, values.gain, values.length, merge_costs(values, merges))
        excess = curve_count(scene.structure) - (self._surplus + self._config.segments * len(scene))
        drop, divide = choose(scene.structure, gain, cost, excess)
        device = population.live.segments.device
        if len(drop):
            population.merge(drop.to(device), merges.handles[drop].to(device), merges.share[drop].to(device))
        if len(divide):
            dropped_before = torch.zeros(len(gain), dtype=torch.int64).index_fill_(0, drop, 1).cumsum(0)
            population.split((divide - dropped_before[divide]).to(device))
        return len(drop) + len(divide) > 0

    def _eligible(self, structure: Structure, gain: Tensor, length: Tensor, cost: Tensor) -> tuple[Tensor, Tensor]:
        """Return the gains and costs [R]; for segments that must not change, 0 and infinity."""
        fixed, before = structure.lines, structure.segment_previous.long()
        loop_counts = structure.loop_first_segment.long().diff()
        is_small = (loop_counts <= SEGMENTS_MIN).repeat_interleave(loop_counts)
        gain = _within_room(structure, gain.masked_fill(fixed | (length < LENGTH_MIN), 0.0))
        return gain, cost.masked_fill(fixed | fixed[before] | is_small, torch.inf)


def _within_room(structure: Structure, gain: Tensor) -> Tensor:
    """Return ``gain`` [R] with 0 for all but the best of each path that `SEGMENTS_MAX` leaves room for."""
    path, first = structure.segment_path.long(), structure.path_first_segment.long()
    order = gain.argsort(descending=True, stable=True)
    order = order[path[order].argsort(stable=True)]
    rank = torch.empty_like(order)
    rank[order] = torch.arange(len(order)) - first[path[order]]
    return gain.masked_fill(rank >= (SEGMENTS_MAX - first.diff())[path], 0.0)


def curve_count(structure: Structure) -> int:
    """Return the number of segments that are no lines."""
    return int((~structure.lines).sum())


def choose(structure: Structure, gain: Tensor, cost: Tensor, excess: int) -> tuple[Tensor, Tensor]:
    """Return the rows at whose start the anchor goes, and the rows that are divided, both ascending.

    A path loses at most one node at a time. Segments that are merged are not divided.

    Args:
        structure: that of the scene.
        gain: what a node in each row gains [R].
        cost: what the anchor at its start is worth [R].
        excess: segments that there are too many; negative if there are too few.
    """
    moved_max = max(1, int(SHARE_MAX * len(gain)))
    path = structure.segment_path.long()
    cheapest = _cheapest_of_paths(path, cost, structure.path_count)
    cheapest = cheapest[cost[cheapest].argsort(stable=True)]
    cheapest = cheapest[cost[cheapest] < torch.inf][: moved_max + max(excess, 0)]
    best = gain.argsort(descending=True, stable=True)
    best = best[gain[best] > 0.0]
    drop_count = _exchange_count(gain[best[: moved_max + max(-excess, 0)]], cost[cheapest], excess)
    drop = cheapest[:drop_count]
    is_taken = torch.zeros_like(gain, dtype=torch.bool)
    is_taken[drop] = is_taken[structure.segment_previous.long()[drop]] = True
    divide = best[~is_taken[best]][: max(drop_count - excess, 0)]
    return drop.sort().values, divide.sort().values


def _cheapest_of_paths(path: Tensor, cost: Tensor, path_count: int) -> Tensor:
    """Return the row of the lowest ``cost`` [R] of each path [N]; the first one of equals."""
    order = cost.argsort(stable=True)
    order = order[path[order].argsort(stable=True)]
    first = torch.nn.functional.pad(path.bincount(minlength=path_count).cumsum(0), (1, 0))[:-1]
    return order[first]


def _exchange_count(gain: Tensor, cost: Tensor, excess: int) -> int:
    """Return how many nodes go, so that as many less ``excess`` come.

    ``gain`` descends and ``cost`` ascends; a pair is exchanged if it gains enough.
    """
    first_drop, first_new = max(excess, 0), max(-excess, 0)
    pairs = min(len(cost) - first_drop, len(gain) - first_new)
    if pairs <= 0:
        return min(first_drop, len(cost))
    pays = gain[first_new : first_new + pairs] > GAIN_MARGIN * cost[first_drop : first_drop + pairs]
    return first_drop + int(pays.long().cumprod(0).sum())
