"""A steady step allocates no memory."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
import torch
import warp as wp
from oracles import target_image
from scenes import random_scene
from stepping import KINDS, Moving
from torch import Tensor
from torch.utils._python_dispatch import TorchDispatchMode

from warpvec.config.presets import make_config
from warpvec.fit.population import Population
from warpvec.fit.regularization import Regularization
from warpvec.fit.target import Target
from warpvec.geometry.scene import Scene
from warpvec.rendering.graph import RecordedStep
from warpvec.rendering.launch import Buffers


class NewTensors(TorchDispatchMode):
    """Collects the sizes of tensors with new memory."""

    def __init__(self) -> None:
        super().__init__()
        self.sizes: list[tuple[str, int]] = []

    def __torch_dispatch__(self, func: Any, types: Any, args: Any = (), kwargs: Any = None) -> Any:
        result = func(*args, **(kwargs or {}))
        given = (*args, *(kwargs or {}).values())
        known = {value.data_ptr() for value in given if isinstance(value, Tensor)}
        if isinstance(result, Tensor) and result.data_ptr() not in known:
            self.sizes.append((str(func), result.numel()))
        return result


@pytest.mark.parametrize("record", [False, True])
@pytest.mark.parametrize("kind", KINDS)
def test_a_steady_step_allocates_nothing(kind: str, record: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    moving = Moving(kind, random_scene(1, 20, 60, 70))
    moving.recorded = RecordedStep(moving.renderer, record)
    for _ in range(4):
        moving.step()
    growth, made = moving.renderer.growth, count_arrays(monkeypatch)
    with NewTensors() as new:
        for _ in range(5):
            moving.step()
    assert moving.renderer.growth == growth and not made
    assert not new.sizes


def count_arrays(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Collect the Warp arrays that are allocated from now on."""
    made: list[Any] = []
    for name in ("zeros", "empty", "full", "ones"):
        make: Callable[..., Any] = getattr(wp, name)
        monkeypatch.setattr(wp, name, lambda *a, _make=make, **k: made.append(_make(*a, **k)) or made[-1])
    return made


@pytest.mark.parametrize("kind", KINDS)
def test_a_steady_step_of_the_fit_allocates_nothing_large(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Tensors of the size of the image or of all points are allocated once; only a few rows of paths are new."""
    tensors = random_scene(4, 30, 64, 96)
    floats = (value.float() for value in tensors[:4])
    config = make_config(renderer=kind, device="cpu")
    population = Population(Scene.uniform(*floats, generation=torch.zeros(30, dtype=torch.int64)), config, 48.0)
    target = Target(target_image(tensors).float(), config, "cpu")
    regularization = Regularization(64, 96, config, "cpu")

    def take_step() -> None:
        adjoints = target.fit_step(population.live, False)
        regularization.add_adjoint(population.live, adjoints.segments, adjoints.opacity)
        population.step(adjoints.segments, adjoints.color, adjoints.opacity, adjoints.background, 0.0)

    with torch.no_grad():
        for _ in range(3):
            take_step()
        growth, made = target._renderer.growth, count_arrays(monkeypatch)
        with NewTensors() as new:
            for _ in range(3):
                take_step()
    assert target._renderer.growth == growth and not made
    assert max((size for _, size in new.sizes), default=0) <= 4


def test_new_tensors_and_arrays_are_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    value, made = torch.zeros(7), count_arrays(monkeypatch)
    with NewTensors() as new:
        value.reshape(1, 7).add_(1.0)
        value + 1.0
        torch.empty(5)
    assert [size for _, size in new.sizes] == [7, 5]
    buffers = Buffers("cpu")
    buffers.get("a", 3, wp.float32), buffers.get("a", 3, wp.float32)
    assert len(made) == 1
