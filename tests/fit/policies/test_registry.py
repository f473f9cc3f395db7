"""Fits that begin with a drawing: settings that do not go with it are refused by their own names."""

from __future__ import annotations

import pytest
from paints import painted_scene

from warpvec.config.fit_config import FitConfig
from warpvec.errors import InputError
from warpvec.fit.policies.registry import config_from_start


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"colors": 4}, "colors must not be given for a drawing with gradients; leave it out"),
        ({"palette": "#123,#456"}, "palette must not be given for a drawing with gradients; leave it out"),
        ({"renderer": "splat"}, "renderer must be exact for a drawing"),
    ],
)
def test_a_drawing_with_gradients_refuses_settings_by_name(settings: dict[str, object], message: str) -> None:
    start = painted_scene(1, 4, 30, 40)
    assert config_from_start(FitConfig(curves=4), start, 30, 40).curves == 4
    with pytest.raises(InputError, match=message):
        config_from_start(FitConfig(curves=4, **settings), start, 30, 40)  # type: ignore[arg-type]
