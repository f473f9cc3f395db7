"""Which values the settings of a fit may have."""

from __future__ import annotations

import math
import re
from typing import Any

from warpvec.checks import as_float, check_choice, check_count, check_flag, check_number, show
from warpvec.config.renderers import RENDERER_SETTINGS, RENDERERS, check_renderer_settings
from warpvec.errors import InputError

PATH_MODELS = ("segments", "sides")
Z_ORDERS = ("creation", "area")
COLOR_PARAMETERS = ("direct", "logit")
LR_DECAYS = ("cosine", "constant", "steps")
BACKDROPS = ("learned", "white")
POLICIES = ("scaffolding", "replacement")
OPACITIES = ("free", "opaque")

_COLOR = re.compile("#(?:[0-9a-f]{3}|[0-9a-f]{6})")

GROWTH_MIN = 1.01
"""Least growth other than 1: an inflation that adds no path to the first hundred is a mistake, not a schedule."""


def checked(settings: dict[str, Any]) -> dict[str, Any]:
    """Numbers and colours among ``settings``, the fields of FitConfig, as Python's own and in one spelling.

    Raises:
        InputError: a value is of the wrong type or outside its range, or two do not go together.
    """
    checked = {**settings, **_counts(settings), **_numbers(settings), "palette": _palette(settings["palette"])}
    for renderer, names in RENDERER_SETTINGS.items():
        checked |= check_renderer_settings(renderer, {name: settings[name] for name in names})
    _check_choices(checked)
    _check_path_model(checked)
    _check_growth(checked)
    if checked["lod"] and (checked["policy"], checked["z_order"]) != ("scaffolding", "creation"):
        raise InputError("lod must be off without policy scaffolding and z_order creation, got True; set these")
    if checked["palette"] is not None and checked["colors"]:
        raise InputError(f"colors must be 0 beside a palette, got {checked['colors']}; give one of the two")
    return checked


def _palette(value: Any) -> str | None:
    """``value`` as "#rrggbb,#rrggbb", each colour once."""
    if value is None:
        return None
    names = [name.strip().lower() for name in value.split(",")] if isinstance(value, str) else []
    if not names or not all(_COLOR.fullmatch(name) for name in names):
        raise InputError(f"palette must be colours such as '#123,#a0b1c2', got {show(value)}; give one or more")
    full = [name if len(name) == 7 else "#" + "".join(2 * digit for digit in name[1:]) for name in names]
    return ",".join(dict.fromkeys(full))


def _counts(settings: dict[str, Any]) -> dict[str, int]:
    ranges: dict[str, tuple[int, int | None]] = {
        "curves": (1, None), "segments": (2, None), "fit_size": (1, None), "iterations": (1, None),
        "initial_curves": (1, None), "inflation_gap": (1, None), "recycle_gap": (0, None),
        "replace_gap": (1, None),
        # float32 has seven digits, and one at least stands before the point.
        "precision": (0, 6), "colors": (0, 256), "degree": (2, 12),
        # The generators take a signed 64-bit seed.
        "seed": (0, 2**63 - 1),
    }  # fmt: skip
    if settings["threads"] is not None:
        ranges["threads"] = (1, None)
    return {name: check_count(name, settings[name], *limits) for name, limits in ranges.items()}


def _numbers(settings: dict[str, Any]) -> dict[str, float]:
    ranges = {
        "growth": (1.0, math.inf), "initial_radius": (0.0, math.inf), "radius_decay": (0.0, 1.0),
        "prune_opacity": (0.0, 1.0), "recycle_share": (0.0, 1.0), "recycle_until": (0.0, 1.0),
        "lr_points": (0.0, math.inf), "lr_color": (0.0, math.inf), "lr_opacity": (0.0, math.inf),
        "lr_scale": (0.0, math.inf), "lr_final": (0.0, 1.0), "opacity_weight": (0.0, math.inf),
        "xing_weight": (0.0, math.inf), "bezier_weight": (0.0, math.inf), "coarse_until": (0.0, 1.0),
        "min_area": (0.0, math.inf),
    }  # fmt: skip
    numbers = {name: check_number(name, settings[name], *limits) for name, limits in ranges.items()}
    if settings["time_budget"] is not None:
        numbers["time_budget"] = _time_budget(settings["time_budget"])
    return numbers


def _time_budget(value: Any) -> float:
    seconds = as_float(value)
    if not seconds > 0:
        raise InputError(
            f"time_budget must be a finite number of seconds above 0, got {show(value)}; leave it out for no limit"
        )
    return seconds


def _check_choices(settings: dict[str, Any]) -> None:
    choices = {
        "renderer": RENDERERS, "path_model": PATH_MODELS, "backdrop": BACKDROPS, "policy": POLICIES,
        "z_order": Z_ORDERS, "color_parameter": COLOR_PARAMETERS, "lr_decay": LR_DECAYS,
        "opacity": OPACITIES,
    }  # fmt: skip
    for name, allowed in choices.items():
        check_choice(name, settings[name], allowed)
    for name in ("shorten_gap", "compensate", "flat", "lod"):
        check_flag(name, settings[name])
    # Which devices there are is asked where the fit starts: to find out takes seconds.
    if not isinstance(settings["device"], str):
        raise InputError(
            f"device must be a name, got {show(settings['device'])}; give 'auto', 'cpu', 'cuda' or 'cuda:K'"
        )


def _check_path_model(settings: dict[str, Any]) -> None:
    if settings["path_model"] == "sides" and settings["renderer"] != "splat":
        raise InputError(
            f"path_model must be segments with the renderer {settings['renderer']}, got 'sides'; give segments, or the"
            " renderer splat"
        )


def _check_growth(settings: dict[str, Any]) -> None:
    growth, first, count = (settings[name] for name in ("growth", "initial_curves", "curves"))
    if 1.0 < growth < GROWTH_MIN:
        raise InputError(f"growth must be 1 or at least {GROWTH_MIN}, got {growth}; give {GROWTH_MIN} or more")
    starts_whole = settings["flat"] or settings["policy"] != "scaffolding" or first >= count
    if growth == 1.0 and not starts_whole:
        raise InputError(
            f"growth must be more than 1 to get from initial_curves {first} to {count} curves, got 1.0; set flat to"
            " start with all of them"
        )
