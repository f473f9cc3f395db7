"""The paths with which a fit starts."""

from __future__ import annotations

from dataclasses import replace

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.policies.base import Policy
from warpvec.fit.target import Target
from warpvec.geometry.scene import Scene
from warpvec.image.alpha import is_transparent


def first_paths(image: Tensor, config: FitConfig, policy: Policy) -> Scene:
    """Return the paths that ``policy`` starts with on ``image`` [h, w, 3 or 4]."""
    learned = config.backdrop == "learned"
    background = image[..., :3].mean((0, 1)) if learned else image.new_ones(3)
    return as_transparent_as(image, policy.first_paths(background))


def given_paths(image: Tensor, config: FitConfig, target: Target, start: Scene) -> Scene:
    """Return the paths of ``start`` with the highest removal cost, or all if there are no more than N."""
    scene = start.to(image.device)
    if len(scene) > config.curves:
        removal_cost = target.removal_costs(scene)
        scene = scene.select(removal_cost.topk(config.curves).indices.sort().values)
    return as_transparent_as(image, scene)


def as_transparent_as(image: Tensor, scene: Scene) -> Scene:
    """Return ``scene`` without a visible canvas if ``image`` has alpha, else with one."""
    if is_transparent(image):
        return replace(scene, background=torch.zeros_like(scene.background), transparent=True)
    return replace(scene, transparent=False)
