"""Names and settings of the renderers."""

from __future__ import annotations

import inspect

from warpvec.config.renderers import RENDERER_SETTINGS, RENDERERS
from warpvec.rendering.registry import RENDERER_CLASSES


def test_each_renderer_accepts_its_settings() -> None:
    for name in RENDERERS:
        signature = inspect.signature(RENDERER_CLASSES[name])
        assert set(RENDERER_SETTINGS[name]) <= set(signature.parameters)
