"""Fast replacements of slow functions, with the same types."""

from __future__ import annotations

from collections.abc import Callable

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.progress import FitResult, Progress
from warpvec.geometry.circles import circle_points, circle_sides
from warpvec.geometry.scene import Scene


def circles(height: int, width: int, count: int, config: FitConfig | None = None) -> Scene:
    """Return ``count`` opaque circles at random places in random colours, a quarter of the shorter side wide."""
    config = config or FitConfig()
    center = torch.rand(count, 2) * torch.tensor([width, height])
    radius = torch.full((count,), min(height, width) / 8)
    sides = config.path_model == "sides"
    points = circle_sides(center, radius, config.degree) if sides else circle_points(center, radius, config.segments)
    return Scene.uniform(
        points=points,
        color=torch.rand(count, 3),
        opacity=torch.ones(count),
        background=torch.tensor([0.25, 0.5, 0.75]),
        generation=torch.arange(count) // 16,
        degree=config.point_degree,
    )


def stub_fit(
    target: Tensor,
    config: FitConfig,
    on_progress: Callable[[Progress], None] | None = None,
    *,
    interrupted: bool = False,
    **_: object,
) -> FitResult:
    """Return random circles in place of `warpvec.fit.loop.fit`, after one call of ``on_progress`` per iteration."""
    height, width, _ = target.shape
    scene = circles(height, width, config.curves, config)
    history = []
    for iteration in range(1, config.iterations + 1):
        history.append({"iteration": iteration, "curves": config.curves, "psnr": 20.0, "seconds": 0.5 * iteration})
        if on_progress is not None:
            on_progress(progress_at(iteration, config.iterations, scene))
    seconds = 0.5 * config.iterations
    return FitResult(scene, history, config.iterations, seconds, interrupted=interrupted, device="cpu")


def progress_at(iteration: int, iteration_count: int, scene: Scene) -> Progress:
    """Return the progress of a fit at 20 dB that takes half a second per iteration."""
    return Progress(
        iteration=iteration,
        iteration_count=iteration_count,
        curve_count=len(scene),
        seconds=0.5 * iteration,
        loss=torch.tensor(0.01),
        scene=lambda: scene,
    )
