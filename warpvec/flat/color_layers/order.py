"""Order the paths of a drawing so that those of one group lie in few layers, and the picture stays the same."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from warpvec.arrays import Integers


def few_layers(group: Integers, overlaps: NDArray[np.bool_]) -> list[list[int]]:
    """Return layers of paths, the lowest first, each of one group.

    Of two paths that overlap, the lower one stays below. A layer takes all paths of its group that can lie in it. To
    find the fewest layers is NP-hard; this takes the better one of two greedy orders.

    Args:
        group: group of each path [N], from 0 on. The paths are in their painting order.
        overlaps: which paths overlap [N, N].
    """
    lower = np.tril(overlaps, -1)
    left = _layers_left(group, lower.T)
    orders = (_greedy(group, lower, left, choose) for choose in (_most_paths, _largest_share))
    return min(orders, key=len)


def _layers_left(group: Integers, upper: NDArray[np.bool_]) -> Integers:
    """Return how many layers of each group [N, G] every order has from each path upward, the path included.

    It is the largest number of times that a chain of overlapping paths enters the group.
    """
    left = np.zeros((len(group), int(group.max(initial=-1)) + 1), np.int64)
    for path in reversed(range(len(group))):
        above, own = np.flatnonzero(upper[path]), group[path]
        left[path] = left[above].max(0, initial=0)
        entered = left[above, own] + (group[above] != own)
        left[path, own] = entered.max(initial=1)
    return left


_Choose = Callable[[int, int], float]
"""What a layer is worth: by how many paths it takes, and how many its group has left."""


def _most_paths(taken: int, waiting: int) -> float:
    return float(taken)


def _largest_share(taken: int, waiting: int) -> float:
    return taken / waiting


def _greedy(group: Integers, lower: NDArray[np.bool_], left: Integers, worth: _Choose) -> list[list[int]]:
    """Return layers, each the best one left: its group then needs fewer, or else it has most ``worth``."""
    waiting = {number: np.flatnonzero(group == number).tolist() for number in dict.fromkeys(group.tolist())}
    is_done = np.zeros(len(group), bool)
    layers: list[list[int]] = []
    while waiting:
        found: list[tuple[tuple[bool, float], int, list[int]]] = []
        for number, paths in waiting.items():
            taken = _free(paths, lower, is_done)
            if taken:
                rest = [path for path in paths if path not in set(taken)]
                is_less = left[rest, number].max(initial=0) < left[paths, number].max()
                found.append(((bool(is_less), worth(len(taken), len(paths))), number, taken))
        _, number, taken = max(found, key=lambda each: each[0])
        layers.append(taken)
        is_done[taken] = True
        waiting[number] = [path for path in waiting[number] if not is_done[path]]
        if not waiting[number]:
            del waiting[number]
    return layers


def _free(paths: list[int], lower: NDArray[np.bool_], is_done: NDArray[np.bool_]) -> list[int]:
    """Return those of the ``paths`` of a group that may be next: below them lie only others of these, and done ones."""
    blocked = ~is_done
    taken = []
    for path in paths:
        if not (lower[path] & blocked).any():
            taken.append(path)
            blocked[path] = False
    return taken
