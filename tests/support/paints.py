"""Scenes with gradients, random or given, and what the reference makes of them."""

from __future__ import annotations

from dataclasses import replace

import torch
from compound import compound_scene, split_into_loops
from reference import compound_coverage
from reference.compositing import composite
from reference.gradients import pixel_colors
from scenes import seeded
from torch import Tensor

from warpvec.geometry.bezier import path_boxes
from warpvec.geometry.gradients import Gradients
from warpvec.geometry.paints.registry import RADIAL
from warpvec.geometry.scene import Scene
from warpvec.rendering.exact import ExactRenderer

VALUES = ("segments", "color", "opacity", "background", "end_color", "geometry")
"""The inputs that are differentiated; the last two are those of the gradients."""


def values_of(scene: Scene) -> list[Tensor]:
    """Return the tensors ``VALUES`` of a scene with gradients."""
    return [getattr(scene.gradients if name in VALUES[4:] else scene, name) for name in VALUES]


def with_values(scene: Scene, values: list[Tensor] | tuple[Tensor, ...]) -> Scene:
    """Return ``scene`` with the tensors ``VALUES`` replaced."""
    segments, color, opacity, background, end_color, geometry = values
    gradients = Gradients(scene.gradients.kind, geometry, end_color)
    return replace(scene, segments=segments, color=color, opacity=opacity, background=background, gradients=gradients)


def painted(scene: Scene, kinds: tuple[int, ...], seed: int = 0) -> Scene:
    """Return ``scene`` with gradients of the ``kinds`` in turn, some of which end within their paths."""
    generator = seeded(seed)
    count = len(scene)
    box = path_boxes(scene).double()
    corners = torch.rand(count, 2, 2, generator=generator, dtype=torch.float64)
    ends = box[:, None, :2] + (1.4 * corners - 0.2) * (box[:, 2:] - box[:, :2])[:, None]
    radius = (0.2 + 0.6 * corners[:, 0, :1]) * (box[:, 2:] - box[:, :2]).norm(dim=1, keepdim=True) + 0.5
    kind = torch.tensor([kinds[row % len(kinds)] for row in range(count)], dtype=torch.int32)
    radial = torch.cat([ends[:, 0], radius, torch.zeros(count, 1)], 1)
    geometry = torch.where((kind == RADIAL)[:, None], radial, ends.flatten(1))
    end_color = torch.rand(count, 3, generator=generator, dtype=torch.float64)
    return replace(scene, gradients=Gradients(kind, geometry, end_color))


def painted_scene(
    seed: int, path_count: int, height: int, width: int, kinds: tuple[int, ...] = (1, 2, 0, 2, 1)
) -> Scene:
    """Return a scene of paths of several loops with random gradients of ``kinds``."""
    return painted(compound_scene(seed, path_count, height, width), kinds, seed)


def reference_image(scene: Scene, renderer: ExactRenderer, rows: list[int] | None = None) -> Tensor:
    """Return the reference's image of a scene, or of its paths ``rows``, with the chords of the last drawing."""
    first = torch.from_numpy(renderer._flattening.segment_first_vertex.numpy()[: len(scene.segments) + 1].copy())
    counts = [[loop.tolist() for loop in path] for path in split_into_loops(first.diff(), scene.structure)]
    loops = [[loop.flatten(0, 1) for loop in path] for path in split_into_loops(scene.segments, scene.structure)]
    height, width = renderer.grid.height, renderer.grid.width
    rows = list(range(len(scene))) if rows is None else rows
    stack = compound_coverage([loops[row] for row in rows], [counts[row] for row in rows], height, width)
    paints = scene.gradients
    colors = pixel_colors(scene.color, paints.kind, paints.geometry, paints.end_color, height, width)
    return composite(stack, colors[rows], scene.opacity[rows], scene.background)
