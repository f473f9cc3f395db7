"""A Gaussian blur of pictures, as a linear operator.

The picture goes on beyond its border as in a mirror that stands at the edges of the outermost pixels. With this border
the operator is symmetric, so that its adjoint is the blur itself.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor

REACH = 3.5
"""Standard deviations at which the kernel ends. What it leaves out is 5e-4 of the whole."""


@dataclass(frozen=True)
class GaussianBlur:
    """A blur by a Gaussian of this standard ``deviation`` in pixels, above 0."""

    deviation: float

    def __call__(self, image: Tensor) -> Tensor:
        """Return ``image`` [h, w, c], blurred."""
        return self._along(self._along(image, 0), 1)

    @property
    def edge_share(self) -> float:
        """Squared error that the move of an edge causes in a blurred picture, as a share of that in a sharp one.

        A small move changes each row across the edge by the slope of the edge. The square of the slope has the integral
        1 for the ramp of one pixel that a renderer draws, and 1 / (2 sqrt(pi) deviation) for a Gaussian much wider than
        that. In between, the two are joined by the root of the sum of squares.
        """
        return 1.0 / math.sqrt(1.0 + 4.0 * math.pi * self.deviation**2)

    def _along(self, image: Tensor, axis: int) -> Tensor:
        """Return ``image`` blurred along one ``axis``. Sums in a fixed order have the same bits on any machine."""
        weights = self._weights()
        reach, size = len(weights) // 2, image.shape[axis]
        place = torch.arange(-reach, size + reach, device=image.device) % (2 * size)
        mirrored = image.index_select(axis, torch.minimum(place, 2 * size - 1 - place))
        total = torch.zeros_like(image)
        for first, weight in enumerate(weights):
            total.add_(mirrored.narrow(axis, first, size), alpha=weight)
        return total

    def _weights(self) -> list[float]:
        """Return the weights of the pixels at distances from -n to n; their sum is 1."""
        reach = math.ceil(REACH * self.deviation)
        weights = [math.exp(-0.5 * (place / self.deviation) ** 2) for place in range(-reach, reach + 1)]
        return [weight / sum(weights) for weight in weights]
