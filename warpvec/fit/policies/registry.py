"""Find the policy that the settings name, and prepare the settings of a fit that begins with given paths."""

from __future__ import annotations

from collections.abc import Callable

from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.config.rules import require_scaffolding
from warpvec.errors import InputError
from warpvec.fit import schedule
from warpvec.fit.policies.base import Policy
from warpvec.fit.policies.prefixes import PrefixScaffolding
from warpvec.fit.policies.replacement import Replacement
from warpvec.fit.policies.scaffolding import Scaffolding
from warpvec.fit.target import Target
from warpvec.geometry.scene import Scene

POLICIES: dict[str, Callable[[Tensor, FitConfig, int], Policy]] = {
    "scaffolding": Scaffolding,
    "replacement": Replacement,
}
"""Policies by their names in the settings."""


def make_policy(image: Tensor, config: FitConfig, first_generation: int, target: Target) -> Policy:
    """Make the policy of ``config`` for ``image`` [h, w, 3 or 4], which ``target`` compares scenes with."""
    if config.lod:
        return PrefixScaffolding(image, config, first_generation, target)
    return POLICIES[config.policy](image, config, first_generation)


def config_from_start(config: FitConfig, start: Scene, height: int, width: int) -> FitConfig:
    """Return the settings for a fit of a canvas [height, width] that begins with ``start``.

    Raises:
        InputError: the policy cannot begin with given paths, or the paths do not have the path model of ``config``.
    """
    require_scaffolding(config.policy, "to start from a scene")
    pieces = config.segments if config.path_model == "segments" else 2
    if start.degree != config.point_degree:
        rule = f"must have curves of degree {config.point_degree}, as the settings say"
        raise InputError("start", rule, f"degree {start.degree}", "change path_model or degree")
    if config.renderer != "exact" and not (start.is_uniform and start.piece_count == pieces):
        rule = f"must have {pieces} curves a path in one loop, as the settings say, for the renderer {config.renderer}"
        raise InputError("start", rule, "other paths", "change path_model or segments, or give the renderer exact")
    return schedule.grow_from(config, len(start), height, width)
