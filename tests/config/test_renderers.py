"""Settings of the renderers."""

from __future__ import annotations

import inspect

from warpvec.config.fit_config import SETTINGS
from warpvec.config.kinds import Choice
from warpvec.rendering.registry import renderer_class


def test_each_renderer_accepts_its_settings() -> None:
    renderers = SETTINGS["renderer"].kind
    assert isinstance(renderers, Choice)
    for name in renderers.names:
        own = {each.name for each in SETTINGS.values() if each.renderer == name}
        assert own <= set(inspect.signature(renderer_class(name)).parameters)
