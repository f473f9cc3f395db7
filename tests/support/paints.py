"""Scenes with gradients, random or given, and what the reference makes of them."""

from __future__ import annotations

from dataclasses import replace

import torch
from compound import compound_scene, split_into_loops
from reference import compound_coverage
from reference.compositing import composite
from reference.gradients import pixel_colors, pixel_stops
from scenes import seeded
from torch import Tensor

from warpvec.geometry.bezier import path_boxes
from warpvec.geometry.gradients import Gradients
from warpvec.geometry.paints.registry import ELLIPTIC, FLAT, LINEAR, RADIAL
from warpvec.geometry.scene import Scene
from warpvec.geometry.stops import STOPS_MAX, Stops
from warpvec.rendering.exact import ExactRenderer

VALUES = ("segments", "color", "opacity", "background", "end_color", "geometry")
"""The inputs that are differentiated; the last two are those of the gradients."""

STOP_VALUES = ("inner_color", "offset", "stop_opacity", "breadth")
"""The same of `Stops`; ``stop_opacity`` is their opacity."""


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
    if paints.stops is not None:
        values = reference_paints(scene, height, width)[rows]
        opacity = scene.opacity[rows, None, None] * values[..., 3]
        return _translucent(stack, values[..., :3], opacity, scene.background)
    colors = pixel_colors(scene.color, paints.kind, paints.geometry, paints.end_color, height, width)
    return composite(stack, colors[rows], scene.opacity[rows], scene.background)


def _translucent(stack: Tensor, colors: Tensor, opacity: Tensor, background: Tensor) -> Tensor:
    """Return `composite` of paths whose ``opacity`` [N, h, w] differs from pixel to pixel."""
    return composite(stack * opacity, colors, torch.ones(len(stack), dtype=stack.dtype), background)


def reference_paints(scene: Scene, height: int, width: int) -> Tensor:
    """Return the reference's colour and opacity [N, h, w, 4] of the paint of each path."""
    paints, stops = scene.gradients, scene.gradients.stops
    offsets, values = [], []
    for row, count in enumerate(stops.count.tolist()):
        inner = stops.inner_color[row, : max(count - 2, 0)]
        colors = torch.cat([scene.color[row, None], inner, paints.end_color[row, None]])
        opacity = stops.opacity[row, :count]
        if int(paints.kind[row]) == FLAT:
            colors, opacity = scene.color[row, None], torch.ones(1, dtype=colors.dtype)
        offsets.append(stops.offset[row, :count])
        values.append(torch.cat([colors, opacity[:, None]], 1))
    geometry = torch.cat([paints.geometry, stops.breadth[:, None]], 1)
    return pixel_stops(paints.kind, geometry, offsets, values, height, width)


def striped_scene(
    seed: int,
    path_count: int,
    height: int,
    width: int,
    kinds: tuple[int, ...] = (LINEAR, ELLIPTIC, FLAT, RADIAL, ELLIPTIC),
) -> Scene:
    """Return a scene of paths of several loops with random gradients of ``kinds`` and of 2 to 8 stops each."""
    return striped(painted_scene(seed, path_count, height, width, kinds), seed)


def striped(scene: Scene, seed: int = 0) -> Scene:
    """Return a ``scene`` with gradients with random stops; an elliptic one has the half of an axis as its breadth."""
    generator, count = seeded(seed + 77), len(scene)
    paints = scene.gradients
    kind, ends = paints.kind, paints.geometry
    axis = ends[:, 2:] - ends[:, :2]
    ellipse = torch.cat([ends[:, :2], axis], 1)
    number = torch.randint(2, STOPS_MAX + 1, (count,), generator=generator, dtype=torch.int32)
    number[:3] = torch.tensor([STOPS_MAX, 2, 3], dtype=torch.int32)[:count]
    offset = torch.rand(count, STOPS_MAX, generator=generator, dtype=torch.float64).sort(1).values
    inner = torch.rand(count, STOPS_MAX - 2, 3, generator=generator, dtype=torch.float64)
    opacity = torch.rand(count, STOPS_MAX, generator=generator, dtype=torch.float64) * 0.8 + 0.2
    opacity[::3] = 1.0
    breadth = (0.3 + torch.rand(count, generator=generator, dtype=torch.float64)) * axis.norm(dim=1) + 1.0
    geometry = torch.where((kind == ELLIPTIC)[:, None], ellipse, ends)
    stops = Stops(number, offset, inner, opacity, breadth)
    return replace(scene, gradients=replace(paints, geometry=geometry, stops=stops))


def stop_values_of(scene: Scene) -> list[Tensor]:
    """Return the tensors ``VALUES`` and ``STOP_VALUES`` of a scene with stops."""
    stops = scene.gradients.stops
    return [*values_of(scene), stops.inner_color, stops.offset, stops.opacity, stops.breadth]


def with_stop_values(scene: Scene, values: list[Tensor] | tuple[Tensor, ...]) -> Scene:
    """Return ``scene`` with the tensors ``VALUES`` and ``STOP_VALUES`` replaced."""
    inner_color, offset, opacity, breadth = values[6:]
    stops = Stops(scene.gradients.stops.count, offset, inner_color, opacity, breadth)
    scene = with_values(scene, values[:6])
    return replace(scene, gradients=replace(scene.gradients, stops=stops))
