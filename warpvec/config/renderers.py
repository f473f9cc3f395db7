"""The renderers by name, and the settings that each of them has. What draws is in ``warpvec/rendering``."""

from __future__ import annotations

from typing import Any

from warpvec.checks import check_choice, check_count, check_flag
from warpvec.errors import InputError

RENDERER_SETTINGS: dict[str, tuple[str, ...]] = {
    "exact": (),
    "splat": ("samples", "lines", "interior_gradient", "covariance_gradient"),
}
"""Renderer -> its settings, which are fields of `FitConfig` and keywords of `warpvec.render`."""

RENDERERS = tuple(RENDERER_SETTINGS)

_COUNT_MIN = {"samples": 2, "lines": 1}


def check_renderer_settings(renderer: str, settings: dict[str, Any]) -> dict[str, Any]:
    """Return ``settings`` of ``renderer`` with counts as Python's own.

    Raises:
        InputError: there is no such renderer, it has no such setting, or a value is out of its range.
    """
    check_choice("renderer", renderer, RENDERERS)
    known = RENDERER_SETTINGS[renderer]
    checked = {}
    for name, value in settings.items():
        if name not in known:
            raise InputError(
                f"{name} is not a setting of the renderer {renderer}, which has {', '.join(known) or 'none'}"
            )
        checked[name] = _checked(name, value)
    return checked


def _checked(name: str, value: Any) -> Any:
    if name in _COUNT_MIN:
        return check_count(name, value, _COUNT_MIN[name])
    check_flag(name, value)
    return value
