"""Polygons of paths, and their area."""

from __future__ import annotations

from reference.flattening import flatten, uniform_counts
from torch import Tensor

EXACT = 1e-12
"""Tolerance for a few hundred float64 operations on values of canvas size; the worst error seen is 6e-14."""


def polygon_of(path: Tensor, count: int = 1) -> Tensor:
    return flatten(path[None], uniform_counts(path[None], count))[0]


def shoelace(polygon: Tensor) -> Tensor:
    following = polygon.roll(-1, 0)
    return 0.5 * (polygon[:, 0] * following[:, 1] - polygon[:, 1] * following[:, 0]).sum()
