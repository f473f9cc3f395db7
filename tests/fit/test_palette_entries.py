"""The entries of a fitted palette: distinct ones, as many as were asked for, and none that nobody has for long."""

from __future__ import annotations

import re
from itertools import pairwise

import numpy as np
import pytest
import torch
from numpy.typing import NDArray
from PIL import Image, ImageDraw
from scenes import blob_scene

import warpvec
from warpvec.config.fit_config import FitConfig
from warpvec.fit.palette import SWITCH_GAP, Palette
from warpvec.rendering.exact import ExactRenderer

HEIGHT, WIDTH = 40, 56


def _flat_logo() -> NDArray[np.uint8]:
    """Five colours, of which yellow has one pixel of a hundred."""
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
    assert result.metrics["psnr"] > 32.0  # 35.6; 26 where one of them is missing


@pytest.mark.parametrize("count", [2, 3, 7, 40])
@pytest.mark.parametrize("seed", range(3))
def test_as_many_distinct_entries_as_were_asked_for(seed: int, count: int) -> None:
    generator = torch.Generator().manual_seed(seed)
    # Two crowds of all but one colour, of which little is seen, and a path in one colour that is seen everywhere.
    color = torch.tensor([[0.2, 0.5, 0.4], [0.7, 0.5, 0.4]]).repeat(60, 1)
    color = color + 0.04 * torch.rand((120, 3), generator=generator)
    shown = torch.cat([torch.rand(120, generator=generator), torch.tensor([1e6])])
    palette = Palette(FitConfig(colors=count), HEIGHT * WIDTH)
    palette.start(torch.cat([color, torch.tensor([[0.9, 0.1, 0.9]])]), shown, False)
    assert len(torch.unique(palette.color, dim=0)) == count


def test_colours_that_are_enough_for_all_are_taken_as_they_are() -> None:
    color = torch.tensor([[10, 20, 30], [10, 20, 31], [200, 0, 0], [10, 20, 30], [0, 0, 255]]) / 255.0
    palette = Palette(FitConfig(colors=6), 100)
    palette.start(color, torch.tensor([1e-3, 0.0, 50.0, 3.0, 0.0]), False)
    torch.testing.assert_close(palette.color, color)


def _learned_case(seed: int, count: int) -> tuple[Palette, ExactRenderer, tuple[torch.Tensor, ...], torch.Tensor]:
    """A palette of ``count`` for paths that are all grey, their renderer in float64, and a target of three colours."""
    blobs = blob_scene(seed, 14, HEIGHT, WIDTH)
    palette = Palette(FitConfig(colors=count), HEIGHT * WIDTH)
    palette.start(torch.full((15, 3), 0.4, dtype=torch.float64), torch.ones(15), False)
    target = torch.zeros((HEIGHT, WIDTH, 3), dtype=torch.float64)
    target[:, :20, 0], target[:, 20:40, 1], target[:, 40:, 2] = 0.9, 0.8, 1.0
    return palette, ExactRenderer(HEIGHT, WIDTH, dtype=torch.float64), (blobs.points, blobs.opacity), target


def _step(palette: Palette, renderer: ExactRenderer, paths: tuple[torch.Tensor, ...], target: torch.Tensor) -> float:
    """Take a step of ``palette``; the loss before it."""
    points, opacity = paths
    color = palette.color.double()
    adjoints = renderer.fit_step(points, color[:-1], opacity, color[-1], renderer.prepare_target(target))
    ones = renderer.adjoint(points, color[:-1], opacity, color[-1], torch.ones_like(target))
    adj_color = torch.cat([adjoints.color, adjoints.background[None]])
    palette.step(adj_color, torch.cat([ones.color[:, 0], ones.background[:1]]), 1.0)
    return float(adjoints.loss)


@pytest.mark.parametrize("seed", range(4))
def test_entries_that_nobody_has_go_to_paths_that_want_them(seed: int) -> None:
    case = _learned_case(seed, 4)
    assert len(torch.unique(case[0].color, dim=0)) == 1
    losses = [_step(*case) for _ in range(12)]
    assert len(torch.unique(case[0].color, dim=0)) == 4
    assert all(after <= before + 1e-6 for before, after in pairwise(losses))
    assert losses[-1] < 0.85 * losses[0]


def test_an_entry_that_went_elsewhere_starts_afresh() -> None:
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


@pytest.mark.parametrize("seed", range(4))
def test_the_bound_of_a_change_holds_for_all_paths_together(seed: int) -> None:
    _, renderer, (points, opacity), target = _learned_case(seed, 2)
    generator = torch.Generator().manual_seed(seed)
    color = torch.rand((15, 3), generator=generator, dtype=torch.float64)
    prepared = renderer.prepare_target(target)
    adjoints = renderer.fit_step(points, color[:-1], opacity, color[-1], prepared)
    adj_color, loss = torch.cat([adjoints.color, adjoints.background[None]]).clone(), float(adjoints.loss)
    ones = renderer.adjoint(points, color[:-1], opacity, color[-1], torch.ones_like(target))
    shown = torch.cat([ones.color[:, 0], ones.background[:1]]).clone()
    for size in (0.01, 0.3, 1.0):
        change = size * (torch.rand((15, 3), generator=generator, dtype=torch.float64) - color)
        other = color + change
        after = (renderer.render(points, other[:-1], opacity, other[-1]) - target).square().mean()
        bound = (adj_color * change).sum() + (shown[:, None] * change.square()).sum() / target.numel()
        assert float(after) - loss <= float(bound) + 1e-12
