"""Find the policy that the settings name, and prepare the settings of a fit that begins with given paths."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from torch import Tensor

from warpvec.config import rooms
from warpvec.config.cross_rules import require_scaffolding
from warpvec.config.fit_config import MACHINE_SETTINGS, FitConfig
from warpvec.config.presets import with_new_names
from warpvec.errors import InputError
from warpvec.fit import schedule
from warpvec.fit.path_models import path_model
from warpvec.fit.policies.base import Policy
from warpvec.fit.policies.prefixes import PrefixScaffolding
from warpvec.fit.policies.scaffolding import Scaffolding
from warpvec.fit.state_form import damaged, field_set, integer, same_settings
from warpvec.fit.target import Target
from warpvec.geometry.scene import Scene

_START_MAX = 2**31
"""More paths than a fit can begin with: their control points would take 200 GB."""


def make_policy(image: Tensor, config: FitConfig, first_generation: int, target: Target) -> Policy:
    """Make the policy of ``config`` for ``image`` [h, w, 3 or 4], which ``target`` compares scenes with."""
    if config.lod:
        return PrefixScaffolding(image, config, first_generation, target)
    policy: Policy = policy_class(config.policy)(image, config, first_generation)
    return policy


def policy_class(policy: str) -> Callable[[Tensor, FitConfig, int], Policy]:
    """Return the class of a policy in the settings. Rooms add policies; see `warpvec.config.rooms`."""
    found: Callable[[Tensor, FitConfig, int], Policy] = (
        Scaffolding if policy == "scaffolding" else rooms.load("policies", policy)
    )
    return found


def config_from_start(config: FitConfig, start: Scene, height: int, width: int) -> FitConfig:
    """Return the settings for a fit of a canvas [height, width] that begins with ``start``.

    Raises:
        InputError: the policy cannot begin with given paths, or the paths do not have the path model of ``config``.
    """
    require_scaffolding(config.policy, "to start from a scene")
    model = path_model(config)
    pieces = model.piece_count
    if start.degree != model.degree:
        rule = f"must have curves of degree {model.degree}, as the settings say"
        raise InputError("start", rule, f"degree {start.degree}", "change path_model or degree")
    if config.renderer != "exact" and not (start.is_uniform and start.piece_count == pieces):
        rule = f"must be exact for a drawing whose paths are not one loop of {pieces} curves each"
        raise InputError("renderer", rule, config.renderer, "give exact, or change path_model or segments")
    if start.gradients is not None:
        _require_free_paints(config)
        if start.gradients.stops is not None:
            remedy = "refine it instead, or give its gradients two opaque stops"
            raise InputError("start", "must have gradients of two opaque stops in a fit", "others", remedy)
    return schedule.grow_from(config, len(start), height, width)


def _require_free_paints(config: FitConfig) -> None:
    """Refuse settings under which no path can have a gradient."""
    if config.renderer != "exact":
        raise InputError("renderer", "must be exact for a drawing with gradients", config.renderer, "give exact")
    for name in ("palette", "colors"):
        if getattr(config, name):
            remedy = "leave it out, or give the drawing flat fills first"
            raise InputError(name, "must not be given for a drawing with gradients", remedy=remedy)


def config_from_state(config: FitConfig, state: Any, height: int, width: int) -> FitConfig:
    """Return the settings to continue with: ``config``, or what `config_from_start` once made of it.

    Args:
        config: the settings of the fit, as its caller gave them. The values of `MACHINE_SETTINGS` may have changed.
        state: the state of a fit of a canvas [height, width], not checked yet. Missing settings have their defaults.

    Raises:
        InputError: ``state`` holds other settings.
    """
    field_set("", state)
    saved = state.get("config")
    field_set("config", saved)
    plain = {**FitConfig().to_dict(), **with_new_names(saved)}
    candidates = [config]
    if config.policy == "scaffolding":
        integer(1, _START_MAX)("config.initial_curves", plain["initial_curves"])
        candidates.append(schedule.grow_from(config, plain["initial_curves"], height, width))
    for candidate in candidates:
        expected = candidate.to_dict()
        for name in MACHINE_SETTINGS:
            expected[name] = plain[name]
        if plain.keys() == expected.keys() and same_settings(plain, expected):
            return candidate
    raise damaged("config", "does not hold the settings of the fit")
