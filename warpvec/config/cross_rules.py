"""Rules for settings that must go together."""

from __future__ import annotations

from typing import Any

from warpvec.config.limits import GROWTH_MIN, MAX_ALL_SEGMENTS, MAX_RATE
from warpvec.config.mode_rules import Table, with_mode
from warpvec.config.rooms import rooms
from warpvec.errors import InputError


def checked(settings: dict[str, Any], table: Table) -> dict[str, Any]:
    """Return ``settings`` with the mode that they ask for. Each value has been checked alone.

    ``table`` has every setting by its name.

    Raises:
        InputError: two values do not go together.
    """
    _check_growth(settings)
    _check_size(settings)
    _check_rate(settings)
    _check_levels(settings)
    _check_colors(settings)
    _check_gradients(settings)
    _check_closing_line(settings)
    for room in rooms():
        room.check(settings)
    return with_mode(settings, table)


def require_scaffolding(policy: str, purpose: str) -> None:
    """Raise InputError unless fits with ``policy`` can continue from given paths, which ``purpose`` needs."""
    if policy != "scaffolding":
        raise InputError("policy", f"must be scaffolding {purpose}", repr(policy), "give scaffolding")


def _check_growth(settings: dict[str, Any]) -> None:
    growth, first, count = (settings[name] for name in ("growth", "initial_curves", "curves"))
    if 1.0 < growth < GROWTH_MIN:
        rule = f"must be 1 or at least {GROWTH_MIN}"
        raise InputError("growth", rule, str(growth), f"give {GROWTH_MIN} or more")
    starts_full = settings["one_generation"] or settings["policy"] != "scaffolding" or first >= count
    if growth == 1.0 and not starts_full:
        rule = f"must be above 1, because initial_curves {first} is below curves {count}"
        raise InputError("growth", rule, "1.0", "give 2, or one_generation")


def _check_size(settings: dict[str, Any]) -> None:
    """Refuse what would fill the memory of most machines, before anything is allocated."""
    curves, segments = settings["curves"], settings["segments"]
    if settings["path_model"] == "segments" and curves * segments > MAX_ALL_SEGMENTS:
        rule = f"times curves must be at most {MAX_ALL_SEGMENTS}"
        raise InputError("segments", rule, f"{segments} times {curves}", "give fewer of either")


def _check_rate(settings: dict[str, Any]) -> None:
    rate, scale = settings["lr_points"], settings["lr_scale"]
    if rate * scale > MAX_RATE:
        raise InputError("lr_scale", f"times lr_points must be at most {MAX_RATE:g}", f"{scale:g} times {rate:g}")


def _check_levels(settings: dict[str, Any]) -> None:
    if settings["lod"] and (settings["policy"], settings["z_order"]) != ("scaffolding", "creation"):
        raise InputError("lod", "needs policy scaffolding and z_order creation", remedy="set them or leave lod out")


def _check_colors(settings: dict[str, Any]) -> None:
    if settings["palette"] is not None and settings["colors"]:
        raise InputError("colors", "must be 0 with a palette", str(settings["colors"]), "give one of the two")


def _check_gradients(settings: dict[str, Any]) -> None:
    """Raise InputError if gradients are asked for together with a setting that allows flat fills only."""
    gradients, renderer = settings["gradients"], settings["renderer"]
    if not gradients:
        return
    if renderer != "exact":
        raise InputError("gradients", f"must be 0 with the renderer {renderer}", str(gradients), "leave it out")
    if settings["palette"] is not None or settings["colors"]:
        rule = "must be 0 with a palette or a number of colours, whose fills are flat"
        raise InputError("gradients", rule, str(gradients), "give one of the two")


def _check_closing_line(settings: dict[str, Any]) -> None:
    if settings["closing_line"] and settings["renderer"] != "exact":
        rule = f"must be off with the renderer {settings['renderer']}, which draws curves only"
        raise InputError("closing_line", rule, remedy="leave it out, or give the renderer exact")
