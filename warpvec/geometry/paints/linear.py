"""Linear gradients: t = q . d / |d|^2, with d from the first point to the second and q from the first to the place."""

from __future__ import annotations

import numpy as np
from torch import Tensor

from warpvec.geometry.paints.kind import RAMP_EXTENT_MIN, Geometry, GradientKind, Reals


class Linear(GradientKind):
    """A gradient from the point x1, y1 to the point x2, y2."""

    name, element, sides = "linear", "linearGradient", ("x1", "y1", "x2", "y2")
    has_free_start = True

    def share(self, geometry: Reals, x: Reals, y: Reals) -> Reals:
        """Return t [M]; see `GradientKind.share`."""
        x1, y1, x2, y2 = geometry
        return ((x - x1) * (x2 - x1) + (y - y1) * (y2 - y1)) / _squared_length(geometry)

    def slopes(self, geometry: Reals, x: Reals, y: Reals) -> Reals:
        """Return the derivative of t [4, M]."""
        x1, y1, x2, y2 = geometry
        t, squared = self.share(geometry, x, y), _squared_length(geometry)
        (across, down), (qx, qy) = (x2 - x1, y2 - y1), (x - x1, y - y1)
        rows: list[Reals] = [
            ((2.0 * t - 1.0) * across - qx) / squared,
            ((2.0 * t - 1.0) * down - qy) / squared,
            (qx - 2.0 * t * across) / squared,
            (qy - 2.0 * t * down) / squared,
        ]
        return np.stack(rows)

    def is_drawn(self, geometry: Tensor) -> Tensor:
        """Return whether the two points are apart and finite [N]."""
        squared = (geometry[:, 2:] - geometry[:, :2]).square().sum(1)
        return (squared >= RAMP_EXTENT_MIN**2) & squared.isfinite()

    def scaled(self, geometry: Tensor, x_factor: float, y_factor: float) -> Tensor:
        """Return the geometries [N, 4] of the gradients scaled about the origin."""
        return geometry * geometry.new_tensor([x_factor, y_factor, x_factor, y_factor])

    def moved(self, geometry: Tensor, x: float, y: float) -> Tensor:
        """Return the geometries [N, 4] of the gradients moved by ``x`` and ``y`` pixels."""
        return geometry + geometry.new_tensor([x, y, x, y])

    def between(self, geometry: Geometry, start: float, end: float) -> Geometry:
        """Return the geometry between two t."""
        x, y, z, w = geometry
        return x + start * (z - x), y + start * (w - y), x + end * (z - x), y + end * (w - y)


def _squared_length(geometry: Reals) -> Reals:
    x1, y1, x2, y2 = geometry
    squared: Reals = np.maximum(np.square(x2 - x1) + np.square(y2 - y1), RAMP_EXTENT_MIN**2)
    return squared
