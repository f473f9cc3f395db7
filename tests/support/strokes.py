"""Scenes with strokes, random or given, and what the reference makes of them."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import torch
from reference.compositing import composite
from reference.coverage import coverage, signed_coverage
from reference.flattening import flatten_loop
from reference.stroking import Look, stroke_polygons
from scenes import seeded
from torch import Tensor

from warpvec.geometry.scene import Scene, straightened
from warpvec.geometry.strokes import CAPS, JOINS, Strokes
from warpvec.geometry.structure import Structure
from warpvec.rendering.exact import ExactRenderer

VALUES = ("segments", "color", "opacity", "background", "width")
"""The inputs of a scene with strokes that are differentiated."""


def values_of(scene: Scene) -> list[Tensor]:
    """Return the tensors ``VALUES`` of a scene with strokes."""
    return [getattr(scene.strokes if name == "width" else scene, name) for name in VALUES]


def with_values(scene: Scene, values: list[Tensor] | tuple[Tensor, ...]) -> Scene:
    """Return ``scene`` with the tensors ``VALUES`` replaced."""
    *tensors, width = values
    named = dict(zip(VALUES[:-1], tensors, strict=True))
    return replace(scene, **named, strokes=replace(scene.strokes, width=width))


def stroked_scene(
    seed: int, path_count: int, height: int, width: int, widths: tuple[float, float] = (1.0, 9.0), filled: int = 0
) -> Scene:
    """Return random strokes of all caps and joins, then ``filled`` paths; some turn tighter than their width.

    A path has one or two loops of one to four rows, open or closed, some of them lines.
    """
    generator = seeded(seed)

    def uniform(*shape: int) -> Tensor:
        return torch.rand(shape, generator=generator, dtype=torch.float64)

    counts, is_open, is_line, rows = [], [], [], []
    for path in range(path_count + filled):
        counts.append([2 + int(4 * uniform(1)) for _ in range(1 + int(2 * uniform(1)))])
        for count in counts[-1]:
            is_open.append(path < path_count and bool(uniform(1) < 0.6))
            is_line += (uniform(count) < 0.3).tolist()
            is_line[-1] |= is_open[-1]
            center = uniform(2) * torch.tensor([width, height])
            rows.append(center + (uniform(count, 3, 2) - 0.5) * 0.7 * min(height, width))
    structure = Structure.of_loops(counts, torch.tensor(is_line), torch.tensor(is_open))
    count = path_count + filled
    span = torch.tensor([widths[1] - widths[0]])
    strokes = Strokes(
        torch.where(torch.arange(count) < path_count, widths[0] + span * uniform(count), 0.0),
        torch.arange(count, dtype=torch.int32) % len(CAPS),
        (torch.arange(count, dtype=torch.int32) // len(CAPS)) % len(JOINS),
        1.0 + 5.0 * uniform(count),
    )
    values = (uniform(count, 3), 0.2 + 0.8 * uniform(count), uniform(3), torch.zeros(count, dtype=torch.int64))
    return Scene(straightened(torch.cat(rows), structure), structure, *values, strokes=strokes)


def reference_image(scene: Scene, renderer: ExactRenderer) -> Tensor:
    """Return the reference's image of a scene with strokes, with the chords of the last drawing by ``renderer``."""
    height, width = renderer.grid.height, renderer.grid.width
    polygons = reference_polygons(scene, renderer)
    stack = [coverage(sum(signed_coverage(polygon, height, width) for polygon in path)) for path in polygons]
    return composite(torch.stack(stack), scene.color, scene.opacity, scene.background)


def reference_polygons(scene: Scene, renderer: ExactRenderer) -> list[list[Tensor]]:
    """Return the polygons [V, 2] of each path, with the chords of the last drawing by ``renderer``."""
    flattening, structure = renderer._flattening, scene.structure
    first = torch.from_numpy(flattening.segment_first_vertex.numpy()[: len(scene.segments) + 1].copy()).long()
    plan = torch.from_numpy(flattening._stroking._plan.numpy()[: len(scene.segments)].copy()).long()
    found = []
    for path, loops in enumerate(pairwise(structure.path_first_loop.tolist())):
        found.append([])
        for loop in range(*loops):
            start, stop = structure.loop_first_segment[loop : loop + 2].tolist()
            rows, counts = scene.segments[start:stop], first.diff()[start:stop]
            if scene.strokes.width[path] == 0:
                found[-1].append(flatten_loop(rows.flatten(0, 1), counts.tolist()))
                continue
            chords = (counts - plan[start:stop, 1] - plan[start:stop, 3]) // 2 - 1
            found[-1] += stroke_polygons(rows, bool(structure.is_open[loop]), _look(scene, path), chords.tolist())
    return found


def _look(scene: Scene, path: int) -> Look:
    strokes = scene.strokes
    return Look(strokes.width[path], int(strokes.cap[path]), int(strokes.join[path]), float(strokes.miter_limit[path]))
