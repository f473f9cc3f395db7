"""Make SVG files for tests, and take them apart."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import pytest
import torch

from warpvec.errors import InputError
from warpvec.geometry.circles import circle_points
from warpvec.geometry.scene import Scene
from warpvec.writers import cairo


def make_scene(path_count: int, segment_count: int = 4, seed: int = 0, size: tuple[int, int] = (768, 512)) -> Scene:
    """Make wobbly circles inside and across the canvas, in three generations, a few of them translucent."""
    generator = torch.Generator().manual_seed(seed)
    canvas = torch.tensor(size, dtype=torch.float32)
    center = (1.2 * torch.rand(path_count, 2, generator=generator) - 0.1) * canvas
    radius = 30 * torch.rand(path_count, generator=generator) ** 2 + 4
    wobble = torch.randn(path_count, 3 * segment_count, 2, generator=generator)
    translucent = torch.rand(path_count, generator=generator) < 0.2
    return Scene.uniform(
        points=circle_points(center, radius, segment_count) + 0.25 * radius[:, None, None] * wobble,
        color=torch.rand(path_count, 3, generator=generator),
        opacity=torch.where(translucent, 0.1 + 0.8 * torch.rand(path_count, generator=generator), 1.0),
        background=torch.rand(3, generator=generator),
        generation=3 * torch.arange(path_count) // max(path_count, 1),
    )


def path_elements(svg: str) -> list[ElementTree.Element]:
    return list(ElementTree.fromstring(svg).iter(SVG + "path"))


def absolute_data(points: list[list[float]]) -> str:
    first, *rest = [f"{x} {y}" for x, y in points]
    return f"M{first}C{' '.join([*rest, first])}z"


def with_path_data(svg: str, path_data: list[str]) -> str:
    data = iter(path_data)
    return re.sub(' d="[^"]*"', lambda _: f' d="{next(data)}"', svg)


def svg_file(content: str = "", attributes: str = 'width="8" height="4"', before: str = "") -> str:
    return f"{before}<svg {NS} {attributes}>{content}</svg>"


def square_file(content: str, attributes: str = 'width="64" height="64"') -> str:
    """Return an SVG with xlink, of 64 x 64 pixels unless its ``attributes`` say otherwise."""
    return svg_file(content, f'xmlns:xlink="http://www.w3.org/1999/xlink" {attributes}')


def refusal(function, *arguments) -> str:
    with pytest.raises(InputError) as caught:
        function(*arguments)
    assert "\n" not in str(caught.value)
    return str(caught.value)


SVG = "{http://www.w3.org/2000/svg}"
NS = 'xmlns="http://www.w3.org/2000/svg"'
SQUARE = '<rect width="20" height="20" fill="red"/>'


def skip_without_cairo() -> None:
    """Skip a test where the system's library cairo, which PDF and EPS need, is missing."""
    try:
        cairo.load("out.pdf", "OUT")
    except InputError as error:
        pytest.skip(str(error))


def mask_bomb() -> str:
    """Return a file of 30 nested masks, each drawn twice for the next one, that takes minutes."""
    masks = "".join(
        f'<mask id="m{k}">' + 2 * f'<rect width="8" height="4" fill="#fff" mask="url(#m{k + 1})"/>' + "</mask>"
        for k in range(30)
    )
    return svg_file(masks + '<rect width="8" height="4" mask="url(#m0)"/>')
