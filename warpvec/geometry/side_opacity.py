"""The opacities of paths at their two sides: an opacity that changes across a path, for the renderer "splat" alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import torch
from torch import Tensor

from warpvec.geometry.gradients import check_shape


@dataclass(frozen=True)
class SideOpacity:
    """How opaque N paths of two sides are at their sides; the scene's opacity is that in the middle.

    Attributes:
        value: opacity at side A and at side B [N, 2], in [0, 1].

    Raises:
        InputError: the shape is another.
    """

    value: Tensor

    def __post_init__(self) -> None:
        check_shape("side_opacity.value", self.value, (len(self.value), 2), len(self.value))

    @staticmethod
    def none(color: Tensor) -> SideOpacity:
        """Return the opacities of opaque sides, for paths of ``color`` [N, 3]."""
        return SideOpacity(color.new_ones(len(color), 2))

    def __len__(self) -> int:
        return len(self.value)

    def map(self, change: Callable[[Tensor], Tensor]) -> SideOpacity:
        """Return the opacities with the tensor replaced by what ``change`` makes of it."""
        return SideOpacity(change(self.value))

    def joined(self, other: SideOpacity) -> SideOpacity:
        """Return these opacities and those of ``other`` paths."""
        return SideOpacity(torch.cat([self.value, other.value]))

    def scaled(self, x_factor: float, y_factor: float) -> SideOpacity:
        """Return the opacities, which scaling leaves as they are."""
        del x_factor, y_factor
        return self

    def moved(self, x: float, y: float) -> SideOpacity:
        """Return the opacities, which a move leaves as they are."""
        del x, y
        return self
