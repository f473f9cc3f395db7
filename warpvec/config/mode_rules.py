"""Which mode settings ask for, and which settings a mode refuses. The modes of each setting stand in its field."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from warpvec.checks import show
from warpvec.config.modes import MODES, is_outlined
from warpvec.config.setting import PHOTO, Setting
from warpvec.errors import InputError

Table = Mapping[str, Setting]
"""Every setting by its name. It is handed to each rule, because the settings check themselves by these rules."""


def with_mode(settings: dict[str, Any], table: Table) -> dict[str, Any]:
    """Return all ``settings`` of a run with the mode that they ask for: "auto" if the picture decides.

    ``table`` has every setting by its name. Photos without a number of gradients have none.

    Raises:
        InputError: a setting is of another mode.
    """
    mode = _implied(settings, table)
    _refuse([name for name, each in table.items() if _is_refused(each, mode)], settings, mode, table)
    has_none = settings["gradients"] is None and mode == "photo"
    return {**settings, "mode": mode, "gradients": 0.0 if has_none else settings["gradients"]}


def given_mode(usual: Mapping[str, Any], given: Mapping[str, Any], table: Table) -> str:
    """Return the mode that the settings ``given`` in place of the ``usual`` ones ask for.

    Args:
        usual: every setting as it is unless it is given.
        given: settings that replace some of them. One with the usual value counts as not given.
        table: every setting by its name.

    Raises:
        InputError: a setting is given that the mode does not use.
    """
    mode: str = given.get("mode", usual["mode"])
    if mode == "auto":
        return "photo" if _changed_photo_settings(usual, given, table) else mode
    of_photos = _changed_photo_settings(usual, given, table)
    of_drawings = [name for name, each in table.items() if "photo" not in each.modes and not each.is_binding]
    wrong = of_photos if is_outlined(mode) else _changed(of_drawings, usual, given)
    _refuse(wrong, given, mode, table, always=True)
    return mode


def deciding_settings(usual: Mapping[str, object], given: Mapping[str, object], table: Table) -> list[str]:
    """Return the settings among the ``given`` ones that decide the mode; arguments as `given_mode`.

    The name is "preset" if the preset decides it. The list is empty if the mode is given, or if the picture decides it.
    """
    if given.get("mode", "auto") != "auto":
        return []
    if usual["mode"] != "auto":
        return ["preset"]
    of_drawings = [name for name, each in table.items() if len(each.modes) == 1 and each.modes != PHOTO]
    return _changed_photo_settings(usual, given, table) or _changed(
        of_drawings, {name: table[name].default for name in of_drawings}, given
    )


def photo_settings(table: Table) -> list[str]:
    """Return the names of the settings that only the fit of a photo uses."""
    return [name for name, each in table.items() if each.modes == PHOTO]


def _changed_photo_settings(usual: Mapping[str, object], given: Mapping[str, object], table: Table) -> list[str]:
    changed = _changed(photo_settings(table), usual, given)
    return [name for name in changed if name != "gradients" or not _suits_any_mode(given[name])]


def _changed(names: Iterable[str], usual: Mapping[str, object], given: Mapping[str, object]) -> list[str]:
    return [name for name in names if name in given and _differ(given[name], usual[name])]


def _implied(settings: Mapping[str, Any], table: Table) -> str:
    """Return the mode, or the one that a binding setting of a single mode selects."""
    mode: str = settings["mode"]
    if mode != "auto":
        return mode
    for only in MODES:
        binding = [name for name, each in table.items() if each.is_binding and each.modes == (only,)]
        if any(_asks(table[name], settings[name]) for name in binding):
            return only
    return mode


def _is_refused(each: Setting, mode: str) -> bool:
    """Return whether ``mode`` refuses a setting, in whatever way it was given."""
    return each.is_binding and mode not in ("auto", *each.modes, *each.ignored_by)


def _refuse(
    names: Iterable[str], settings: Mapping[str, object], mode: str, table: Table, *, always: bool = False
) -> None:
    for name in names:
        if always or _asks(table[name], settings[name]):
            rule = f"must not be given in the mode {mode}, which does not use it"
            raise InputError(name, rule, show(settings[name]), "leave it out, or give another mode")


def _asks(each: Setting, value: object) -> bool:
    """Return whether ``value`` of a setting asks for something that only its modes do."""
    return not _suits_any_mode(value) if each.name == "gradients" else value != each.default


def _suits_any_mode(gradients: object) -> bool:
    """Return whether every mode can follow this value of gradients: not given, 0 or auto."""
    return gradients is None or not _differ(gradients, "auto") or not _differ(gradients, 0.0)


def _differ(value: object, other: object) -> bool:
    try:
        return bool(value != other)
    except ValueError:  # an array, which the rule of its setting will refuse
        return True
