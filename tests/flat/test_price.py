"""The nats of words, against counts by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import torch

from warpvec.flat.price import COLOR_NATS, Words, number_nats, words_of
from warpvec.geometry.scene import Scene
from warpvec.geometry.structure import Structure


def squares(colors: list[list[float]]) -> Scene:
    """Return a square of four lines in each of ``colors``, without a canvas."""
    corners = torch.tensor([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]])
    thirds = [torch.lerp(corners, corners.roll(-1, 0), k / 3) for k in range(3)]
    rows = torch.stack(thirds, 1)
    count = len(colors)
    return Scene(
        rows.repeat(count, 1, 1),
        Structure.of_loops([[4]] * count, torch.ones(4 * count, dtype=torch.bool)),
        torch.tensor(colors),
        torch.ones(count),
        torch.zeros(3),
        torch.zeros(count, dtype=torch.int64),
        transparent=True,
    )


def test_lines_are_two_numbers_and_a_colour_is_said_once() -> None:
    red, blue = [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]
    assert words_of(squares([red, blue])) == Words(16, 2, 0)
    assert words_of(squares([red, red])) == Words(16, 1, 1)
    same, other = words_of(squares([red, red])).nats(512), words_of(squares([red, blue])).nats(512)
    assert other - same > 0.9 * COLOR_NATS


def test_a_number_takes_more_in_a_larger_picture() -> None:
    assert math.isclose(number_nats(1024) - number_nats(512), math.log(2.0))


def test_cubics_and_opacities_count() -> None:
    points = torch.rand(3, 12, 2)
    looks = {"color": torch.rand(3, 3), "background": torch.ones(3), "generation": torch.zeros(3, dtype=torch.int64)}
    opaque = Scene.uniform(points, opacity=torch.ones(3), **looks)
    assert words_of(opaque).number_count == 3 * 4 * 6
    assert words_of(replace(opaque, opacity=torch.tensor([0.5, 1.0, 0.5]))).number_count == 3 * 4 * 6 + 2
