"""Fits whose last iterations draw rounded paths."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import replace
from typing import Any

import pytest
import torch

from warpvec.config.presets import make_config
from warpvec.fit.budget import Written
from warpvec.fit.loop import fit
from warpvec.fit.state import Saving, State
from warpvec.geometry.paints.registry import FLAT

WRITTEN = Written(step=(0.5, 0.25))


def photo(channels: int = 3) -> torch.Tensor:
    y, x = torch.meshgrid(torch.linspace(0, 1, 32), torch.linspace(0, 1, 48), indexing="ij")
    waves = [torch.sin(9 * x + 5 * y), torch.cos(13 * x * y + 2), torch.sin(8 * y), torch.sin(6 * x)]
    return 0.5 + 0.4 * torch.stack(waves[:channels], 2)


@pytest.mark.parametrize(("settings", "channels"), [({}, 4), ({"colors": 4}, 3), ({"gradients": 0.5}, 3)], ids=str)
def test_a_fit_resumed_among_rounded_paths_equals_the_whole_one(settings: dict[str, Any], channels: int) -> None:
    kept: list[State] = []
    config = make_config(minify=True, curves=8, iterations=60, threads=1, device="cpu", mode="photo", **settings)
    saving = Saving(57, lambda state: kept.append(deepcopy(state)))
    whole = fit(photo(channels), config, saving=saving, written=WRITTEN).scene
    resumed = fit(photo(channels), replace(config, threads=2), resume=kept[0], written=WRITTEN).scene
    torch.testing.assert_close(resumed.to_dict(), whole.to_dict(), rtol=0.0, atol=0.0)


def test_colours_of_gradients_are_rounded_too() -> None:
    config = make_config(minify=True, gradients=1.0, curves=8, iterations=60, threads=1, device="cpu", mode="photo")
    paints = fit(photo(), config, written=WRITTEN).scene.gradients
    assert paints is not None
    levels = 255 * paints.end_color[paints.kind != FLAT]
    assert len(levels) > 3
    torch.testing.assert_close(levels, levels.round(), rtol=0.0, atol=1e-3)
