"""Leave out the paths of a drawing that show least, by the exact rise of the error without them."""

from __future__ import annotations

import torch

from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.flat.simplification.critic import Critic
from warpvec.geometry.scene import Scene


def with_fewer_paths(scene: Scene, critic: Critic, count: int) -> Scene:
    """Return the ``count`` paths of ``scene`` that matter most, the removal costs counted again as paths go."""
    while (surplus := len(scene) - count) > 0:
        gone = max(SIMPLIFICATION.removed_min, round(SIMPLIFICATION.removal_share * surplus))
        worth = torch.from_numpy(critic.removal_costs(scene))
        scene = scene.select(worth.topk(len(scene) - min(surplus, gone)).indices.sort().values)
    return scene
