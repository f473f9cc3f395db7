"""Soft paths are fitted: their outline, standard deviation, colour and opacity."""

from __future__ import annotations

from dataclasses import replace

import pytest
import torch

from warpvec.config.fit_config import FitConfig
from warpvec.fit.target import Target
from warpvec.geometry.scene import Scene
from warpvec.geometry.softness import Softness
from warpvec.image.metrics import psnr
from warpvec.polish.polish import polish
from warpvec.rendering.draw import draw_exactly

SIDE = 48


def disc(x: float, y: float, color: tuple[float, float, float], opacity: float, sigma: float) -> Scene:
    """Return a soft disc over white."""
    turn = torch.arange(12) / 12 * 2 * torch.pi
    points = torch.tensor([x, y]) + 11.0 * torch.stack([turn.cos(), turn.sin()], -1)[None]
    paint = (torch.tensor([color]), torch.tensor([opacity]), torch.ones(3), torch.zeros(1, dtype=torch.int64))
    return replace(Scene.uniform(points.float(), *paint), softness=Softness(torch.tensor([sigma])))


def with_shadow(shadow: Scene) -> Scene:
    return shadow.joined(disc(22.0, 21.0, (0.9, 0.3, 0.2), 1.0, 0.0))


def test_a_shadow_is_fitted() -> None:
    config = FitConfig(opacity="free", threads=1)
    image = torch.from_numpy(draw_exactly(with_shadow(disc(24.0, 24.0, (0.1, 0.1, 0.1), 0.6, 3.0)), SIDE, SIDE, 1))
    start = with_shadow(disc(22.5, 22.0, (0.2, 0.2, 0.2), 0.7, 2.0))
    found = polish(Target(image, config, "cpu"), start, config, iterations=200).scene
    assert found.softness is not None
    assert found.softness.sigma.tolist() == [pytest.approx(3.0, rel=0.1), 0.0]
    assert psnr(draw_exactly(found, SIDE, SIDE, 1), image.numpy()) > 50.0
