"""Radial gradients: t = |q| / r, with q from the centre to the place."""

from __future__ import annotations

import math

import numpy as np
from torch import Tensor

from warpvec.geometry.paints.kind import RAMP_EXTENT_MIN, Geometry, GradientKind, Reals, length

_DISTANCE_MIN = 1e-9
"""Distance in pixels from the centre, where t has no derivative, below which it is taken as this."""


class Radial(GradientKind):
    """A gradient from the centre cx, cy to the circle of radius r about it; the fourth number is unused."""

    name, element, sides = "radial", "radialGradient", ("cx", "cy", "r")
    has_free_start = False

    def share(self, geometry: Reals, x: Reals, y: Reals) -> Reals:
        """Return t [M]; see `GradientKind.share`."""
        cx, cy, r, _ = geometry
        return length(x - cx, y - cy) / np.maximum(r, RAMP_EXTENT_MIN)

    def slopes(self, geometry: Reals, x: Reals, y: Reals) -> Reals:
        """Return the derivative of t [4, M]."""
        cx, cy, r, _ = geometry
        distance, radius = np.maximum(length(x - cx, y - cy), _DISTANCE_MIN), np.maximum(r, RAMP_EXTENT_MIN)
        inward: list[Reals] = [-(x - cx) / (distance * radius), -(y - cy) / (distance * radius)]
        return np.stack([*inward, -(distance / radius) / radius, np.zeros_like(distance)])

    def is_drawn(self, geometry: Tensor) -> Tensor:
        """Return whether the radius is not too small, and all is finite [N]."""
        center, r = geometry[:, :2], geometry[:, 2]
        return (r >= RAMP_EXTENT_MIN) & r.isfinite() & center.sum(1).isfinite()

    def scaled(self, geometry: Tensor, x_factor: float, y_factor: float) -> Tensor:
        """Return the geometries [N, 4] scaled about the origin; a radius, by the geometric mean of the two factors."""
        return geometry * geometry.new_tensor([x_factor, y_factor, math.sqrt(abs(x_factor * y_factor)), 1.0])

    def moved(self, geometry: Tensor, x: float, y: float) -> Tensor:
        """Return the geometries [N, 4] of the gradients moved by ``x`` and ``y`` pixels."""
        return geometry + geometry.new_tensor([x, y, 0.0, 0.0])

    def between(self, geometry: Geometry, start: float, end: float) -> Geometry:
        """Return the geometry up to a t."""
        del start
        cx, cy, r, _ = geometry
        return cx, cy, r * end, 0.0
