"""Polish a drawing and give a gradient to the flat paths that gain most by it."""

from __future__ import annotations

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.loop import single_torch_thread
from warpvec.fit.ramps import Ramps, best_ramps, flat_paths, wanted_count, with_ramps
from warpvec.fit.target import Target
from warpvec.geometry.scene import Scene
from warpvec.polish.rounds import Rounds
from warpvec.rendering.streams import on_warps_stream

ROUNDS = 2
"""Times that paths are chosen: what a smaller ramp gains shows once the larger ones are in place."""

ITERATIONS = 40
"""Iterations before each choice: what a ramp gains shows once the edges are in place."""

GAIN_MIN = 0.01
"""A path stays flat if a gradient would lower the loss by a smaller share of it."""

CHANGE_MIN = 4.0 / 255
"""A path stays flat if a gradient would change no channel by more."""


def polish_with_gradients(start: Scene, rounds: Rounds) -> Scene:
    """Fit ``start`` as `warpvec.polish.polish.polish` does; in between, flat paths get linear gradients.

    They are as many as the settings of ``rounds`` ask for.
    """
    scene = start
    for _ in range(ROUNDS):
        scene = rounds.polished(scene, ITERATIONS)
        before = scene
        if not rounds.was_interrupted:
            scene = with_gradients(scene, rounds.target, rounds.config, rounds.locked)
        if scene is before:
            break
    return rounds.polished(scene)


def with_gradients(scene: Scene, target: Target, config: FitConfig, locked: Tensor | None = None) -> Scene:
    """Return ``scene`` with linear gradients on the flat paths that gain most, as many as ``config`` asks for.

    Gradients that it has count. Paths that would gain little, or are ``locked`` [N], stay flat.
    """
    device = target.device
    with on_warps_stream(device), single_torch_thread(), torch.no_grad():
        here = scene.to(device)
        ramps = Ramps(*(each.cpu() for each in best_ramps(here, target)))
        loss = float(target.squared_error(here).sum()) * target.error_scale
    is_flat = flat_paths(scene)
    pays = (ramps.gain > GAIN_MIN * loss) & (2.0 * ramps.change.abs().amax(1) > CHANGE_MIN) & is_flat
    if locked is not None:
        pays &= ~locked.cpu()
    count = min(wanted_count(config, len(scene)) - int((~is_flat).sum()), int(pays.sum()))
    if count <= 0:
        return scene
    return with_ramps(scene, ramps.gain.masked_fill(~pays, -1.0).topk(count).indices.sort().values, ramps)
