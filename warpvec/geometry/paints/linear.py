"""Linear gradients: t = q . d / |d|^2, with d from the first point to the second and q from the first to the place."""

from __future__ import annotations

import numpy as np
import torch
from torch import Tensor

from warpvec.geometry.paints.kind import RAMP_EXTENT_MIN, Geometry, GradientKind, Reals


class Linear(GradientKind):
    """A gradient from the point x1, y1 to the point x2, y2."""

    name, element, sides = "linear", "linearGradient", ("x1", "y1", "x2", "y2")
    has_free_start, is_root = True, False

    def share(self, geometry: Reals, x: Reals, y: Reals) -> Reals:
        """Return t [M]; see `GradientKind.share`."""
        x1, y1, x2, y2 = geometry[:4]
        return ((x - x1) * (x2 - x1) + (y - y1) * (y2 - y1)) / _squared_length(geometry)

    def slopes(self, geometry: Reals, x: Reals, y: Reals) -> Reals:
        """Return the derivative of t [G, M]."""
        x1, y1, x2, y2 = geometry[:4]
        t, squared = self.share(geometry, x, y), _squared_length(geometry)
        (across, down), (qx, qy) = (x2 - x1, y2 - y1), (x - x1, y - y1)
        rows: list[Reals] = [
            ((2.0 * t - 1.0) * across - qx) / squared,
            ((2.0 * t - 1.0) * down - qy) / squared,
            (qx - 2.0 * t * across) / squared,
            (qy - 2.0 * t * down) / squared,
            np.zeros_like(t),
        ]
        return np.stack(rows[: len(geometry)])

    def is_drawn(self, geometry: Tensor) -> Tensor:
        """Return whether the two points are apart and finite [N]."""
        squared = (geometry[:, 2:4] - geometry[:, :2]).square().sum(1)
        return (squared >= RAMP_EXTENT_MIN**2) & squared.isfinite()

    def scaled(self, geometry: Tensor, x_factor: float, y_factor: float) -> Tensor:
        """Return the geometries [N, G] of the gradients scaled about the origin."""
        return geometry * geometry.new_tensor([x_factor, y_factor, x_factor, y_factor, 1.0])[: geometry.shape[1]]

    def moved(self, geometry: Tensor, x: float, y: float) -> Tensor:
        """Return the geometries [N, G] of the gradients moved by ``x`` and ``y`` pixels."""
        return geometry + geometry.new_tensor([x, y, x, y, 0.0])[: geometry.shape[1]]

    def form(self, geometry: Tensor) -> Tensor:
        """Return the first point, d / |d|^2, and 0 [N, 5]."""
        along = geometry[:, 2:4] - geometry[:, :2]
        slope = along / along.square().sum(1, keepdim=True)
        return torch.cat([geometry[:, :2], slope, torch.zeros_like(slope[:, :1])], 1)

    def form_adjoint(self, geometry: Tensor, adj_form: Tensor) -> Tensor:
        """Return dL/d(geometry) [N, 5]."""
        along = geometry[:, 2:4] - geometry[:, :2]
        squared = along.square().sum(1, keepdim=True)
        slope, adj_slope = along / squared, adj_form[:, 2:4]
        adj_end = adj_slope / squared - 2.0 * (adj_slope * slope).sum(1, keepdim=True) * slope
        return torch.cat([adj_form[:, :2] - adj_end, adj_end, torch.zeros_like(squared)], 1)

    def between(self, geometry: Geometry, start: float, end: float) -> Geometry:
        """Return the geometry between two t."""
        x, y, z, w = geometry[:4]
        return x + start * (z - x), y + start * (w - y), x + end * (z - x), y + end * (w - y)


def _squared_length(geometry: Reals) -> Reals:
    x1, y1, x2, y2 = geometry[:4]
    squared: Reals = np.maximum(np.square(x2 - x1) + np.square(y2 - y1), RAMP_EXTENT_MIN**2)
    return squared
