"""Leave out the paths of a drawing that show least, by the exact rise of the error without them."""

from __future__ import annotations

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.target import Target
from warpvec.geometry.scene import Scene

REMOVAL_SHARE = 0.25
"""Largest share of the surplus paths that one round removes. The rest are valued again without them."""

REMOVED_MIN = 4
"""Fewest paths that one round removes, if so many are to go."""


def with_fewer_paths(scene: Scene, image: Tensor, config: FitConfig, count: int) -> Scene:
    """Return the ``count`` paths of ``scene`` that matter most, the removal costs counted again as paths go."""
    target = Target(image, config, "cpu") if len(scene) > count else None
    while target is not None and len(scene) > count:
        surplus = len(scene) - count
        scene = _without(scene, removal_costs(scene, target), min(surplus, _removed_at_once(surplus)))
    return scene


def removal_costs(scene: Scene, target: Target) -> Tensor:
    """Return the rise of the squared error, summed over pixels and channels, without each path [N]."""
    with torch.no_grad():
        cost: Tensor = target.fit_step(scene, True).removal_cost
    return cost / target.error_scale


def _removed_at_once(surplus: int) -> int:
    return max(REMOVED_MIN, round(REMOVAL_SHARE * surplus))


def _without(scene: Scene, worth: Tensor, count: int) -> Scene:
    """Return ``scene`` without its ``count`` paths of least ``worth`` [N]."""
    return scene.select(worth.topk(len(scene) - count).indices.sort().values)
