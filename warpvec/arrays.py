"""Types of NumPy arrays, by the numbers that they hold, and small functions of arrays that NumPy lacks."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Floats32 = NDArray[np.float32]
Integers = NDArray[np.int64]
Integers32 = NDArray[np.int32]
Mask = NDArray[np.bool_]
Places = NDArray[np.intp]
"""Positions in an array, as `numpy.nonzero` returns them."""


def counted(counts: Integers) -> Integers:
    """Return 0, 1, ... below each of ``counts`` [n], one run after the other."""
    return np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)


def blocks(count: int, size: int) -> list[slice]:
    """Return the slices of up to ``size`` rows that ``count`` rows consist of; one of no rows if there are none."""
    return [slice(start, min(start + size, count)) for start in range(0, max(count, 1), size)]


def dot(first: Floats, second: Floats) -> Floats:
    """Return the dot products [...] of vectors [..., 2]; a sum over so short an axis takes several times as long."""
    product: Floats = first[..., 0] * second[..., 0] + first[..., 1] * second[..., 1]
    return product


def lengths_of(vectors: Floats) -> Floats:
    """Return the lengths [...] of vectors [..., 2]."""
    lengths: Floats = np.sqrt(dot(vectors, vectors))
    return lengths


def reached(points: Floats) -> Floats:
    """Return how far along a polyline each of its ``points`` [M, 2] lies [M]."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])


def interpolated(places: NDArray[Any], known: NDArray[Any], values: NDArray[Any]) -> Floats:
    """Return ``values`` [N, C] at ``places`` [...], linearly between those that are ``known`` [N], as [..., C]."""
    return np.stack([np.interp(places, known, column) for column in values.T], -1)


def turn_between(first: Floats, second: Floats) -> Floats:
    """Return the angles in radians [...] from vectors [..., 2] to others: above 0 where the turn is from x to y."""
    turn: Floats = np.arctan2(cross(first, second), dot(first, second))
    return turn


def cross(first: Floats, second: Floats) -> Floats:
    """Return the cross products [...] of vectors [..., 2]: above 0 where the turn is from x to y."""
    product: Floats = first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]
    return product
