"""Stand-ins for what is slow, with the same types."""

from __future__ import annotations

from collections.abc import Callable

import torch
from torch import Tensor

from warpvec.config import FitConfig
from warpvec.fit import FitResult, Progress
from warpvec.scene import Scene, circle_points


def circles(height: int, width: int, count: int, segment_count: int = 4) -> Scene:
    """``count`` opaque circles of random place and colour, a quarter of the shorter side wide."""
    center = torch.rand(count, 2) * torch.tensor([width, height])
    radius = torch.full((count,), min(height, width) / 8)
    return Scene(
        points=circle_points(center, radius, segment_count),
        color=torch.rand(count, 3),
        opacity=torch.ones(count),
        background=torch.tensor([0.25, 0.5, 0.75]),
        generation=torch.arange(count) // 16,
    )


def stub_fit(
    target: Tensor,
    config: FitConfig,
    on_progress: Callable[[Progress], None] | None = None,
    *,
    interrupted: bool = False,
) -> FitResult:
    """What `warpvec.fit.fit` returns, without fitting: random circles, one call of ``on_progress`` an iteration."""
    height, width, _ = target.shape
    scene = circles(height, width, config.curves, config.segments)
    history = []
    for iteration in range(1, config.iterations + 1):
        history.append({"iteration": iteration, "curves": config.curves, "psnr": 20.0, "seconds": 0.5 * iteration})
        if on_progress is not None:
            on_progress(progress_at(iteration, config.iterations, scene))
    seconds = 0.5 * config.iterations
    return FitResult(scene, history, config.iterations, seconds, interrupted=interrupted, device="cpu")


def progress_at(iteration: int, iteration_count: int, scene: Scene) -> Progress:
    """The record of one iteration of a fit at 20 dB that takes half a second for each."""
    return Progress(
        iteration=iteration,
        iteration_count=iteration_count,
        curve_count=len(scene),
        seconds=0.5 * iteration,
        loss=torch.tensor(0.01),
        scene=lambda: scene,
    )
