"""The options of the commands that fit, from the tables of settings, goals and file options."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from warpvec.config.fit_config import GOAL, RESULT, SETTINGS, FitConfig
from warpvec.config.kinds import Flag
from warpvec.config.presets import settings_of_mode
from warpvec.config.setting import Setting, settings_of
from warpvec.drawing.file_options import FileOptions
from warpvec.goals.goal import Goal, settings_and_goal
from warpvec.goals.registry import QUANTITIES

_FILE_SETTINGS = settings_of(FileOptions)


SIZE_GOAL = next(quantity.name for quantity in QUANTITIES.values() if quantity.is_of_text)
"""The goal of bytes, which --gzip changes."""


def _flag(name: str) -> str:
    return "--" + name.replace("_", "-")


def _table() -> list[Setting]:
    goals = [Setting(each.name, each.kind, None, each.help, GOAL, True, each.metavar) for each in QUANTITIES.values()]
    gzip = Setting("gzip", Flag(), None, f"Count {_flag(SIZE_GOAL)} after gzip (implied by .svgz).", GOAL, True)
    opaque = Setting("opaque", Flag(), None, "Make every path opaque (--opacity opaque).", RESULT, True)
    files = [replace(each, default=None) for each in _FILE_SETTINGS.values()]
    return [*SETTINGS.values(), *goals, gzip, opaque, *files]


OPTIONS: dict[str, Setting] = {option.name: option for option in _table()}
"""Every option by its name in Python. A flag without a default is a switch, which has no opposite."""

SECTIONS: dict[str, list[str]] = {
    section: [name for name, option in OPTIONS.items() if option.section == section]
    for section in dict.fromkeys(option.section for option in OPTIONS.values())
}
"""Section of the help -> its options, in the order of the help."""

OTHER_DEFAULTS = {
    "refine": {
        "curves": "those of the drawing",
        "precision": "that of the drawing",
        "segments": "that of the drawing",
        "iterations": "500",
        "recycle_gap": "0",
        "blur": "0",
    },
}
"""Command -> option -> default in the help, for defaults that the command decides instead of FitConfig."""

REFUSED = {
    "refine": ("mode", "detail", "cutout", "strokes", "threshold", "line_width", "pens", "as_is", "paper", "soft")
}
"""Command -> options that the help of the command leaves out: the command refuses all values but the default."""

RARE = (
    *("why", "save_frames", "every", "checkpoint", "resume", "write_config", "retries", "ray_address", "verbose"),
    *("split", "cut_once", "check_cut", "embroidery_check", "page_number", "from_svg"),
    *("bleed", "kerf", "min_width", "mirror", "marks", "weeding", "size_check"),
)
"""Options of single commands that only --help-all shows."""

_OTHER_OPTIONS = ("preset", "background", "levels", "history", "video", "config", "write_config", "engine")

OPTION_NAMES = {name: _flag(name) for name in (*_OTHER_OPTIONS, *OPTIONS)} | {
    "address": "--ray-address",
    "checkpoint": "--resume",
    "image": "IN",
    "name": "NAME",
    "page": "--page",
    "photo": "--image",
    **{option.name: _flag(option.flag) for option in OPTIONS.values() if option.flag is not None},
}
"""Name of an argument in Python -> the option of the command line."""


def given_options(options: Mapping[str, object]) -> dict[str, Any]:
    """Return the settings and goals that are given among the ``options`` of a command."""
    known = (*SETTINGS, *QUANTITIES, "gzip")
    return {name: value for name, value in options.items() if name in known and value is not None}


def requested(options: Mapping[str, Any]) -> tuple[FitConfig, Goal]:
    """Return the settings and the goal that the ``options`` of a command ask for; None means not given.

    Raises:
        InputError: a value is out of range, or two values do not go together.
    """
    from warpvec.config.cross_rules import require_scaffolding

    config, goal = settings_and_goal(options["preset"], given_options(options))
    if goal:
        require_scaffolding(config.policy, "to meet a goal")
    return config, goal


def options_of_mode(options: Mapping[str, Any]) -> list[str]:
    """Return the options that decide the mode without --mode; none if the picture decides it."""
    given = {name: value for name, value in options.items() if name in SETTINGS and value is not None}
    names = settings_of_mode(options["preset"], **given)
    if not names and given.get("mode", "auto") == "auto":  # only the fit of a photo has a state
        names = [name for name in ("resume", "checkpoint") if options[name] is not None][:1]
    return list(map(_flag, names))


def file_options(options: Mapping[str, Any]) -> FileOptions:
    """Return how the ``options`` of a command want the file to be written."""
    given = {name: options[name] for name in _FILE_SETTINGS if options[name] is not None}
    return FileOptions(**given)


def stated(options: Mapping[str, Any], config: FitConfig) -> dict[str, Any]:
    """Return every setting, goal and input of a command by its name in a TOML file; what is not set is left out.

    Args:
        options: what was given.
        config: the settings that this led to.
    """
    goals = (*QUANTITIES, "gzip")
    found = {"preset": options["preset"], "background": options["background"], **config.to_dict()}
    found |= {name: options[name] for name in goals} | {"curves": options["curves"] or config.curves}
    found |= {name: options[name] for name in _FILE_SETTINGS if options[name]}
    if options["curves"] is None and any(options[name] for name in goals):
        del found["curves"]
    if options[SIZE_GOAL] is not None and config.minify and options["segments"] is None:
        del found["segments"]  # they follow from the bytes
    return {name: value for name, value in found.items() if value is not None}
