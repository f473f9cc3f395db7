"""Fast replacements of slow functions, with the same types."""

from __future__ import annotations

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.path_models import path_model
from warpvec.geometry.scene import Scene
from warpvec.watch.progress import Progress
from warpvec.watch.watch import FitResult, Part, Watch


def circles(height: int, width: int, count: int, config: FitConfig | None = None) -> Scene:
    """Return ``count`` opaque circles at random places in random colours, a quarter of the shorter side wide."""
    config = config or FitConfig()
    model = path_model(config)
    center = torch.rand(count, 2) * torch.tensor([width, height])
    radius = torch.full((count,), min(height, width) / 8)
    return Scene.uniform(
        points=model.circles(center, radius),
        color=torch.rand(count, 3),
        opacity=torch.ones(count),
        background=torch.tensor([0.25, 0.5, 0.75]),
        generation=torch.arange(count) // 16,
        degree=model.degree,
    )


def stub_fit(
    target: Tensor, config: FitConfig, part: Part | None = None, *, interrupted: bool = False, **_: object
) -> FitResult:
    """Return random circles in place of `warpvec.fit.loop.fit`, after one report per iteration."""
    part = Watch().part() if part is None else part
    height, width, _ = target.shape
    scene = circles(height, width, config.curves, config)
    for iteration in range(1, config.iterations + 1):
        part.report(progress_at(iteration, config.iterations, scene), is_entry=True)
    if interrupted:
        part.interrupted = True
    return part.result(scene, "cpu")


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
