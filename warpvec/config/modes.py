"""The modes of a run, and the settings that only one of them has."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from warpvec.checks import as_float, check_choice, check_count, check_flag, show
from warpvec.errors import InputError

MODES = ("auto", "photo", "flat", "mono")
"""auto: the picture decides. photo: paths are fitted to a photo. flat: the regions of flat art are outlined. mono: one
path for the dark areas of a black and white picture."""

FLAT_MODES = ("flat", "mono")
"""Modes that outline what is there, instead of adding paths until the picture is close."""

SPLAT_SETTINGS = ("renderer", "path_model", "degree", "samples", "lines", "interior_gradient", "covariance_gradient")

PHOTO_SETTINGS = (
    *SPLAT_SETTINGS, "segments", "fixed_segments", "closing_line", "gradients", "lod", "backdrop", "policy", "z_order",
    "initial_curves", "growth",
    "inflation_gap", "shorten_gap", "initial_radius", "radius_decay", "prune_opacity", "compensate", "flat",
    "recycle_gap", "recycle_share", "recycle_until", "replace_gap", "lr_points", "lr_color", "lr_opacity", "lr_scale",
    "lr_decay", "lr_final", "color_parameter", "opacity_weight", "ssim_weight", "xing_weight",
    "bezier_weight",
)  # fmt: skip
"""Settings that only the fit of a photo uses. One of them means the mode photo, unless a mode is given."""

COLOR_SETTINGS = ("colors", "palette")
"""Settings that the mode mono does not use: its one path is black."""

FLAT_SETTINGS = ("detail", "cutout", "threshold")
"""Settings that only the modes flat and mono use. Files of photos do not state them."""

DETAIL_MAX = 10.0
"""Largest tolerance in pixels. With more, nothing is left of a logo of 500 pixels."""

LEVEL_MAX = 255
"""Largest level of a threshold, white."""


def check_mode_settings(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return the settings of the modes in their normal form.

    ``cutout`` in the mode auto means flat, and a threshold means mono. Photos without a number of gradients have none.

    Raises:
        InputError: a value has the wrong type or is out of range, or a setting is of another mode.
    """
    check_choice("mode", settings["mode"], MODES)
    check_flag("cutout", settings["cutout"])
    gradients = settings["gradients"]
    checked = {**settings, "threshold": _threshold(settings["threshold"]), "detail": _detail(settings["detail"])}
    checked["gradients"] = 0.0 if _is_any_mode(gradients) else gradients
    mode = _implied(checked)
    if mode in FLAT_MODES:
        _refuse(checked, ("renderer", "path_model", "policy", "lod", "gradients"), _PLAIN, mode)
    if mode == "photo":
        _refuse(checked, ("cutout", "threshold"), _PLAIN, mode)
    if mode == "flat":
        _refuse(checked, ("threshold",), _PLAIN, mode)
    if mode == "mono":
        _refuse(checked, COLOR_SETTINGS, _PLAIN, mode)
    gradients = 0.0 if gradients is None and mode == "photo" else gradients
    return {name: checked[name] for name in FLAT_SETTINGS} | {"mode": mode, "gradients": gradients}


def given_mode(preset: Mapping[str, Any], given: Mapping[str, Any]) -> str:
    """Return the mode that the settings ``given`` beside those of a ``preset`` ask for.

    Args:
        preset: every setting of the preset.
        given: settings that replace some of them. One with the same value counts as not given.

    Raises:
        InputError: a setting that only the fit of a photo uses is given with another mode, or a detail with photo.
    """
    mode: str = given.get("mode", preset["mode"])
    if mode == "photo":
        _refuse(given, [name for name in ("detail",) if name in given], preset, mode)
        return mode
    changed = _changed_photo_settings(preset, given)
    if mode in FLAT_MODES:
        _refuse(given, changed, preset, mode)
    return "photo" if changed and mode == "auto" else mode


def deciding_settings(preset: Mapping[str, Any], given: Mapping[str, Any]) -> list[str]:
    """Return those of the settings ``given`` that decide the mode because none is asked for; arguments as `given_mode`.

    The name is "preset" if the preset decides it. The list is empty if the mode is given, or if the picture decides it.
    """
    if given.get("mode", "auto") != "auto":
        return []
    if preset["mode"] != "auto":
        return ["preset"]
    of_flat_art = [name for name in ("cutout", "threshold") if name in given and _differ(given[name], _PLAIN[name])]
    return _changed_photo_settings(preset, given) or of_flat_art


def _changed_photo_settings(preset: Mapping[str, Any], given: Mapping[str, Any]) -> list[str]:
    changed = [name for name in PHOTO_SETTINGS if name in given and _differ(given[name], preset[name])]
    if "gradients" in changed and _is_any_mode(given["gradients"]):
        changed.remove("gradients")
    return changed


def _is_any_mode(gradients: Any) -> bool:
    """Return whether every mode can do what is asked of gradients: nothing, none of them, or those that pay."""
    return gradients is None or not _differ(gradients, "auto") or not _differ(gradients, 0.0)


_PLAIN: dict[str, Any] = {
    "renderer": "exact", "path_model": "segments", "policy": "scaffolding", "lod": False, "gradients": 0.0,
    "cutout": False, "threshold": "auto", "colors": 0, "palette": None,
}  # fmt: skip
"""Values with which a setting asks for nothing."""


def _implied(settings: Mapping[str, Any]) -> str:
    mode: str = settings["mode"]
    if mode != "auto":
        return mode
    if any(settings[name] != _PLAIN[name] for name in ("renderer", "path_model", "policy", "lod", "gradients")):
        return "photo"
    if settings["threshold"] != "auto":
        return "mono"
    return "flat" if settings["cutout"] else mode


def _differ(value: Any, other: Any) -> bool:
    try:
        return bool(value != other)
    except ValueError:  # an array, which the rule of its setting will refuse
        return True


def _refuse(settings: Mapping[str, Any], names: Any, plain: Mapping[str, Any], mode: str) -> None:
    for name in names:
        if _differ(settings[name], plain[name]):
            rule = f"must not be given in the mode {mode}, which does not use it"
            raise InputError(name, rule, show(settings[name]), "leave it out, or give another mode")


def _threshold(value: Any) -> str:
    """Return "auto", or the text of a whole level."""
    if value == "auto" and isinstance(value, str):
        return "auto"
    try:
        level = int(value) if isinstance(value, str) else value
    except ValueError:
        rule = f"must be auto or a level from 0 to {LEVEL_MAX}"
        raise InputError("threshold", rule, show(value), "give one of these") from None
    return str(check_count("threshold", level, 0, LEVEL_MAX))


def _detail(value: Any) -> float:
    detail = as_float(value)
    if not 0.0 < detail <= DETAIL_MAX:
        rule = f"must be above 0 and at most {DETAIL_MAX:g} pixels"
        raise InputError("detail", rule, show(value), "give 0.1 to 1")
    return detail
