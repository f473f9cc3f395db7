"""Circles, ellipses and rectangles of other programs' files, as forms where their transform leaves them one."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from warpvec.geometry.forms.form import Floats
from warpvec.geometry.forms.registry import CIRCLE, ELLIPSE, RECT, ROUND_RECT
from warpvec.geometry.loops import OutlineForm
from warpvec.svg.foreign.shapes import apply, shape_sizes

MISS_MAX = 1e-3
"""Largest distance in pixels by which a form may miss the shape in the file: files state numbers to so many."""


def shape_form(
    name: str, attributes: Mapping[str, str], viewport: tuple[float, float], matrix: NDArray[np.float64]
) -> OutlineForm | None:
    """Return the form in pixels of the shape ``name``; None if it is none.

    Args:
        name: name of the element.
        attributes: its attributes.
        viewport: width and height that percentages are of.
        matrix: the transform to pixels [2, 3].
    """
    if name not in ("circle", "ellipse", "rect") or not np.isfinite(matrix).all():
        return None
    sizes = shape_sizes(attributes, *viewport)
    if name == "rect":
        return _rect(sizes, matrix)
    rx, ry = (sizes["r"], sizes["r"]) if name == "circle" else (sizes["rx"], sizes["ry"])
    with np.errstate(over="ignore", invalid="ignore"):  # a file may state any number
        center, axes = apply(matrix, np.array([sizes["cx"], sizes["cy"]])), matrix[:, :2] * np.array([rx, ry])
    return _ellipse(center, axes) if np.isfinite(center).all() and np.isfinite(axes).all() else None


def _ellipse(center: Floats, axes: Floats) -> OutlineForm | None:
    """Return the form of the circle of radius 1 moved to ``center`` by the matrix ``axes`` [2, 2]."""
    turned, (first, second), _ = np.linalg.svd(axes)
    if first - second <= MISS_MAX:
        radius = (first + second) / 2
        return _of(CIRCLE, [*center, radius, 0.0, 0.0, 0.0], radius)
    sizes, angle = _upright((first, second), math.atan2(turned[1, 0], turned[0, 0]))
    return _of(ELLIPSE, [*center, *sizes, angle, 0.0], second)


def _rect(sizes: Mapping[str, float], matrix: NDArray[np.float64]) -> OutlineForm | None:
    width, height = sizes["width"], sizes["height"]
    if not (width > 0 and height > 0):
        return None
    center = apply(matrix, np.array([sizes["x"] + width / 2, sizes["y"] + height / 2]))
    across, down = matrix[:, 0], matrix[:, 1]
    scales = math.hypot(*across), math.hypot(*down)
    skew = abs(float(across @ down)) * min(width / max(scales[1], 1e-12), height / max(scales[0], 1e-12))
    sides, angle = _upright((width * scales[0], height * scales[1]), math.atan2(across[1], across[0]))
    if skew > MISS_MAX:
        return None
    if not (sizes["rx"] > 0 and sizes["ry"] > 0):
        return _of(RECT, [*center, *sides, angle, 0.0], min(sides))
    first, second = min(sizes["rx"], width / 2) * scales[0], min(sizes["ry"], height / 2) * scales[1]
    if abs(first - second) > MISS_MAX:
        return None
    return _of(ROUND_RECT, [*center, *sides, angle, (first + second) / 2], min(sides))


def _upright(sizes: tuple[float, float], angle: float) -> tuple[tuple[float, float], float]:
    """Return the sizes and an angle within half a right one of 0, which describe the same form."""
    quarters = round(angle / (math.pi / 2))
    turned = angle - quarters * math.pi / 2
    turned = 0.0 if abs(turned) * max(sizes) <= MISS_MAX else turned
    return ((sizes[1], sizes[0]) if quarters % 2 else sizes), turned


def _of(kind: int, parameters: list[float], smallest: float) -> OutlineForm | None:
    if not (np.isfinite(parameters).all() and smallest > 0.0):
        return None
    return OutlineForm(kind, tuple(map(float, parameters)))
