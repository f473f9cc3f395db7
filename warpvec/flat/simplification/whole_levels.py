"""Give the stops of gradients the whole levels that a file states, and let their places make up for it.

Rounding the colours of a fitted gradient shows as half a level over its whole area. A designer's stops have whole
levels, so with the right ones the places fit as well as before.
"""

from __future__ import annotations

from dataclasses import replace

import torch

from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.flat.simplification.critic import Critic
from warpvec.geometry.paints.registry import FLAT
from warpvec.geometry.scene import Scene
from warpvec.polish.polish import polish
from warpvec.svg.quantize import COLOR_LEVELS, rounded
from warpvec.watch.watch import Watch


def with_whole_levels(scene: Scene, critic: Critic, watch: Watch) -> Scene:
    """Return ``scene`` with gradients whose stops have whole levels, with their places and outlines fitted to these.

    Args:
        scene: a scene fitted to the picture of ``critic``.
        critic: judges the changes.
        watch: the watch over the run. When it is over, the scene stays as it is.
    """
    gradients = scene.gradients
    if gradients is None or watch.is_over() or not bool((gradients.kind != FLAT).any()):
        return scene
    is_flat = gradients.kind == FLAT
    stops = gradients.stops
    if stops is not None:
        stops = replace(stops, inner_color=_levels(stops.inner_color))
    color = torch.where(is_flat[:, None], scene.color, _levels(scene.color))
    paints = replace(gradients, end_color=_levels(gradients.end_color), stops=stops)
    return polish(
        critic.target, replace(scene, color=color, gradients=paints), critic.config, watch.side_part(),
        iterations=SIMPLIFICATION.level_iterations, locked=is_flat, keeps_stops=True,
        values_exact_max=SIMPLIFICATION.values_exact_max, unseen=SIMPLIFICATION.unseen,
    ).scene  # fmt: skip


def _levels(color: torch.Tensor) -> torch.Tensor:
    return rounded(color.clamp(0.0, 1.0), COLOR_LEVELS)
