"""Polish a drawing and give those of its flat paths a gradient that gain most by it."""

from __future__ import annotations

from dataclasses import replace

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.loop import single_torch_thread
from warpvec.fit.progress import FitResult, OnProgress
from warpvec.fit.ramps import Ramps, best_ramps, with_ramps
from warpvec.fit.target import Target
from warpvec.geometry.gradients import FLAT
from warpvec.geometry.scene import Scene
from warpvec.rendering.launch import resolve_device
from warpvec.rendering.streams import on_warps_stream
from warpvec.vectorization.continued_polish import ContinuedPolish

ROUNDS, ITERATIONS = 2, 40
"""Times that paths are chosen, and the iterations before each: what a ramp gains shows once the edges are in place, and
what a smaller one gains once the larger ones are."""

GAIN_MIN, CHANGE_MIN = 0.01, 4.0 / 255
"""A path stays flat if a gradient would lower the loss by a smaller share of it, or would change no channel by more."""


def polish_with_gradients(
    image: Tensor,
    start: Scene,
    config: FitConfig,
    on_progress: OnProgress | None,
    iterations: int,
    free: bool,
    locked: Tensor | None,
) -> FitResult:
    """Fit ``start`` as `polish` does; in between, flat paths get the linear gradients that ``config`` asks for."""
    work = ContinuedPolish(image, config, on_progress, iterations, free, locked)
    done = FitResult(start, [], 0, 0.0, False, resolve_device(config.device))
    for _ in range(ROUNDS):
        done = work.continued(done, ITERATIONS)
        scene = done.scene if done.interrupted else with_gradients(done.scene, image, config, locked)
        if scene is done.scene:
            break
        done = replace(done, scene=scene)
    return work.continued(done, iterations)


def with_gradients(scene: Scene, image: Tensor, config: FitConfig, locked: Tensor | None = None) -> Scene:
    """Return ``scene`` with linear gradients on the flat paths that gain most, as many as ``config`` asks for.

    Gradients that it has count. Paths that would gain little, or are ``locked`` [N], stay flat.
    """
    device = resolve_device(config.device)
    with on_warps_stream(device), single_torch_thread(), torch.no_grad():
        target, here = Target(image.to(device), config, device), scene.to(device)
        ramps = Ramps(*(each.cpu() for each in best_ramps(here, target)))
        loss = float(target.squared_error(here).sum()) * target.error_scale
    is_flat = torch.ones(len(scene), dtype=torch.bool) if scene.gradients is None else scene.gradients.kind == FLAT
    pays = (ramps.gain > GAIN_MIN * loss) & (2.0 * ramps.change.abs().amax(1) > CHANGE_MIN) & is_flat
    if locked is not None:
        pays &= ~locked.cpu()
    count = min(_wanted(config.gradients or 0.0, len(scene)) - int((~is_flat).sum()), int(pays.sum()))
    if count <= 0:
        return scene
    return with_ramps(scene, ramps.gain.masked_fill(~pays, -1.0).topk(count).indices.sort().values, ramps)


def _wanted(gradients: float | str, path_count: int) -> int:
    """Return how many of the paths may have a gradient; with "auto" all for which it pays."""
    if isinstance(gradients, str):
        return path_count
    return round(gradients * path_count if gradients <= 1.0 else gradients)
