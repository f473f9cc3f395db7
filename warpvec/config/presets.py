"""Presets: named sets of settings, each with a sentence for the help.

To add a preset, add an entry to `PRESETS`, and a row to the table in the checkout's README.md.
"""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any, NamedTuple

from warpvec.checks import check_choice, suggest_name
from warpvec.config.fit_config import FitConfig
from warpvec.config.modes import deciding_settings, given_mode
from warpvec.errors import InputError


class Preset(NamedTuple):
    """A set of settings with a purpose."""

    sentence: str
    """What the preset is for, as the help says it."""
    settings: dict[str, Any]
    """The fields that differ from the defaults of FitConfig."""


_PAPER_MODEL: dict[str, Any] = {
    "mode": "photo",
    "path_model": "sides",
    "backdrop": "white",
    "renderer": "splat",
    "color_parameter": "logit",
    "opacity_weight": 0.01,
    "ssim_weight": 0.0,
    "bezier_weight": 1.0,
}

MINIFIED: dict[str, Any] = {
    "segments": 3,
    "closing_line": True,
    "opacity": "common",
    "bezier_weight": 0.02,
    "lr_points": 0.016,
    "lr_color": 0.02,
    "recycle_share": 0.09,
}
"""Settings of fits with `minify`, unless they are given or the preset has others. At equal bytes, each gains: a common
opacity 0.6 dB, the closing line 0.4, the weaker regularizer 0.1, the learning rates 0.15, and recycling more paths at a
time 0.05 (kodim07 and kodim23 at 384 x 256, 25 KB)."""

PRESETS = {
    "draft": Preset(
        "A first look, in a third of the time.",
        {"iterations": 400, "inflation_gap": 20},
    ),
    "default": Preset("Good quality in seconds.", {}),
    "best": Preset(
        "A quarter of a decibel more, for three times the time.",
        {"iterations": 6000},
    ),
    "paper": Preset(
        "Vector Scaffolding as published (splat renderer); slow.",
        {
            **_PAPER_MODEL,
            "iterations": 5000,
            "inflation_gap": 100,
            "recycle_gap": 0,
            "lr_points": 0.01,
            "lr_color": 0.5,
            "lr_opacity": 0.5,
            "lr_decay": "constant",
        },
    ),
    "bezier-splatting": Preset(
        "The paper's flat baseline: all paths at once; very slow.",
        {
            **_PAPER_MODEL,
            "iterations": 10_000,
            "interior_gradient": False,
            "policy": "replacement",
            "z_order": "area",
            "recycle_gap": 0,
            "lr_points": 2e-4,
            "lr_color": 0.01,
            "lr_opacity": 0.01,
            "lr_decay": "steps",
            "xing_weight": 0.0,  # the published code of the baseline switches this term off
        },
    ),
}
"""Preset by name; the help lists them in this order."""


def make_config(preset: str = "default", **settings: Any) -> FitConfig:
    """Return the settings of a preset with some fields replaced.

    ``colors`` without ``opacity`` makes every path opaque, whatever the preset says: translucent paths would mix the N
    colours of the palette into many more.

    Raises:
        InputError: there is no such preset or setting, or a value is out of range.
    """
    check_choice("preset", preset, tuple(PRESETS))
    known = [field.name for field in fields(FitConfig)]
    for name in settings:
        if name not in known:
            raise InputError(name, "is not a setting", remedy=_remedy(name, known))
    usual = _usual(preset, settings)
    config = FitConfig(**{**usual, **settings, "mode": given_mode(usual, settings)})
    if config.colors and "opacity" not in settings:
        config = replace(config, opacity="opaque")
    return config


def settings_of_mode(preset: str, **settings: Any) -> list[str]:
    """Return those of the ``settings`` of `make_config` that decide the mode; see `deciding_settings`."""
    return deciding_settings(_usual(preset, settings), settings)


def _usual(preset: str, given: dict[str, Any]) -> dict[str, Any]:
    """Return every setting as it is unless it is ``given``."""
    start = replace(FitConfig(), **PRESETS[preset].settings)
    return {**start.to_dict(), **_minified(start, given)}


def _minified(start: FitConfig, given: dict[str, Any]) -> dict[str, Any]:
    """Return those of the settings `MINIFIED` that the preset, ``start``, leaves open; none without ``minify``.

    They are for the exact renderer and paths of cubics.
    """
    plain, asked = FitConfig(), {**start.to_dict(), **given}
    if asked["minify"] is not True or (asked["renderer"], asked["path_model"]) != (plain.renderer, plain.path_model):
        return {}
    return {name: value for name, value in MINIFIED.items() if getattr(start, name) == getattr(plain, name)}


def _remedy(name: str, known: list[str]) -> str:
    """Return what to do about ``name``, which is not one of the ``known`` settings."""
    if name == "opaque":  # an option of the command line
        return "give opacity='opaque'"
    return suggest_name(name, known) or "see warpvec.FitConfig for the names"
