"""Make a renderer by its name. Rooms add renderers; see `warpvec.config.rooms`."""

from __future__ import annotations

from typing import Any

from warpvec.config import rooms
from warpvec.config.fit_config import SETTINGS
from warpvec.errors import InputError
from warpvec.rendering.exact import ExactRenderer
from warpvec.rendering.tile_renderer import TileRenderer


def make_renderer(renderer: str, height: int, width: int, **settings: Any) -> TileRenderer:
    """Make ``renderer`` for a canvas of ``height`` x ``width`` pixels.

    ``settings`` are ``device``, ``threads``, ``dtype``, ``degree`` of the curves, and those of the renderer itself.

    Raises:
        InputError: the renderer does not draw curves of this degree.
    """
    made: TileRenderer = renderer_class(renderer)(height, width, **settings)
    return made


def renderer_class(renderer: str) -> type[TileRenderer]:
    """Return the class of a renderer in the settings."""
    found: type[TileRenderer] = ExactRenderer if renderer == "exact" else rooms.load("renderers", renderer)
    return found


def check_renderer_settings(renderer: str, settings: dict[str, Any]) -> dict[str, Any]:
    """Return the ``settings`` of ``renderer`` in their normal form.

    Raises:
        InputError: there is no such renderer, it has no such setting, or a value is out of range.
    """
    SETTINGS["renderer"].kind.check("renderer", renderer)
    known = [name for name, each in SETTINGS.items() if each.renderer == renderer]
    for name in settings:
        if name not in known:
            names = ", ".join(known) or "none"
            raise InputError(name, f"is not a setting of the renderer {renderer}, which has {names}")
    return {name: SETTINGS[name].kind.check(name, value) for name, value in settings.items()}
