"""Rules for the values of the settings of a fit."""

from __future__ import annotations

import math
from typing import Any

from warpvec.checks import as_float, check_choice, check_count, check_flag, check_number, show
from warpvec.config.modes import check_mode_settings
from warpvec.config.renderers import RENDERER_SETTINGS, RENDERERS, check_renderer_settings
from warpvec.errors import InputError

PATH_MODELS = ("segments", "sides")
Z_ORDERS = ("creation", "area")
COLOR_PARAMETERS = ("direct", "logit")
LR_DECAYS = ("cosine", "constant", "steps")
BACKDROPS = ("learned", "white")
POLICIES = ("scaffolding", "replacement")
OPACITIES = ("free", "common", "opaque")

MAX_THREADS = 4096
"""Largest number of CPU threads, above the cores of any machine: more must be a mistake. A file of settings or a
checkpoint may come from a larger machine, so fewer are not refused, but `usable_threads` starts only some of them."""

GROWTH_MIN = 1.01
"""Smallest growth other than 1. With less, an inflation of a hundred paths adds none, which must be a mistake."""

MAX_CURVES = 2**15
"""Largest number of paths: twice what a goal may ask for. Twice as many take 2 GB on the smallest picture."""

MAX_SEGMENTS = 256
"""Largest number of cubics of a path; one of so many has more points than any outline needs."""

MAX_ALL_SEGMENTS = 2**22
"""Largest number of cubics of all paths together: they take gigabytes. A goal may have paths of the most segments."""

MAX_GAUSSIANS = 2**26
"""Largest number of Gaussians of all paths, enough for a goal with the default of a path; they take gigabytes."""

MAX_COUNT = 10**9
"""Largest count of what takes no memory. A fit of so many iterations takes weeks, and no image has such a side."""

MAX_GRID = 1000
"""Most units per pixel of a minified file, as fine as three decimals."""

COUNT_RANGES: dict[str, tuple[int, int]] = {
    "curves": (1, MAX_CURVES), "segments": (2, MAX_SEGMENTS), "fit_size": (1, MAX_COUNT), "iterations": (1, MAX_COUNT),
    "initial_curves": (1, MAX_COUNT), "inflation_gap": (1, MAX_COUNT), "recycle_gap": (0, MAX_COUNT),
    "replace_gap": (1, MAX_COUNT), "threads": (1, MAX_THREADS),
    # float32 has seven digits, and at least one of them is before the point.
    "precision": (0, 6), "colors": (0, 256), "degree": (2, 12), "grid": (0, MAX_GRID),
    # The random number generators take a signed 64-bit seed.
    "seed": (0, 2**63 - 1),
}  # fmt: skip
"""Whole-numbered setting -> its smallest and largest value."""

MAX_GROWTH = 1e6
"""Largest growth, with which a single inflation adds all paths there may be."""

MAX_RADIUS = 1000.0
"""Largest initial radius, far beyond an image of radius 1. Coordinates of 1e15 would have no decimals to write."""

MAX_RATE = 10.0
"""Largest learning rate, also of the points after the factor: it moves one by five images in a step. With far more,
values overflow or leave the range of what can be written."""

MAX_SCALE = 1000.0
"""Largest factor of the learning rates, for presets whose rates are small."""

MAX_SECONDS = 1e9
"""Largest time budget: thirty years. The schedule multiplies it, which must not overflow."""

MAX_WEIGHT = 1e6
"""Largest weight of a term of the loss. The optimizer squares the gradients, which must be finite in float32."""

AUTO = "auto"
"""Value of ``gradients`` that leaves their number to the fit."""

NUMBER_RANGES = {
    "growth": (1.0, MAX_GROWTH), "initial_radius": (0.0, MAX_RADIUS), "radius_decay": (0.0, 1.0),
    "prune_opacity": (0.0, 1.0), "recycle_share": (0.0, 1.0), "recycle_until": (0.0, 1.0),
    "lr_points": (0.0, MAX_RATE), "lr_color": (0.0, MAX_RATE), "lr_opacity": (0.0, MAX_RATE),
    "lr_scale": (0.0, MAX_SCALE), "lr_final": (0.0, 1.0), "opacity_weight": (0.0, MAX_WEIGHT),
    "ssim_weight": (0.0, MAX_WEIGHT), "xing_weight": (0.0, MAX_WEIGHT), "bezier_weight": (0.0, MAX_WEIGHT),
    "min_area": (0.0, math.inf),
}  # fmt: skip
"""Setting -> its smallest and largest value."""


def check_settings(settings: dict[str, Any]) -> dict[str, Any]:
    """Return the fields of FitConfig with numbers as Python numbers and the palette in its normal form.

    Raises:
        InputError: a value has the wrong type or is out of range, or two values do not go together.
    """
    checked = {**settings, **_counts(settings), **_numbers(settings), "palette": _palette(settings["palette"])}
    checked["gradients"] = _gradients(settings["gradients"])
    for renderer, names in RENDERER_SETTINGS.items():
        checked |= check_renderer_settings(renderer, {name: settings[name] for name in names})
    _check_choices(checked)
    _check_path_model(checked)
    _check_growth(checked)
    _check_size(checked)
    _check_rate(checked)
    if checked["lod"] and (checked["policy"], checked["z_order"]) != ("scaffolding", "creation"):
        raise InputError("lod", "needs policy scaffolding and z_order creation", remedy="set them or leave lod out")
    if checked["palette"] is not None and checked["colors"]:
        raise InputError("colors", "must be 0 with a palette", str(checked["colors"]), "give one of the two")
    _check_gradients(checked)
    return checked | check_mode_settings(checked)


def parse_palette(text: Any) -> str:
    """Return a list of colours ("red, #123") in its normal form "#ff0000,#112233", each colour once.

    Raises:
        InputError: ``text`` is not a list of CSS names, "#rgb" or "#rrggbb" with commas between them.
    """
    try:
        colors = [_hex_color(name) for name in text.split(",")]
    except (AttributeError, InputError):
        rule = "must be colours such as 'red,#123,#a0b1c2'"
        raise InputError("palette", rule, show(text), "give one or more, with commas between them") from None
    return ",".join(dict.fromkeys(colors))


def require_scaffolding(policy: str, purpose: str) -> None:
    """Raise InputError unless fits with ``policy`` can continue from given paths, which ``purpose`` needs."""
    if policy != "scaffolding":
        raise InputError("policy", f"must be scaffolding {purpose}", repr(policy), "give scaffolding")


def _palette(value: Any) -> str | None:
    return None if value is None else parse_palette(value)


def _hex_color(name: str) -> str:
    from warpvec.image.colors import parse_color  # not above: it loads NumPy and Pillow, which the help does without

    return "#" + "".join(f"{round(255 * float(channel)):02x}" for channel in parse_color(name.strip()))


def _counts(settings: dict[str, Any]) -> dict[str, int]:
    names = [name for name in COUNT_RANGES if name != "threads" or settings[name] is not None]
    return {name: check_count(name, settings[name], *COUNT_RANGES[name]) for name in names}


def _numbers(settings: dict[str, Any]) -> dict[str, float]:
    numbers = {name: check_number(name, settings[name], *limits) for name, limits in NUMBER_RANGES.items()}
    if settings["time_budget"] is not None:
        numbers["time_budget"] = _time_budget(settings["time_budget"])
    return numbers


def _time_budget(value: Any) -> float:
    seconds = as_float(value)
    if not 0 < seconds <= MAX_SECONDS:
        rule = f"must be a finite number of seconds above 0, and at most {MAX_SECONDS:g}"
        raise InputError("time_budget", rule, show(value), "leave it out for no limit")
    return seconds


def _check_choices(settings: dict[str, Any]) -> None:
    choices = {
        "renderer": RENDERERS, "path_model": PATH_MODELS, "backdrop": BACKDROPS, "policy": POLICIES,
        "z_order": Z_ORDERS, "color_parameter": COLOR_PARAMETERS, "lr_decay": LR_DECAYS,
        "opacity": OPACITIES,
    }  # fmt: skip
    for name, allowed in choices.items():
        check_choice(name, settings[name], allowed)
    for name in ("fixed_segments", "shorten_gap", "compensate", "flat", "lod", "minify", "closing_line"):
        check_flag(name, settings[name])
    # The fit checks later that the device exists: finding out takes seconds.
    if not isinstance(settings["device"], str):
        raise InputError("device", "must be a name", show(settings["device"]), "give 'auto', 'cpu', 'cuda' or 'cuda:K'")


def _check_path_model(settings: dict[str, Any]) -> None:
    if settings["path_model"] == "sides" and settings["renderer"] != "splat":
        rule = f"must be segments with the renderer {settings['renderer']}"
        raise InputError("path_model", rule, "'sides'", "give segments, or the renderer splat")
    if settings["closing_line"] and settings["renderer"] != "exact":
        rule = f"must be off with the renderer {settings['renderer']}, which draws curves only"
        raise InputError("closing_line", rule, remedy="leave it out, or give the renderer exact")


def _gradients(value: Any) -> float | str | None:
    if value is None:
        return None
    if isinstance(value, str) and value != AUTO:
        raise InputError("gradients", "must be a number or auto", show(value), "give for example 0.2")
    return AUTO if value == AUTO else check_number("gradients", value, 0.0, MAX_CURVES)


def _check_gradients(settings: dict[str, Any]) -> None:
    """Raise InputError if gradients are asked for together with a setting that allows flat fills only."""
    if not settings["gradients"]:
        return
    if settings["renderer"] != "exact":
        raise InputError("gradients", "must be 0 with the renderer splat", str(settings["gradients"]), "leave it out")
    if settings["palette"] is not None or settings["colors"]:
        rule = "must be 0 with a palette or a number of colours, whose fills are flat"
        raise InputError("gradients", rule, str(settings["gradients"]), "give one of the two")


def _check_size(settings: dict[str, Any]) -> None:
    """Refuse what would fill the memory of most machines, before anything is allocated."""
    curves, segments = settings["curves"], settings["segments"]
    if settings["path_model"] == "segments" and curves * segments > MAX_ALL_SEGMENTS:
        rule = f"times curves must be at most {MAX_ALL_SEGMENTS}"
        raise InputError("segments", rule, f"{segments} times {curves}", "give fewer of either")
    samples, lines = settings["samples"], settings["lines"]
    if settings["renderer"] == "splat" and curves * samples * (lines + 2) > MAX_GAUSSIANS:
        rule = f"times lines and curves must be at most {MAX_GAUSSIANS} Gaussians"
        raise InputError("samples", rule, f"{samples} times {lines + 2} times {curves}", "give fewer of any")


def _check_rate(settings: dict[str, Any]) -> None:
    rate, scale = settings["lr_points"], settings["lr_scale"]
    if rate * scale > MAX_RATE:
        raise InputError("lr_scale", f"times lr_points must be at most {MAX_RATE:g}", f"{scale:g} times {rate:g}")


def _check_growth(settings: dict[str, Any]) -> None:
    growth, first, count = (settings[name] for name in ("growth", "initial_curves", "curves"))
    if 1.0 < growth < GROWTH_MIN:
        rule = f"must be 1 or at least {GROWTH_MIN}"
        raise InputError("growth", rule, str(growth), f"give {GROWTH_MIN} or more")
    starts_full = settings["flat"] or settings["policy"] != "scaffolding" or first >= count
    if growth == 1.0 and not starts_full:
        rule = f"must be above 1, because initial_curves {first} is below curves {count}"
        raise InputError("growth", rule, "1.0", "give 2, or flat")
