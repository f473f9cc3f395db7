"""Settings are frozen and plain values."""

from __future__ import annotations

import json
from dataclasses import FrozenInstanceError

import numpy as np
import pytest

from warpvec.config.fit_config import FitConfig


def test_numpy_numbers_are_kept_as_plain_ones() -> None:
    config = FitConfig(curves=np.int64(5), threads=np.uint8(2), lr_points=np.float32(0.5), time_budget=np.float64(3.0))
    assert config == FitConfig(curves=5, threads=2, lr_points=0.5, time_budget=3.0)
    kinds = [type(getattr(config, name)) for name in ("curves", "threads", "lr_points", "time_budget")]
    assert kinds == [int, int, float, float]
    assert type(FitConfig(growth=2).growth) is float


def test_settings_are_frozen_plain_and_by_name_only() -> None:
    config = FitConfig()
    with pytest.raises(FrozenInstanceError):
        config.curves = 3  # type: ignore[misc]
    with pytest.raises(TypeError):
        FitConfig(512)  # type: ignore[misc]
    assert json.loads(json.dumps(config.to_dict())) == config.to_dict()
    assert FitConfig(**config.to_dict()) == config
