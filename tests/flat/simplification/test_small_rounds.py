"""Tests of warpvec.flat.simplification.small_rounds: rough small rings become circles where the picture agrees."""

from __future__ import annotations

import math

import torch
from flat_drawings import BLUE, RED, drawing, picture
from scenes import circle, straight

from warpvec.config.fit_config import FitConfig
from warpvec.flat.simplification.critic import Critic
from warpvec.flat.simplification.small_rounds import with_small_rounds

CONFIG = FitConfig(threads=1)


def polygon(x: float, y: float, radius: float, count: int = 7) -> torch.Tensor:
    turns = [2.0 * math.pi * k / count for k in range(count)]
    return straight(*((x + radius * math.cos(turn), y + radius * math.sin(turn)) for turn in turns))


def test_a_roughly_traced_ring_becomes_two_circles() -> None:
    image = picture(drawing((RED, [circle(30.3, 30.6, 6.0)]), (BLUE, [circle(30.3, 30.6, 4.6)])))
    traced = drawing((RED, [polygon(30.3, 30.6, 6.2)]), (BLUE, [polygon(30.3, 30.6, 4.8)]))

    found = with_small_rounds(traced, Critic(image, CONFIG))

    apart = torch.linalg.norm(found.segments[:, 0] - torch.tensor([30.3, 30.6]), dim=1)
    assert len(apart) == 8
    assert (apart - torch.tensor([6.0, 4.6]).repeat_interleave(4)).abs().max() < 0.25


def test_a_polygon_that_the_picture_shows_stays_one() -> None:
    traced = drawing((RED, [polygon(30.3, 30.6, 9.0, count=6)]))
    assert len(with_small_rounds(traced, Critic(picture(traced), CONFIG)).segments) == 6
