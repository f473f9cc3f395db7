"""Presets: named sets of settings."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any

from warpvec.checks import check_choice
from warpvec.config.fit_config import FitConfig
from warpvec.errors import InputError

_PAPERS_MODEL: dict[str, Any] = {
    "path_model": "sides",
    "backdrop": "white",
    "renderer": "splat",
    "color_parameter": "logit",
    "bezier_weight": 1.0,
}

PRESETS: dict[str, dict[str, Any]] = {
    "draft": {"iterations": 400, "inflation_gap": 20},
    "default": {},
    "best": {"iterations": 6000},
    "paper": {
        **_PAPERS_MODEL,
        "iterations": 5000,
        "inflation_gap": 100,
        "recycle_gap": 0,
        "lr_points": 0.01,
        "lr_color": 0.5,
        "lr_opacity": 0.5,
        "lr_decay": "constant",
    },
    # The flat baseline as its code has it; there the Xing term is switched off.
    "bezier-splatting": {
        **_PAPERS_MODEL,
        "iterations": 10_000,
        "interior_gradient": False,
        "policy": "replacement",
        "z_order": "area",
        "recycle_gap": 0,
        "lr_points": 2e-4,
        "lr_color": 0.01,
        "lr_opacity": 0.01,
        "lr_decay": "steps",
        "xing_weight": 0.0,
    },
}
"""Preset name -> the fields in which it differs from FitConfig's defaults."""


def make_config(preset: str = "default", **settings: Any) -> FitConfig:
    """A preset with some fields replaced.

    Raises:
        InputError: no such preset or setting, or a value outside its range.
    """
    check_choice("preset", preset, tuple(PRESETS))
    known = {field.name for field in fields(FitConfig)}
    for name in settings:
        if name not in known:
            raise InputError(f"{name} is not a setting; see warpvec.FitConfig for the names")
    return replace(FitConfig(), **{**PRESETS[preset], **settings})


PRESET_SENTENCES = {
    "draft": "A first look, in a third of the time.",
    "default": "Good quality in seconds.",
    "best": "A quarter of a decibel more for three times the time.",
    "paper": "Vector Scaffolding as published: its splat renderer and schedule; slow on a CPU.",
    "bezier-splatting": "The flat baseline of the paper: all paths at once, long and slow.",
}
"""Preset -> what it is for."""
