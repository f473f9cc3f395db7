"""Curves [S, 4, 2] of outlines whose parts are known, as a rough fit draws them: for tests of chains."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from warpvec.flat.cutting.cut_edges import between

Floats = NDArray[np.float64]

QUARTER = 4.0 / 3.0 * (math.sqrt(2.0) - 1.0)


def split(curve: Floats, t: float) -> Floats:
    """Return both parts [2, 4, 2] of a ``curve`` [4, 2] up to and from the parameter ``t`` on."""
    return between(np.stack([curve, curve]), np.array([0.0, t]), np.array([t, 1.0]))


def line(start: tuple[float, float], end: tuple[float, float]) -> Floats:
    """Return a line as a curve [1, 4, 2]."""
    a, b = np.array(start), np.array(end)
    return np.stack([a, a + (b - a) / 3.0, a + (b - a) * 2.0 / 3.0, b])[None]


def quarter(start: tuple[float, float], corner: tuple[float, float], end: tuple[float, float]) -> Floats:
    """Return a quarter of a circle or an ellipse from ``start`` to ``end``, whose tangents meet in ``corner``."""
    a, b, c = np.array(start), np.array(corner), np.array(end)
    return np.stack([a, a + QUARTER * (b - a), c + QUARTER * (b - c), c])[None]


def rounded_rectangle(
    x: float, y: float, width: float, height: float, radii: tuple[float, float, float, float]
) -> Floats:
    """Return the curves [8, 4, 2] of a rectangle with these radii from its top left corner on, clockwise."""
    a, b, c, d = radii
    right, bottom = x + width, y + height
    return np.concatenate([
        quarter((x, y + a), (x, y), (x + a, y)), line((x + a, y), (right - b, y)),
        quarter((right - b, y), (right, y), (right, y + b)), line((right, y + b), (right, bottom - c)),
        quarter((right, bottom - c), (right, bottom), (right - c, bottom)), line((right - c, bottom), (x + d, bottom)),
        quarter((x + d, bottom), (x, bottom), (x, bottom - d)), line((x, bottom - d), (x, y + a)),
    ])  # fmt: skip
