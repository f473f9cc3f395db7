"""Draw the shapes of a placeholder as viewers will, blurred, and differentiate their error."""

from __future__ import annotations

import math
from typing import NamedTuple

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.target import Target
from warpvec.geometry.scene import Scene
from warpvec.rendering.operator import draw, draw_adjoint

CORNERS = 4
"""Corners of a shape. Four and five are alike; with three, or with two cubics in place of lines, it loses 0.2 to 0.4 dB
in the same bytes (mean of six photos)."""

COLOR_STEPS = 15
"""Steps of a colour's channel in #rgb."""

MARGIN_DEVIATIONS = 3
"""Standard deviations by which the background reaches beyond the canvas; 0.1 % of a Gaussian lie beyond."""


class Shapes(NamedTuple):
    """Opaque quadrilaterals over a background, the first at the bottom.

    Attributes:
        corners: [N, 4, 2] in units of the viewBox, x right, y down.
        color: sRGB-encoded fill [N, 3] in [0, 1].
        background: sRGB-encoded colour [3].
    """

    corners: Tensor
    color: Tensor
    background: Tensor

    def select(self, rows: Tensor) -> Shapes:
        """Return the shapes with the indices ``rows``."""
        return Shapes(self.corners[rows], self.color[rows], self.background)


def rounded(shapes: Shapes) -> Shapes:
    """Return ``shapes`` as the text states them: whole units, and colours of 16 levels."""
    color, background = (
        (COLOR_STEPS * each.clamp(0.0, 1.0)).round() / COLOR_STEPS for each in (shapes.color, shapes.background)
    )
    return Shapes(shapes.corners.round(), color, background)


class BlurredCanvas:
    """The image to draw, and the blur.

    SVG filters blur in linear light unless told otherwise, which would cost bytes. So does this.

    Args:
        target: the image [h, w, 3], sRGB-encoded in [0, 1].
        deviation: standard deviation of the blur in pixels, 0 for none.
    """

    def __init__(self, target: Tensor, deviation: float) -> None:
        self.target = target
        self.height, self.width = target.shape[:2]
        self._margin = math.ceil(MARGIN_DEVIATIONS * deviation)
        self._blurs = [blur_matrix(side, self._margin, deviation) for side in target.shape[:2]] if deviation else []
        self._plain = Target(target, FitConfig(threads=1), "cpu")

    def step(self, shapes: Shapes) -> tuple[Shapes, Tensor]:
        """Return the adjoints of ``shapes`` for the mean squared error, and the residual [h, w, 3]."""
        scene = _scene(shapes, self._margin)
        with torch.enable_grad():
            image = draw(scene, self.height + 2 * self._margin, self.width + 2 * self._margin, threads=1)
            residual = self.target - self._blurred(image.requires_grad_())
            (adj_image,) = torch.autograd.grad(residual.square().mean(), image)
        adjoints = draw_adjoint(scene, adj_image, threads=1)
        adj_corners = _folded(adjoints.segments.view(-1, CORNERS, 3, 2))
        return Shapes(adj_corners, adjoints.color, adjoints.background), residual.detach()

    def removal_cost(self, shapes: Shapes) -> Tensor:
        """Return by how much the loss would rise without each shape [N], as if nothing was blurred."""
        cost = self._plain.fit_step(_scene(shapes, 0), True).removal_cost
        assert cost is not None
        return cost.clone()

    def _blurred(self, image: Tensor) -> Tensor:
        if not self._blurs:
            return image
        down, across = self._blurs
        linear = torch.einsum("ij,jkc->ikc", down, _linear(image))
        return _encoded(torch.einsum("jk,ikc->ijc", across, linear))


def blur_matrix(side: int, margin: int, deviation: float) -> Tensor:
    """Return the Gaussian weights [side, side + 2 margin] of pixels, ``margin`` of which lie before the first."""
    places = torch.arange(side + 2 * margin, dtype=torch.float32)
    weights = torch.exp(-0.5 * ((places - places[margin : margin + side, None]) / deviation).square())
    return weights / weights.sum(1, keepdim=True)


def _scene(shapes: Shapes, margin: int) -> Scene:
    """Return ``shapes`` moved by ``margin``, with sides that are cubics with handles at thirds."""
    start = shapes.corners + margin
    stop = start.roll(-1, 1)
    points = torch.stack([start, torch.lerp(start, stop, 1 / 3), torch.lerp(start, stop, 2 / 3)], 2).flatten(1, 2)
    count = len(points)
    colors = shapes.color.clamp(0.0, 1.0), torch.ones(count), shapes.background.clamp(0.0, 1.0)
    return Scene.uniform(points, *colors, torch.zeros(count, dtype=torch.int64))


def _folded(adjoint: Tensor) -> Tensor:
    """Return the adjoints of corners [N, 4, 2] from those of the sides' points [N, 4, 3, 2]."""
    start, first, second = adjoint.unbind(2)
    return start + (2 * first + second) / 3 + ((first + 2 * second) / 3).roll(1, 1)


# The transfer function of sRGB, IEC 61966-2-1. The unused branch of each is kept away from infinite slopes.
_KNEE, _LINEAR_KNEE = 0.04045, 0.0031308


def _linear(encoded: Tensor) -> Tensor:
    power = ((encoded.clamp_min(_KNEE) + 0.055) / 1.055) ** 2.4
    return torch.where(encoded <= _KNEE, encoded / 12.92, power)


def _encoded(linear: Tensor) -> Tensor:
    power = 1.055 * linear.clamp_min(_LINEAR_KNEE) ** (1 / 2.4) - 0.055
    return torch.where(linear <= _LINEAR_KNEE, 12.92 * linear, power)
