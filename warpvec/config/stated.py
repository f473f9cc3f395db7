"""The settings that a file states."""

from __future__ import annotations

from typing import Any

from warpvec.config.fit_config import SETTINGS, FitConfig
from warpvec.config.modes import is_outlined
from warpvec.config.setting import Setting


def stated_settings(config: FitConfig) -> dict[str, Any]:
    """Return the settings that a file states.

    The file of a photo omits the settings of flat art and unused options. The file of flat art is small, and states
    what differs from the defaults.
    """
    values = {name: value for name, value in config.to_dict().items() if not SETTINGS[name].is_of_machine}
    if is_outlined(config.mode):
        return {name: value for name, value in values.items() if value != SETTINGS[name].default}
    return {name: value for name, value in values.items() if _states(SETTINGS[name], value)}


def _states(setting: Setting, value: object) -> bool:
    """Return whether the file of a photo states ``value`` of ``setting``."""
    return "photo" in setting.modes and (setting.stated == "always" or (setting.stated == "if used" and bool(value)))
