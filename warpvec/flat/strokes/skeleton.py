"""The skeleton of a shape: lines one pixel wide, as a graph of branches between ends and junctions."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats, Integers, Mask

AROUND = ((-1, 0), (-1, 1), (0, 1), (1, 1), (1, 0), (1, -1), (0, -1), (-1, -1))
"""Row and column of the eight neighbours, clockwise from above."""


class Graph(NamedTuple):
    """Branches of a skeleton.

    Attributes:
        branches: the pixels of each, row and column [M, 2], from its start to its end. Those of a closed one go round.
        ends: for each branch the junctions at its start and end, -1 for a free end; None for a closed one.
        junctions: the mean place of each junction [J, 2], row and column.
    """

    branches: list[Integers]
    ends: list[tuple[int, int] | None]
    junctions: Floats


def graph_of(skeleton: Mask) -> Graph:
    """Return the branches of a ``skeleton`` [h, w]."""
    pixels = np.argwhere(skeleton)
    number = np.full((skeleton.shape[0] + 2, skeleton.shape[1] + 2), -1)
    number[pixels[:, 0] + 1, pixels[:, 1] + 1] = np.arange(len(pixels))
    neighbors = [_neighbors(number, row + 1, column + 1) for row, column in pixels.tolist()]
    degree = np.array([len(each) for each in neighbors], dtype=np.int64)
    is_junction = np.zeros(skeleton.shape, bool)
    is_junction[tuple(pixels[degree > 2].T)] = True
    labels, count = ndimage.label(is_junction, np.ones((3, 3)))
    owner = np.where(degree > 2, labels[tuple(pixels.T)] - 1, -1) if len(pixels) else np.zeros(0, np.int64)
    centers = np.array([pixels[owner == k].mean(0) for k in range(count)]).reshape(-1, 2)
    branches, ends = _traced(neighbors, degree, owner)
    return Graph([pixels[branch] for branch in branches], ends, centers)


def _neighbors(number: Integers, row: int, column: int) -> list[int]:
    """Return the neighbours of a pixel; a diagonal one only if no pixel beside both lies between."""
    found = [int(number[row + r, column + c]) for r, c in AROUND]
    straight = [each for each in found[::2] if each >= 0]
    diagonal = [found[k] for k in (1, 3, 5, 7) if found[k] >= 0 and found[k - 1] < 0 and found[(k + 1) % 8] < 0]
    return straight + diagonal


def _traced(
    neighbors: list[list[int]], degree: Integers, owner: Integers
) -> tuple[list[list[int]], list[tuple[int, int] | None]]:
    branches: list[list[int]] = []
    ends: list[tuple[int, int] | None] = []
    used = np.zeros(len(neighbors), bool)
    starts = [
        (k, other) for k in range(len(neighbors)) if degree[k] > 2 for other in neighbors[k] if degree[other] <= 2
    ]
    for junction, first in starts:
        if not used[first]:
            chain, stop = _walk(neighbors, owner, used, junction, first)
            branches.append(chain)
            ends.append((int(owner[junction]), stop))
    for k in np.flatnonzero(degree <= 1).tolist():
        if used[k]:
            continue
        used[k] = True
        chain, stop = _walk(neighbors, owner, used, -1, neighbors[k][0]) if neighbors[k] else ([], -1)
        branches.append([k, *chain])
        ends.append((-1, stop))
    for k in np.flatnonzero((degree == 2) & ~used).tolist():
        if not used[k]:
            used[k] = True
            chain, _ = _walk(neighbors, owner, used, k, neighbors[k][0])
            branches.append([k, *chain])
            ends.append(None)
    return branches, ends


def _walk(neighbors: list[list[int]], owner: Integers, used: Mask, before: int, here: int) -> tuple[list[int], int]:
    """Follow pixels from ``here`` on, and return them, and the junction at the end or -1."""
    chain: list[int] = []
    if owner[here] >= 0:
        return chain, int(owner[here])
    while True:
        used[here] = True
        chain.append(here)
        onward = [k for k in neighbors[here] if k != before and not used[k]]
        into = [k for k in onward if owner[k] >= 0] or [
            k for k in neighbors[here] if owner[k] >= 0 and k != before and len(chain) > 1
        ]
        if into:
            return chain, int(owner[into[0]])
        if not onward:
            return chain, -1
        before, here = here, onward[0]
