"""Steps of a fit that exceed the capacity of a recorded graph are taken again: the fit ends with the same bits.

A fit on a GPU records its steps. Here the CPU records them too, with the kernels of a GPU on one thread.
"""

from __future__ import annotations

import gc
from copy import deepcopy
from dataclasses import fields
from typing import Any
from weakref import ref

import pytest
import torch
from short_fits import small_photo
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.config.presets import make_config
from warpvec.fit import record, target
from warpvec.fit.loop import fit
from warpvec.fit.state import Saving
from warpvec.geometry.scene import Scene
from warpvec.rendering import graph
from warpvec.rendering.capacity import Counts
from warpvec.rendering.tile_renderer import TileRenderer
from warpvec.watch.watch import FitResult

CASES: dict[str, dict[str, Any]] = {
    "default": {},
    "splat": {"renderer": "splat", "samples": 8, "lines": 3},
    "palette": {"colors": 3},
    "levels": {"lod": True},
    "area order": {"z_order": "area"},
    "min area": {"min_area": 20.0},
    "flat": {"flat": True},
}


@pytest.fixture
def renderers(monkeypatch: pytest.MonkeyPatch) -> list[TileRenderer]:
    """Collect the renderers of fits. Their steps can be recorded, but are not unless ``records`` is used."""
    made: list[TileRenderer] = []
    make = target.make_renderer

    def make_scalar(**settings: Any) -> TileRenderer:
        on_cpu = {"threads": 1} if settings["device"] == "cpu" else {}
        made.append(make(**{**settings, "lane_width": 1, **on_cpu}))
        return made[-1]

    monkeypatch.setattr(target, "make_renderer", make_scalar)
    monkeypatch.setattr(graph, "_can_record", lambda device: False)
    for gap in ("_HISTORY_GAP", "_HISTORY_GAP_CUDA"):
        monkeypatch.setattr(record, gap, 20)  # so that many steps pass unseen
    return made


@pytest.fixture
def records(renderers: list[TileRenderer], monkeypatch: pytest.MonkeyPatch) -> None:
    """Record steps, with hardly any room for paths that grow."""
    monkeypatch.setattr(graph, "_can_record", lambda device: True)
    monkeypatch.setattr(Counts, "with_headroom", lambda counts: Counts(*(count + 2 for count in counts)))
    monkeypatch.setattr(target, "least_counts", lambda *sizes: Counts(0, 0, 0, 0))


def settings_of(case: str, device: str) -> FitConfig:
    return make_config(curves=24, iterations=60, device=device, **CASES[case])


def values_of(result: FitResult) -> list[Tensor]:
    values = [getattr(result.scene, field.name) for field in fields(Scene)]
    return [value for value in values if isinstance(value, Tensor)]


def plain_history(result: FitResult) -> list[dict[str, float]]:
    return [{name: value for name, value in entry.items() if name != "seconds"} for entry in result.history]


# Transparent images take another way through the renderer, the palette and the levels.
TRANSPARENT = ("default", "splat", "palette", "levels")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "transparent"), [*((case, False) for case in CASES), *((case, True) for case in TRANSPARENT)]
)
def test_a_fit_whose_steps_are_dropped_ends_the_same(
    case: str,
    transparent: bool,
    device: str,
    renderers: list[TileRenderer],
    request: pytest.FixtureRequest,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    image = small_photo(transparent)
    if transparent:  # a step that is not recorded covers the paths once for both mattes, and rounds differently
        monkeypatch.setattr(graph, "_can_record", lambda device: True)
    states: list[list[Any]] = [[], []]
    want = fit(image, settings_of(case, device), saving=Saving(7, lambda state: states[0].append(deepcopy(state))))
    request.getfixturevalue("records")
    got = fit(image, settings_of(case, device), saving=Saving(7, lambda state: states[1].append(deepcopy(state))))
    if case != "levels":  # steps of two pictures are not recorded
        assert renderers[-1].dropped_steps > 0
    assert all(map(torch.equal, values_of(got), values_of(want)))
    assert plain_history(got) == plain_history(want)
    for saved, expected in zip(*states, strict=True):
        assert torch.equal(saved["loss"], expected["loss"])
        assert torch.equal(saved["population"]["age"], expected["population"]["age"])
        assert torch.equal(saved["population"]["segments"], expected["population"]["segments"])


@pytest.mark.slow
def test_the_memory_of_a_fit_is_free_at_once(device: str, renderers: list[TileRenderer]) -> None:
    """The memory of a GPU would last until Python looks for cycles of references."""
    gc.disable()
    try:
        fit(small_photo(), settings_of("default", device))
        alive = ref(renderers.pop())
        assert alive() is None
    finally:
        gc.enable()
