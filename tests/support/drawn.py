"""Draw a scene with the exact renderer and with resvg, and bound how far the images may differ."""

from __future__ import annotations

from dataclasses import replace

import torch
from oracles import make_renderer
from scenes import SceneTensors
from torch import Tensor

from warpvec.geometry.scene import Scene
from warpvec.svg.measure import draw
from warpvec.svg.quantize import quantize
from warpvec.svg.write import write_svg

SAMPLES = 4
"""Samples of resvg per pixel and axis."""

ONE_EDGE = 1 / (2 * SAMPLES)
"""Coverage error where one straight edge crosses a pixel along the grid: half a row of samples."""

ONE_PATH = 2 * ONE_EDGE
"""Coverage error allowed for a path in a pixel."""

EIGHT_BIT = 1 / 255
"""resvg blends in 8 bits: for each path it rounds colour, alpha and their products by up to half of this."""


def exact_and_drawn(scene: SceneTensors) -> tuple[Tensor, Tensor]:
    """Return our image and resvg's [h, w, 3] of the quantized scene."""
    written = quantized(scene)
    renderer = make_renderer(scene)
    exact = renderer.render(written)
    drawing = draw(write_svg(written, scene.width, scene.height), scene.width, scene.height)
    return exact, torch.from_numpy(drawing / 255.0)


def antialiasing_bound(scene: SceneTensors) -> Tensor:
    """Return the largest difference [h, w, 3] caused by an error ``ONE_PATH`` in the coverage of all edge pixels.

    Blending C <- C + a (c - C), with a off by e and C by E, is off by at most (1 - a + e) E + e |c - C|.
    """
    written = quantized(scene)
    renderer = make_renderer(scene)
    black, white = torch.zeros(3, dtype=torch.float64), torch.ones(1, 3, dtype=torch.float64)
    image = written.background.repeat(scene.height, scene.width, 1)
    bound = torch.zeros_like(image)
    for row, (points, color, opacity) in enumerate(zip(written.points, written.color, written.opacity, strict=True)):
        box = bounding_box(points)
        path = replace(written.select(torch.tensor([row])), color=white, opacity=white[0, :1], background=black)
        cover = renderer.render(path)[box][..., :1]
        rounding = EIGHT_BIT * (cover > 0)
        error = opacity * ONE_PATH * near((cover > 0) & (cover < 1)) + rounding
        alpha, difference = opacity * cover, color - image[box]
        bound[box] = (1 - alpha + error).clamp(max=1) * bound[box] + error * difference.abs() + 2 * rounding
        image[box] += alpha * difference
    return bound


def quantized(scene: SceneTensors) -> Scene:
    """Return the scene as its file has it: with 2 decimals."""
    return quantize(Scene.uniform(*scene[:4], torch.zeros(len(scene.points), dtype=torch.int64)), 2)


def bounding_box(points: Tensor) -> tuple[slice, slice]:
    """Return the rows and columns of a path's pixels and their neighbours."""
    (left, top), (right, bottom) = points.amin(0).tolist(), points.amax(0).tolist()
    return slice(max(int(top) - 2, 0), max(int(bottom) + 3, 0)), slice(max(int(left) - 2, 0), max(int(right) + 3, 0))


def near(mask: Tensor) -> Tensor:
    """Return the pixels [h, w, 1] of ``mask`` and their neighbours, as a moved curve may cross a pixel border."""
    grown = torch.nn.functional.max_pool2d(mask.double().permute(2, 0, 1)[None], 3, 1, 1)
    return grown[0].permute(1, 2, 0)
