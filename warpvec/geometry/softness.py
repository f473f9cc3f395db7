"""The softness of the paths of a scene: how far a Gaussian blurs each of them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import torch
from torch import Tensor

from warpvec.geometry.gradients import check_shape

SIGMA_MIN = 0.1
"""Standard deviation in pixels below which a path is sharp: at this one, a pixel gives its neighbours 1e-22 of it."""

SIGMA_MAX = 250.0
"""Largest standard deviation in pixels. A path of it reaches 750 px farther than its outline, and its layer takes as
much memory as the drawing of a large photo."""

LAYERS_MAX = 2**27
"""Most pixels of the layers of all soft paths of a drawing, each with what its blur reaches. A pixel takes 24 bytes, so
that they take 3 GB; ten soft paths on a canvas of 12 megapixels have as many."""


@dataclass(frozen=True)
class Softness:
    """How soft N paths are: what a path covers is its exact coverage, blurred by a Gaussian.

    Attributes:
        sigma: standard deviation in pixels [N], 0 for a sharp path. One below ``SIGMA_MIN`` counts as 0, and one above
            ``SIGMA_MAX`` as that.

    Raises:
        InputError: the shape is another.
    """

    sigma: Tensor

    def __post_init__(self) -> None:
        check_shape("softness.sigma", self.sigma, (len(self.sigma),), len(self.sigma))

    @staticmethod
    def none(color: Tensor) -> Softness:
        """Return the softness of sharp paths of ``color`` [N, 3]."""
        return Softness(color.new_zeros(len(color)))

    def __len__(self) -> int:
        return len(self.sigma)

    @property
    def is_soft(self) -> Tensor:
        """Which paths are soft [N] (bool)."""
        return self.sigma >= SIGMA_MIN

    def or_none(self) -> Softness | None:
        """Return the softness; None if all paths are sharp."""
        return self if bool(self.is_soft.any()) else None

    def map(self, change: Callable[[Tensor], Tensor]) -> Softness:
        """Return the softness with the tensor replaced by what ``change`` makes of it."""
        return Softness(change(self.sigma))

    def joined(self, other: Softness) -> Softness:
        """Return this softness and that of ``other`` paths."""
        return Softness(torch.cat([self.sigma, other.sigma]))

    def scaled(self, x_factor: float, y_factor: float) -> Softness:
        """Return the softness scaled about the origin; by the geometric mean of the two factors."""
        return Softness(self.sigma * math.sqrt(abs(x_factor * y_factor)))

    def moved(self, x: float, y: float) -> Softness:
        """Return the softness, which a move leaves as it is."""
        del x, y
        return self
