"""Small drawings of opaque paths, and their pictures, for tests of flat art."""

from __future__ import annotations

import torch
from torch import Tensor

from warpvec.geometry.joints import with_lines
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure
from warpvec.rendering.draw import draw_exactly

SIZE = 64
"""Height and width of the pictures."""

BLACK, RED, BLUE = (0.0, 0.0, 0.0), (0.8, 0.0, 0.1), (0.0, 0.2, 0.7)

Path = tuple[tuple[float, float, float], list[Tensor]]
"""The colour of a path, and the control points [3 S, 2] of its loops, as `scenes.circle` returns them."""


def drawing(*paths: Path) -> Scene:
    """Return the paths over white, the first at the bottom; straight curves are lines."""
    loops = [loop for _, path in paths for loop in path]
    structure = Structure.of_loops([[len(loop) // 3 for loop in path] for _, path in paths])
    segments = torch.cat(loops).float().reshape(-1, 3, 2)
    color, count = torch.tensor([color for color, _ in paths]), len(paths)
    return with_lines(Scene(segments, structure, color, torch.ones(count), torch.ones(3), torch.arange(count)))


def picture(scene: Scene) -> Tensor:
    """Return the picture [h, w, 3] of ``scene`` in levels of 8 bits."""
    return (torch.from_numpy(draw_exactly(scene, SIZE, SIZE, 1)) * 255.0).round() / 255.0


def error(scene: Scene, image: Tensor) -> float:
    """Return the root of the mean squared error of ``scene``, in levels of 255."""
    return 255.0 * float((picture(scene) - image).square().mean().sqrt())


def line_count(scene: Scene) -> int:
    """Return the number of lines."""
    return 0 if scene.structure.is_line is None else int(scene.structure.is_line.sum())
