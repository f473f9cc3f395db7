"""Cut discs out of shapes."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from warpvec.svg.foreign.polygons import distance, polygon_of, winding
from warpvec.svg.foreign.shapes import Loop
from warpvec.svg.foreign.skia import Combiner

_ARM = 4 / 3 * math.tan(math.pi / 8)
"""Length of the handles of a quarter of the unit circle."""


def disc_in(loops: list[Loop], x: float, y: float, radius: float, combiner: Combiner) -> list[Loop] | None:
    """Return what the disc about ``x``, ``y`` and a shape have in common; None if that cannot be told."""
    center = np.array([x, y])
    polygons = [polygon_of(loop) for loop in loops]
    if min(distance(polygon, center) for polygon in polygons) >= radius:
        turns = sum(winding(polygon, center) for polygon in polygons)
        return [_circle(center, radius)] if turns else []
    return combiner.common(loops, [_circle(center, radius)])


def _circle(center: NDArray[np.float64], radius: float) -> Loop:
    turns = np.array([[[1.0, 0.0], [1.0, _ARM], [_ARM, 1.0]]])
    quarter = np.array([[0.0, 1.0], [-1.0, 0.0]])
    rows = [turns @ np.linalg.matrix_power(quarter, count) for count in range(4)]
    return Loop(center + radius * np.concatenate(rows).reshape(-1, 2), np.zeros(4, np.bool_))
