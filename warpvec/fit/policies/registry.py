"""Find the policy that the settings name, and begin one with given paths."""

from __future__ import annotations

from collections.abc import Callable

from torch import Tensor

from warpvec.config.fit_config import FitConfig
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
"""The name of a policy in the settings -> the policy."""


def make_policy(target: Tensor, config: FitConfig, first_generation: int, canvas: Target) -> Policy:
    """The policy of ``config`` for ``target`` [h, w, 3 or 4], which ``canvas`` compares with."""
    if config.lod:
        return PrefixScaffolding(target, config, first_generation, canvas)
    return POLICIES[config.policy](target, config, first_generation)


def going_on(config: FitConfig, start: Scene, height: int, width: int) -> FitConfig:
    """The settings for a fit of a canvas [height, width] that begins with ``start``.

    Raises:
        InputError: the policy does not go on from given paths, or the paths are not of the model of ``config``.
    """
    if config.policy != "scaffolding":
        raise InputError(f"policy must be scaffolding to go on from a scene, got {config.policy!r}; give scaffolding")
    pieces = config.segments if config.path_model == "segments" else 2
    if (start.degree, start.piece_count) != (config.point_degree, pieces):
        raise InputError(
            f"start must have {pieces} curves of degree {config.point_degree} a path, as the settings say, got"
            f" {start.piece_count} of degree {start.degree}; change path_model, segments or degree"
        )
    return schedule.continued(config, len(start), height, width)
