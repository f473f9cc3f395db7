"""Leave out the paths of a drawing that show least, by the exact rise of the error without them."""

from __future__ import annotations

import torch
from torch import Tensor

from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.flat.simplification.critic import Critic
from warpvec.geometry.scene import Scene


def with_fewer_paths(scene: Scene, critic: Critic, count: int) -> Scene:
    """Return the ``count`` paths of ``scene`` that matter most, the removal costs counted again as paths go."""
    while len(scene) > count:
        surplus, worth = len(scene) - count, torch.from_numpy(critic.removal_costs(scene))
        scene = _without(scene, worth, min(surplus, _removed_at_once(surplus)))
    return scene


def _removed_at_once(surplus: int) -> int:
    return max(SIMPLIFICATION.removed_min, round(SIMPLIFICATION.removal_share * surplus))


def _without(scene: Scene, worth: Tensor, count: int) -> Scene:
    """Return ``scene`` without its ``count`` paths of least ``worth`` [N]."""
    return scene.select(worth.topk(len(scene) - count).indices.sort().values)
