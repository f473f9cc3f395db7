"""Presets: named sets of settings, each with a sentence for the help. To add a preset, add an entry to `PRESETS`."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from warpvec.checks import check_choice, suggest_name
from warpvec.config.fit_config import OLD_NAMES, SETTINGS, FitConfig
from warpvec.config.mode_rules import deciding_settings, given_mode
from warpvec.config.preset import Preset
from warpvec.config.rooms import rooms
from warpvec.errors import InputError

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
} | {name: preset for room in rooms() for name, preset in room.presets.items()}
"""Preset by name; the help lists them in this order."""


def make_config(preset: str = "default", **settings: Any) -> FitConfig:
    """Return the settings of a preset with some fields replaced.

    ``colors`` without ``opacity`` makes every path opaque, whatever the preset says: translucent paths would mix the N
    colours of the palette into many more.

    Raises:
        InputError: there is no such preset or setting, or a value is out of range.
    """
    check_choice("preset", preset, tuple(PRESETS))
    settings = with_new_names(settings)
    for name in settings:
        if name not in SETTINGS:
            raise InputError(name, "is not a setting", remedy=_remedy(name))
    usual = _usual(preset, settings)
    config = FitConfig(**{**usual, **settings, "mode": given_mode(usual, settings, SETTINGS)})
    if config.colors and "opacity" not in settings:
        config = replace(config, opacity="opaque")
    return config


def with_new_names(settings: dict[str, Any]) -> dict[str, Any]:
    """Return ``settings`` with former names replaced by the present ones.

    Raises:
        InputError: a setting is given by both names.
    """
    for old, name in OLD_NAMES.items():
        if old in settings and name in settings:
            raise InputError(name, f"must not be given with its former name {old}", remedy=f"leave {old} out")
    return {OLD_NAMES.get(name, name): value for name, value in settings.items()}


def settings_of_mode(preset: str, **settings: Any) -> list[str]:
    """Return those of the ``settings`` of `make_config` that decide the mode; see `deciding_settings`."""
    return deciding_settings(_usual(preset, settings), settings, SETTINGS)


def _usual(preset: str, given: dict[str, Any]) -> dict[str, Any]:
    """Return every setting as it is unless it is ``given``."""
    start = replace(FitConfig(), **PRESETS[preset].settings)
    return {**start.to_dict(), **_minified(start, given)}


def _minified(start: FitConfig, given: dict[str, Any]) -> dict[str, Any]:
    """Return those of the settings `MINIFIED` that the preset, ``start``, leaves open; none without ``minify``.

    They are for the exact renderer and paths of cubics.
    """
    asked = {**start.to_dict(), **given}
    if asked["minify"] is not True or (asked["renderer"], asked["path_model"]) != ("exact", "segments"):
        return {}
    return {name: value for name, value in MINIFIED.items() if getattr(start, name) == SETTINGS[name].default}


def _remedy(name: str) -> str:
    """Return what to do about ``name``, which is no setting."""
    if name == "opaque":  # an option of the command line
        return "give opacity='opaque'"
    return suggest_name(name, SETTINGS) or "see warpvec.FitConfig for the names"
