"""The number of paths that follows the PSNR of a fit, with losses and costs in place of a fit."""

from __future__ import annotations

import math
from typing import Any

import pytest
import torch
from stubs import circles
from torch import Tensor

from warpvec.fit.budget import QualityBudget
from warpvec.geometry.scene import Scene
from warpvec.image.metrics import psnr_from_mse


class Paths:
    """Stands in for a population."""

    def __init__(self, count: int) -> None:
        self.live = circles(32, 48, count)

    def remove(self, rows: Tensor) -> None:
        self.live = self.live.select(torch.ones(len(self.live), dtype=torch.bool).index_fill(0, rows, False))


def _loss(decibels: float) -> float:
    return 10.0 ** (-decibels / 10.0)


def _budget(offset: float = 0.0, curves_max: int = 1000) -> tuple[QualityBudget, list[float]]:
    """Return a budget for 25 dB, of files that have ``offset`` dB more than the losses in the list, the last one."""
    losses: list[float] = [_loss(25.0)]
    return QualityBudget(25.0, curves_max, lambda _: psnr_from_mse(losses[-1]) + offset), losses


@pytest.mark.parametrize(
    ("decibels", "least", "most"), [(20.0, 110, 130), (24.9, 101, 115), (25.4, 90, 99), (30.0, 75, 85)]
)
def test_the_count_goes_where_the_psnr_is_missing(decibels: float, least: int, most: int) -> None:
    budget, losses = _budget()
    losses.append(_loss(decibels))
    assert least <= budget.wanted_count(circles(32, 48, 100), _loss(decibels), 1400, 2000) <= most


def test_what_a_fit_still_gains_is_counted_on() -> None:
    budget, losses = _budget()
    losses.append(_loss(24.5))
    early, late = (budget.wanted_count(circles(32, 48, 100), _loss(24.5), share, 400) for share in (100, 280))
    assert early < 100 < late


def test_the_psnr_is_that_of_the_file() -> None:
    counts = []
    for offset in (-2.0, 2.0):
        budget, losses = _budget(offset)
        losses.append(_loss(25.0))
        counts.append(budget.wanted_count(circles(32, 48, 100), _loss(25.0), 1400, 2000))
    assert counts[0] > 100 > counts[1]


def test_the_most_curves_are_kept_to() -> None:
    assert _budget(curves_max=104)[0].wanted_count(circles(32, 48, 100), _loss(10.0), 1400, 2000) == 104


@pytest.mark.parametrize("decibels", [25.5, 27.0])
def test_paths_go_that_the_psnr_does_not_need(decibels: float) -> None:
    budget, losses = _budget()
    losses.append(_loss(decibels))
    costs = torch.linspace(0.0, 2e-4, 40)[torch.randperm(40, generator=torch.Generator().manual_seed(0))]
    paths: Any = Paths(40)
    before: Scene = paths.live
    assert budget.trim(paths, costs, _loss(decibels))
    kept = (before.color[:, None] == paths.live.color).all(2).any(1)
    assert costs[~kept].max() < costs[kept].min()
    assert 25.0 < psnr_from_mse(_loss(decibels) + float(costs[~kept].sum())) < decibels


def test_no_path_goes_if_the_psnr_is_missed_and_the_last_one_never_goes() -> None:
    paths: Any = Paths(40)
    assert not _budget()[0].trim(paths, torch.zeros(40), _loss(25.0))
    budget, losses = _budget()
    losses.append(_loss(60.0))
    assert budget.trim(paths, torch.zeros(40), _loss(60.0)) and len(paths.live) == 1
    assert math.isfinite(float(paths.live.segments.sum()))
