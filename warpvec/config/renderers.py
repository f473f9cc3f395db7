"""Names of the renderers and of their settings. The renderers themselves are in ``warpvec/rendering``."""

from __future__ import annotations

from typing import Any

from warpvec.checks import check_choice, check_count, check_flag
from warpvec.errors import InputError

RENDERER_SETTINGS: dict[str, tuple[str, ...]] = {
    "exact": (),
    "splat": ("samples", "lines", "interior_gradient", "covariance_gradient"),
}
"""Renderer -> its settings, which are fields of `FitConfig` and keyword arguments of `warpvec.render`."""

RENDERERS = tuple(RENDERER_SETTINGS)

COUNT_RANGES = {"samples": (2, 1024), "lines": (1, 1024)}
"""Setting -> its smallest and largest value. A path of a thousand pixels needs no more Gaussians on a line."""


def check_renderer_settings(renderer: str, settings: dict[str, Any]) -> dict[str, Any]:
    """Return ``settings`` of ``renderer``, with counts as Python integers.

    Raises:
        InputError: there is no such renderer, it has no such setting, or a value is out of range.
    """
    check_choice("renderer", renderer, RENDERERS)
    known = RENDERER_SETTINGS[renderer]
    for name in settings:
        if name not in known:
            names = ", ".join(known) or "none"
            raise InputError(name, f"is not a setting of the renderer {renderer}, which has {names}")
    return {name: _checked(name, value) for name, value in settings.items()}


def _checked(name: str, value: Any) -> Any:
    if name in COUNT_RANGES:
        return check_count(name, value, *COUNT_RANGES[name])
    check_flag(name, value)
    return value
