"""Paths that go and come, in plain Python: lists of paths with their segments."""

from __future__ import annotations

from collections.abc import Sequence


def changed(
    segments: Sequence[Sequence[int]], cost: Sequence[float], drop_count: int, new: Sequence[Sequence[int]]
) -> tuple[list[int], list[list[int]]]:
    """Return the paths that stay by their number, new ones numbered after all, and the segments of each.

    The ``drop_count`` paths of the lowest ``cost`` go, of equal ones the first.
    """
    order = sorted(range(len(segments)), key=lambda path: cost[path])
    kept = sorted(order[drop_count:])
    paths = [*kept, *(len(segments) + k for k in range(len(new)))]
    return paths, [*(list(segments[path]) for path in kept), *(list(each) for each in new)]
