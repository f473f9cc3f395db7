"""Radial gradients: t = |q| / r, with q from the centre to the place."""

from __future__ import annotations

import math

import numpy as np
import torch
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
        cx, cy, r = geometry[:3]
        return length(x - cx, y - cy) / np.maximum(r, RAMP_EXTENT_MIN)

    def slopes(self, geometry: Reals, x: Reals, y: Reals) -> Reals:
        """Return the derivative of t [G, M]."""
        cx, cy, r = geometry[:3]
        distance, radius = np.maximum(length(x - cx, y - cy), _DISTANCE_MIN), np.maximum(r, RAMP_EXTENT_MIN)
        rows: list[Reals] = [
            -(x - cx) / (distance * radius),
            -(y - cy) / (distance * radius),
            -(distance / radius) / radius,
            np.zeros_like(distance),
            np.zeros_like(distance),
        ]
        return np.stack(rows[: len(geometry)])

    def is_drawn(self, geometry: Tensor) -> Tensor:
        """Return whether the radius is not too small, and all is finite [N]."""
        center, r = geometry[:, :2], geometry[:, 2]
        return (r >= RAMP_EXTENT_MIN) & r.isfinite() & center.sum(1).isfinite()

    def scaled(self, geometry: Tensor, x_factor: float, y_factor: float) -> Tensor:
        """Return the geometries [N, G] scaled about the origin; a radius, by the geometric mean of the two factors."""
        factors = [x_factor, y_factor, math.sqrt(abs(x_factor * y_factor)), 1.0, 1.0]
        return geometry * geometry.new_tensor(factors)[: geometry.shape[1]]

    def moved(self, geometry: Tensor, x: float, y: float) -> Tensor:
        """Return the geometries [N, G] of the gradients moved by ``x`` and ``y`` pixels."""
        return geometry + geometry.new_tensor([x, y, 0.0, 0.0, 0.0])[: geometry.shape[1]]

    def form(self, geometry: Tensor) -> Tensor:
        """Return the centre, and 1 / r^2 times the identity [N, 5]."""
        inverse = geometry[:, 2].square().reciprocal()
        return torch.stack([geometry[:, 0], geometry[:, 1], inverse, torch.zeros_like(inverse), inverse], 1)

    def form_adjoint(self, geometry: Tensor, adj_form: Tensor) -> Tensor:
        """Return dL/d(geometry) [N, 5]."""
        adj_radius = -2.0 * (adj_form[:, 2] + adj_form[:, 4]) / geometry[:, 2] ** 3
        zero = torch.zeros_like(adj_radius)
        return torch.stack([adj_form[:, 0], adj_form[:, 1], adj_radius, zero, zero], 1)

    def between(self, geometry: Geometry, start: float, end: float) -> Geometry:
        """Return the geometry up to a t."""
        del start
        cx, cy, r = geometry[:3]
        return cx, cy, r * end, 0.0
