"""The entries of a fitted palette: distinct, as many as requested, all used, and pure black and white where due."""

from __future__ import annotations

import re
from itertools import pairwise

import numpy as np
import pytest
import torch
from numpy.typing import NDArray
from oracles import painted
from PIL import Image, ImageDraw
from scenes import blob_scene

import warpvec
from warpvec.config.fit_config import FitConfig
from warpvec.fit.palette import SWITCH_GAP, Palette, with_pure_colors
from warpvec.geometry.scene import Scene
from warpvec.rendering.exact import ExactRenderer

HEIGHT, WIDTH = 40, 56


def _flat_logo() -> NDArray[np.uint8]:
    """A logo of five colours; one pixel in a hundred is yellow."""
    image = Image.new("RGB", (120, 90), (255, 255, 255))
    draw = ImageDraw.Draw(image)
    draw.ellipse((15, 11, 75, 71), fill=(20, 60, 160))
    draw.rectangle((64, 38, 112, 79), fill=(200, 30, 40))
    draw.polygon([(38, 22), (52, 56), (22, 56)], fill=(30, 160, 80))
    draw.ellipse((84, 49, 97, 62), fill=(250, 210, 30))
    return np.asarray(image)


def _fills(svg: str) -> set[str]:
    return set(re.findall(r'fill="(.*?)"', svg))


def test_a_flat_logo_of_five_colours_gets_all_five() -> None:
    result = warpvec.vectorize(_flat_logo(), 48, preset="draft", colors=5, device="cpu", threads=2)
    assert len(_fills(result.svg())) == 5
    assert result.metrics["psnr"] > 32.0  # 35.6 dB, or 26 without one of the colours


@pytest.mark.parametrize("count", [2, 3, 7, 40])
@pytest.mark.parametrize("seed", range(3))
def test_as_many_distinct_entries_as_requested(seed: int, count: int) -> None:
    generator = torch.Generator().manual_seed(seed)
    # Two crowds of similar colours with small visible areas, and one path that is visible everywhere.
    color = torch.tensor([[0.2, 0.5, 0.4], [0.7, 0.5, 0.4]]).repeat(60, 1)
    color = color + 0.04 * torch.rand((120, 3), generator=generator)
    area = torch.cat([torch.rand(120, generator=generator), torch.tensor([1e6])])
    palette = Palette(FitConfig(colors=count), HEIGHT * WIDTH)
    palette.start(torch.cat([color, torch.tensor([[0.9, 0.1, 0.9]])]), area, False)
    assert len(torch.unique(palette.color, dim=0)) == count


def test_a_palette_large_enough_for_all_colours_keeps_them() -> None:
    color = torch.tensor([[10, 20, 30], [10, 20, 31], [200, 0, 0], [10, 20, 30], [0, 0, 255]]) / 255.0
    palette = Palette(FitConfig(colors=6), 100)
    palette.start(color, torch.tensor([1e-3, 0.0, 50.0, 3.0, 0.0]), False)
    torch.testing.assert_close(palette.color, color)


def _learned_case(seed: int, count: int) -> tuple[Palette, ExactRenderer, tuple[torch.Tensor, ...], torch.Tensor]:
    """A palette of ``count`` entries for grey paths, their renderer in float64, and a target of three colours."""
    blobs = blob_scene(seed, 14, HEIGHT, WIDTH)
    palette = Palette(FitConfig(colors=count), HEIGHT * WIDTH)
    palette.start(torch.full((15, 3), 0.4, dtype=torch.float64), torch.ones(15), False)
    target = torch.zeros((HEIGHT, WIDTH, 3), dtype=torch.float64)
    target[:, :20, 0], target[:, 20:40, 1], target[:, 40:, 2] = 0.9, 0.8, 1.0
    return palette, ExactRenderer(HEIGHT, WIDTH, dtype=torch.float64), (blobs.points, blobs.opacity), target


def _step(palette: Palette, renderer: ExactRenderer, paths: tuple[torch.Tensor, ...], target: torch.Tensor) -> float:
    """Take a step of ``palette``; return the loss before it."""
    color = palette.color.double()
    adjoints = renderer.fit_step(painted(paths, color), renderer.prepare_target(target))
    ones = renderer.adjoint(painted(paths, color), torch.ones_like(target))
    adj_color = torch.cat([adjoints.color, adjoints.background[None]])
    palette.step(adj_color, torch.cat([ones.color[:, 0], ones.background[:1]]), 1.0)
    return float(adjoints.loss)


@pytest.mark.parametrize("seed", range(2))
def test_unused_entries_move_to_paths_that_need_them(seed: int) -> None:
    case = _learned_case(seed, 4)
    assert len(torch.unique(case[0].color, dim=0)) == 1
    losses = [_step(*case) for _ in range(12)]
    assert len(torch.unique(case[0].color, dim=0)) == 4
    assert all(after <= before + 1e-6 for before, after in pairwise(losses))
    assert losses[-1] < 0.85 * losses[0]


def test_an_entry_that_moved_starts_afresh() -> None:
    palette, renderer, paths, target = _learned_case(0, 2)
    for _ in range(SWITCH_GAP):
        palette.step(torch.full((15, 3), 1e-3, dtype=torch.float64), None, 1.0)
    assert palette.state()["optimizer"]["step"].tolist() == [SWITCH_GAP] * 2
    before = palette.state()["free"].clone()
    _step(palette, renderer, paths, target)
    moved = (palette.state()["free"] != before).any(1)
    assert int(moved.sum()) == 1
    assert not any(values[moved].any() for values in palette.state()["optimizer"].values())
    assert palette.state()["optimizer"]["step"][~moved].tolist() == [SWITCH_GAP]


@pytest.mark.parametrize("seed", range(2))
def test_the_bound_of_a_change_holds_for_all_paths_together(seed: int) -> None:
    _, renderer, paths, target = _learned_case(seed, 2)
    generator = torch.Generator().manual_seed(seed)
    color = torch.rand((15, 3), generator=generator, dtype=torch.float64)
    prepared = renderer.prepare_target(target)
    adjoints = renderer.fit_step(painted(paths, color), prepared)
    adj_color, loss = torch.cat([adjoints.color, adjoints.background[None]]).clone(), float(adjoints.loss)
    ones = renderer.adjoint(painted(paths, color), torch.ones_like(target))
    area = torch.cat([ones.color[:, 0], ones.background[:1]]).clone()
    for size in (0.01, 0.3, 1.0):
        change = size * (torch.rand((15, 3), generator=generator, dtype=torch.float64) - color)
        other = color + change
        after = (renderer.render(painted(paths, other)) - target).square().mean()
        bound = (adj_color * change).sum() + (area[:, None] * change.square()).sum() / target.numel()
        assert float(after) - loss <= float(bound) + 1e-12


# pure black and white


def _drawing(black: int, white: int) -> NDArray[np.uint8]:
    """A ring, a block and a line in the grey ``black`` on ``white``, with antialiased edges."""
    image = Image.new("L", (480, 360), white)
    draw = ImageDraw.Draw(image)
    draw.ellipse((45, 33, 225, 213), fill=black)
    draw.ellipse((90, 78, 180, 168), fill=white)
    draw.rectangle((270, 114, 450, 237), fill=black)
    draw.line((30, 300, 450, 270), fill=black, width=12)
    return np.asarray(image.resize((160, 120), Image.Resampling.BOX).convert("RGB"))


def _fitted_fills(image: NDArray[np.uint8], colors: int) -> set[str]:
    settings = {"colors": colors, "opacity": "opaque", "initial_curves": 8, "iterations": 150, "inflation_gap": 10}
    return _fills(warpvec.vectorize(image, 32, device="cpu", threads=2, **settings).svg())


def test_a_black_and_white_drawing_gets_pure_black_and_white() -> None:
    assert _fitted_fills(_drawing(0, 255), 2) == {"#000", "#fff"}


def test_a_dark_grey_of_the_image_stays() -> None:
    fills = _fitted_fills(_drawing(5, 250), 2)
    assert not fills & {"#000", "#fff"}
    assert all(min(abs(int(fill[1:3], 16) - grey) for grey in (5, 250)) <= 4 for fill in fills)


def _scene(*levels: int, transparent: bool = False) -> Scene:
    color = torch.tensor(levels, dtype=torch.float32)[:, None].expand(-1, 3) / 255.0
    points, zeros = torch.zeros(len(levels), 12, 2), torch.zeros(len(levels))
    return Scene.uniform(points, color, zeros, torch.full((3,), 250.0 / 255.0), zeros.long(), transparent=transparent)


def _levels(color: torch.Tensor) -> list[int]:
    return (color[..., 0] * 255.0).round().int().flatten().tolist()


@pytest.mark.parametrize(("dark", "reach"), [(200, 32), (32, 16), (16, 8)])
def test_only_colours_near_a_pure_one_become_it(dark: int, reach: int) -> None:
    """Two fifths of the target are black, the others a grey ``dark``, so that black reaches less far than that."""
    target = torch.zeros(10, 10, 3)
    target[:, 4:] = dark / 255.0
    scene = with_pure_colors(_scene(0, reach, reach + 1, 128), target)
    assert _levels(scene.color) == [0, 0, reach + 1, 128]
    target = 1.0 - target
    scene = with_pure_colors(_scene(255, 255 - reach, 254 - reach, 128), target)
    assert _levels(scene.color) == [255, 255, 254 - reach, 128]
    assert _levels(scene.background) == [255]


@pytest.mark.parametrize(("black", "dark", "expected"), [(20, 0, 0), (5, 0, 5), (40, 30, 5), (40, 10, 0)])
def test_black_needs_a_share_of_the_pixels_and_most_of_the_dark_ones(black: int, dark: int, expected: int) -> None:
    """Of 1000 pixels ``black`` are exactly black and ``dark`` are #050505."""
    target = torch.full((1000, 3), 0.5)
    target[:black] = 0.0
    target[black : black + dark] = 5.0 / 255.0
    assert _levels(with_pure_colors(_scene(5), target.reshape(20, 50, 3)).color) == [expected]


def test_only_visible_pixels_of_a_transparent_image_count() -> None:
    target = torch.zeros(20, 20, 4)
    target[5:15, 5:15] = torch.tensor([0.5, 0.5, 0.5, 1.0])
    scene = _scene(5, transparent=True)
    assert _levels(with_pure_colors(scene, target).color) == [5]
    target[5, 5:15, :3] = 0.0
    assert _levels(with_pure_colors(scene, target).color) == [0]
    assert _levels(with_pure_colors(scene, target).background) == [250]


def test_many_paths_move_an_entry_by_the_same_bits_every_time(device: str) -> None:
    count = 20_000
    color, gradient = torch.rand(count + 1, 3, device=device), torch.randn(count + 1, 3, device=device)
    found = []
    for _ in range(3):
        palette = Palette(FitConfig(colors=2), 100)
        palette.start(color, torch.ones(count + 1, device=device), False)
        palette.step(gradient, None, 1.0)
        found.append(palette.state()["optimizer"]["previous_grad"])
    own = torch.nn.functional.one_hot(palette.state()["entry"], 2).double()
    torch.testing.assert_close(found[0], (own.T @ gradient.double()).float(), rtol=1e-4, atol=1e-2)
    assert all(torch.equal(values, found[0]) for values in found)
