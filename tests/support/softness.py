"""Scenes with soft paths, and what the reference makes of them."""

from __future__ import annotations

import math
from dataclasses import replace

import torch
from reference.compositing import composite
from reference.coverage import coverage, signed_coverage
from reference.softening import blurred
from strokes import reference_polygons, stroked_scene
from torch import Tensor

from warpvec.geometry.scene import Scene
from warpvec.geometry.softness import Softness
from warpvec.kernels.constants import GAUSSIAN_REACH
from warpvec.rendering.exact import ExactRenderer

VALUES = ("segments", "color", "opacity", "background", "width", "softness")
"""The inputs of a scene with strokes and soft paths that are differentiated."""

MARGIN = 40
"""Pixels around the canvas on which the reference draws: more than the widest blur of `soft_scene` reaches."""


def values_of(scene: Scene) -> list[Tensor]:
    """Return the tensors ``VALUES`` of a scene with strokes and soft paths."""
    groups = {"width": scene.strokes.width, "softness": scene.softness.sigma}
    return [groups[name] if name in groups else getattr(scene, name) for name in VALUES]


def with_values(scene: Scene, values: list[Tensor] | tuple[Tensor, ...]) -> Scene:
    """Return ``scene`` with the tensors ``VALUES`` replaced."""
    *tensors, width, sigma = values
    named = dict(zip(VALUES[:-2], tensors, strict=True))
    return replace(scene, **named, strokes=replace(scene.strokes, width=width), softness=Softness(sigma))


def soft_scene(seed: int, height: int, width: int, sigmas: tuple[float, ...] = (0.0, 0.6, 2.3, 7.7, 0.0)) -> Scene:
    """Return as many random paths as there are ``sigmas``, the first two stroked; some are partly off the canvas."""
    scene = stroked_scene(seed, 2, height, width, filled=len(sigmas) - 2).moved(-0.2 * width, 0.1 * height)
    return replace(scene, softness=Softness(torch.tensor(sigmas, dtype=torch.float64)))


def reference_image(scene: Scene, renderer: ExactRenderer) -> Tensor:
    """Return the reference's image, with the chords of the last drawing by ``renderer``."""
    height, width = renderer.grid.height, renderer.grid.width
    inside = slice(MARGIN, MARGIN + height), slice(MARGIN, MARGIN + width)
    stack = []
    for polygons, sigma in zip(reference_polygons(scene, renderer), scene.softness.sigma, strict=True):
        size = height + 2 * MARGIN, width + 2 * MARGIN
        whole = coverage(sum(signed_coverage(polygon + MARGIN, *size) for polygon in polygons))
        reach = math.ceil(GAUSSIAN_REACH * sigma.item())
        stack.append((blurred(whole, sigma, reach) if reach else whole)[inside])
    return composite(torch.stack(stack), scene.color, scene.opacity, scene.background)
