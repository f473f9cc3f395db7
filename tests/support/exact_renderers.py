"""Exact renderers of one small canvas, as the tests of a property of paths compare them with the reference."""

from __future__ import annotations

from typing import Any

import torch
from backends import VECTOR, Backend

from warpvec.geometry.scene import Scene
from warpvec.rendering.exact import ExactRenderer

HEIGHT, WIDTH = 33, 50
"""Size of the canvas in pixels: neither side is a whole number of tiles."""


def make_renderer(backend: Backend = VECTOR, dtype: torch.dtype = torch.float64, **settings: Any) -> ExactRenderer:
    """Return a renderer that skips no hidden path, unless the ``settings`` say otherwise."""
    settings = {**backend._asdict(), "threads": 2, "dtype": dtype, "transmittance_min": 0.0, **settings}
    return ExactRenderer(HEIGHT, WIDTH, **settings)


def in_float32(scene: Scene) -> Scene:
    """Return ``scene`` with all of its real numbers in float32."""
    return scene._mapped(lambda tensor: tensor.float() if tensor.is_floating_point() else tensor)
