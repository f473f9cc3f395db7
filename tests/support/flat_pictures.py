"""Small pictures and assignments whose regions are known by construction, for tests of flat art."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from warpvec.flat.regions.assignment import Assignment
from warpvec.flat.regions.paints import Paints
from warpvec.geometry.paints.registry import FLAT

Floats = NDArray[np.float32]


def opaque(colors: NDArray[np.floating]) -> Floats:  # type: ignore[type-arg]
    """Return the picture [h, w, 4] of opaque ``colors`` [h, w, 3], or of the grey levels [h, w]."""
    colors = np.repeat(colors[..., None], 3, -1) if colors.ndim == 2 else colors
    return np.concatenate([colors, np.ones_like(colors[..., :1])], -1).astype(np.float32)


def flat_paints(*colors: tuple[float, float, float]) -> Paints:
    """Return opaque flat paints of ``colors``."""
    values, count = np.array(colors, np.float32), len(colors)
    zeros = np.zeros((count, 4), np.float32)
    return Paints(values, np.ones(count, np.float32), np.full(count, FLAT, np.int32), zeros, values)


def assignment_of(label: list[list[int]], other: list[list[int]], share: list[list[float]]) -> Assignment:
    """Return an assignment; the pixels of one label alone are pure."""
    first, second = np.array(label, np.int32), np.array(other, np.int32)
    part = np.array(share, np.float32)
    is_pure = part == 1.0
    anchors = np.where(is_pure, first, -1).astype(np.int32)
    return Assignment(anchors, is_pure, first, second, part, np.zeros_like(part))


def pure(label: list[list[int]]) -> Assignment:
    """Return an assignment of pure pixels."""
    return assignment_of(label, label, np.ones(np.shape(label)).tolist())
