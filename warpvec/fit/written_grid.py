"""Round the paths of a fit, near its end, to what their file will state."""

from __future__ import annotations

from dataclasses import dataclass

import torch

from warpvec.geometry.scene import Scene, straightened
from warpvec.svg.quantize import COLOR_LEVELS

ROUNDING_START = 0.9
"""Share of the iterations from which the drawing is that of the rounded paths. The parameters stay free: their steps
follow the derivatives at the rounded paths, and so the fit chooses between neighbouring roundings. From 0.8 on it is
worse by 0.05 dB, as fewer iterations are left for free paths."""

OPACITY_LEVELS = 100
"""Largest level of an opacity in a file."""


@dataclass
class WrittenGrid:
    """The values that a file can state.

    Attributes:
        step: distance of its coordinates in pixels of the fitted image, across and down.
        is_on: whether scenes are rounded.
    """

    step: tuple[float, float]
    is_on: bool = False

    def begin(self, iteration: int, iterations: int) -> None:
        """Round from now on if ``iteration`` of ``iterations`` is due."""
        self.is_on = self.is_on or iteration >= ROUNDING_START * iterations

    def round_in_place(self, scene: Scene) -> None:
        """Overwrite the values of ``scene`` by the nearest ones of the file, if rounding is on."""
        if not self.is_on:
            return
        step = scene.segments.new_tensor(self.step)
        rounded = (scene.segments / step).round_().mul_(step)
        scene.segments.copy_(straightened(rounded, scene.structure))
        for values, levels in ((scene.color, COLOR_LEVELS), (scene.opacity, OPACITY_LEVELS)):
            values.mul_(levels).round_().div_(levels)
        if not scene.transparent:
            torch.round(scene.background * COLOR_LEVELS, out=scene.background).div_(COLOR_LEVELS)
        self.round_paints(scene)

    def round_paints(self, scene: Scene) -> None:
        """Overwrite the end colours of the gradients of ``scene`` by those of the file, if rounding is on."""
        if self.is_on and scene.gradients is not None:
            scene.gradients.end_color.mul_(COLOR_LEVELS).round_().div_(COLOR_LEVELS)
