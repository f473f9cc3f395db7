"""Scenes whose paths have several loops and different numbers of segments."""

from __future__ import annotations

from itertools import pairwise

import torch
from scenes import circle, seeded
from torch import Tensor

from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure

Loops = list[list[Tensor]]
"""Control points [3 S, 2] of the loops of each path."""


def ring(x: float, y: float, outer: float, inner: float, turns: int = -1) -> list[Tensor]:
    """Return a circle and one inside it, which runs the other way and is a hole if ``turns`` is -1."""
    return [circle(x, y, outer), circle(x, y, inner, 3, turns)]


def compound_loops(seed: int, path_count: int, height: int, width: int) -> Loops:
    """Return rings, single loops of 1 to 6 segments, and paths of three loops that cross each other and themselves."""
    generator = seeded(seed)

    def loop() -> Tensor:
        count = int(torch.randint(1, 7, (), generator=generator))
        center = torch.rand(2, generator=generator, dtype=torch.float64) * torch.tensor([width, height])
        return center + 0.2 * max(height, width) * torch.randn(3 * count, 2, generator=generator, dtype=torch.float64)

    def hollow() -> list[Tensor]:
        x, y, share = torch.rand(3, generator=generator, dtype=torch.float64).tolist()
        radius = 0.4 * min(height, width)
        noise = 0.02 * radius
        loops = ring(x * width, y * height, radius, (0.3 + 0.5 * share) * radius)
        return [each + noise * torch.randn(each.shape, generator=generator, dtype=torch.float64) for each in loops]

    kinds = (hollow, lambda: [loop()], lambda: [loop() for _ in range(3)])
    return [kinds[path % 3]() for path in range(path_count)]


def scene_of_loops(loops: Loops, seed: int = 0) -> Scene:
    """Return a scene of these paths with random colours, opacities from 0.2 to 1, and a random background."""
    generator = seeded(seed)
    structure = Structure.of_loops([[len(loop) // 3 for loop in path] for path in loops])
    segments = torch.cat([torch.zeros(0, 2), *(loop for path in loops for loop in path)]).double().reshape(-1, 3, 2)
    count = len(loops)
    color, opacity, background = (
        torch.rand(shape, generator=generator, dtype=torch.float64) for shape in ((count, 3), (count,), (3,))
    )
    return Scene(segments, structure, color, 0.2 + 0.8 * opacity, background, torch.arange(count))


def compound_scene(seed: int, path_count: int, height: int, width: int) -> Scene:
    """Return a scene of `compound_loops`."""
    return scene_of_loops(compound_loops(seed, path_count, height, width), seed)


def split_into_loops(rows: Tensor, structure: Structure) -> list[list[Tensor]]:
    """Return ``rows`` [R, ...] by path and loop."""
    loops = [rows[first:end] for first, end in pairwise(structure.loop_first_segment.tolist())]
    return [loops[first:end] for first, end in pairwise(structure.path_first_loop.tolist())]
