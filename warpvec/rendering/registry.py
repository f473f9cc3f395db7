"""Make a renderer by its name. To add a renderer, list its class here and its settings in ``config/renderers.py``."""

from __future__ import annotations

from typing import Any

from warpvec.rendering.exact import ExactRenderer
from warpvec.rendering.splat import SplatRenderer
from warpvec.rendering.tile_renderer import TileRenderer

RENDERER_CLASSES: dict[str, type[TileRenderer]] = {"exact": ExactRenderer, "splat": SplatRenderer}
"""Name of a renderer in the settings -> class."""


def make_renderer(renderer: str, height: int, width: int, **settings: Any) -> TileRenderer:
    """Make ``renderer`` for a canvas of ``height`` x ``width`` pixels.

    ``settings`` are ``device``, ``threads``, ``dtype``, ``degree`` of the curves, and those of the renderer itself.

    Raises:
        InputError: the renderer does not draw curves of this degree.
    """
    return RENDERER_CLASSES[renderer](height, width, **settings)
