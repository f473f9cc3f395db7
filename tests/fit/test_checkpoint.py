"""A resumed fit equals the uninterrupted one to the last bit."""

from __future__ import annotations

import random
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from logo import logo
from numpy.typing import NDArray
from runs import drawn
from stubs import circles

from warpvec.config.fit_config import FitConfig
from warpvec.config.presets import make_config
from warpvec.errors import InputError
from warpvec.fit.checkpoint import Checkpoint, read_checkpoint, write_checkpoint
from warpvec.fit.population import Population
from warpvec.geometry.scene import Scene
from warpvec.result import Result

Pixels = NDArray[np.float32]

QUICK: dict[str, Any] = {"curves": 24, "initial_curves": 6, "inflation_gap": 3, "iterations": 40, "device": "cpu"}
SPLAT: dict[str, Any] = {"samples": 8, "lines": 4}


def _photo() -> Pixels:
    noise = np.random.default_rng(3).random((6, 8, 3), np.float32)
    return np.kron(noise, np.ones((6, 6, 1), np.float32))


class Stop(Exception):
    """Ends a fit in the middle, as a crash does."""


def _crashed(photo: Pixels, config: FitConfig, path: Path, iteration: int, every: int) -> Checkpoint:
    """Return the checkpoint that a fit leaves if it crashes after ``iteration``."""

    def crash(progress: Any) -> None:
        if progress.iteration == iteration:
            raise Stop

    with pytest.raises(Stop):
        drawn(photo, config, on_progress=crash, checkpoint=path, every=every)
    return read_checkpoint(path)


def _assert_same(resumed: Result, whole: Result) -> None:
    assert resumed.svg() == whole.svg()
    torch.testing.assert_close(resumed.drawing.fitted.to_dict(), whole.drawing.fitted.to_dict(), rtol=0, atol=0)
    assert resumed.run.iterations == whole.run.iterations
    for entry, other in zip(whole.history, resumed.history, strict=True):
        assert entry | {"seconds": 0} == other | {"seconds": 0}


FITS: dict[str, dict[str, Any]] = {
    "default": {},
    "recycling": {"recycle_gap": 2},
    "area": {"z_order": "area"},
    "logit": {"color_parameter": "logit", "backdrop": "white"},
    "opaque": {"opacity": "opaque"},
    "palette": {"colors": 4},
    "given palette": {"palette": "#123,#89a,#fff"},
    "palette of few": {"colors": 3, "recycle_gap": 2},
    "min area": {"min_area": 3.0},
    "splat": {"renderer": "splat", **SPLAT},
    "paper": {"preset": "paper", **SPLAT},
    "released": {"preset": "paper-released", **SPLAT},
    "replacement": {"preset": "bezier-splatting", "replace_gap": 4, **SPLAT},
    "replacement of areas": {"policy": "replacement", "replace_gap": 3, "z_order": "area"},
    "one generation": {"one_generation": True},
    "reduced": {"fit_size": 30},
    "levels": {"lod": True},
    "gradients": {"gradients": 0.3, "recycle_gap": 2},
    "opaque gradients": {"gradients": 9, "opacity": "opaque", "z_order": "area"},
    "levels of gradients": {"gradients": 0.6, "lod": True},
}


# Transparent images take another way through the renderer, the palette and the levels.
TRANSPARENT = ("default", "palette", "levels", "splat", "replacement", "gradients")


@pytest.mark.parametrize(
    ("name", "transparent"), [*((name, False) for name in FITS), *((name, True) for name in TRANSPARENT)]
)
def test_a_resumed_fit_is_the_uninterrupted_one(name: str, transparent: bool, tmp_path: Path) -> None:
    photo = logo().astype(np.float32)[::2, ::2] / 255.0 if transparent else _photo()
    config = make_config(**{**QUICK, **FITS[name]})
    whole = drawn(photo, config)
    path = tmp_path / "fit.checkpoint"
    # In every part of the run: before the palette, between inflations, near the end.
    iteration = random.Random(name).randint(5, 39) if not transparent else 17
    state = _crashed(photo, config, path, iteration, 4)
    assert state.config == config
    assert state.state["iteration"] == (iteration - 1) // 4 * 4
    _assert_same(drawn(photo, state.config, resume=state), whole)


@pytest.mark.slow
def test_a_fit_resumes_from_any_iteration(tmp_path: Path) -> None:
    config = make_config(**QUICK, colors=4, recycle_gap=3)
    whole = drawn(_photo(), config)
    for iteration in range(2, 40, 7):
        state = _crashed(_photo(), config, tmp_path / "fit", iteration, 1)
        assert state.state["iteration"] == iteration - 1
        _assert_same(drawn(_photo(), config, resume=state), whole)


@pytest.mark.parametrize("iteration", [8, 9, 20, 32, 33])
def test_a_fit_resumes_before_and_after_a_choice_of_gradients(iteration: int, tmp_path: Path) -> None:
    """Gradients are chosen after iterations 8 and 32; the checkpoint of an iteration holds the choice after it."""
    config = make_config(**QUICK, gradients=0.3, recycle_gap=3)
    whole = drawn(_photo(), config)
    assert len(set(re.findall(r"url\(#(\w+)\)", whole.svg()))) == 7
    state = _crashed(_photo(), config, tmp_path / "fit", iteration, 1)
    assert (state.state["population"]["gradients"] is None) == (iteration == 8)
    _assert_same(drawn(_photo(), config, resume=state), whole)


def test_a_fit_may_crash_twice_and_resume_on_other_threads(tmp_path: Path) -> None:
    config = make_config(**QUICK, threads=2)
    whole = drawn(_photo(), config)
    state = _crashed(_photo(), config, tmp_path / "fit", 14, 5)
    fewer = replace(config, threads=1)
    count = iter(range(100))

    def crash(progress: Any) -> None:
        if next(count) == 15:
            raise Stop

    with pytest.raises(Stop):
        drawn(_photo(), fewer, on_progress=crash, resume=state, checkpoint=tmp_path / "fit", every=5)
    again = read_checkpoint(tmp_path / "fit")
    assert again.state["iteration"] == 25
    assert again.state["config"]["threads"] == 1
    _assert_same(drawn(_photo(), fewer, resume=again), whole)


def test_a_fit_that_began_with_given_paths_resumes(tmp_path: Path) -> None:
    start = drawn(_photo(), make_config(**QUICK)).drawing.fitted
    config = make_config(**{**QUICK, "curves": 40})
    whole = drawn(_photo(), config, start=start)

    def crash(progress: Any) -> None:
        if progress.iteration == 23:
            raise Stop

    with pytest.raises(Stop):
        drawn(_photo(), config, start=start, on_progress=crash, checkpoint=tmp_path / "fit", every=10)
    state = read_checkpoint(tmp_path / "fit")
    _assert_same(drawn(_photo(), state.config, resume=state), whole)


@pytest.mark.slow
def test_the_best_scene_so_far_is_saved_too(tmp_path: Path) -> None:
    """Recycling half of the paths makes the picture worse at first; an interrupt then returns the scene before it."""
    config = make_config(**QUICK, recycle_gap=2, recycle_share=0.5)

    def interrupted(iteration: int, resume: Checkpoint | None) -> torch.Tensor:
        def stop(progress: Any) -> None:
            if progress.iteration == iteration:
                raise KeyboardInterrupt

        result = drawn(_photo(), config, on_progress=stop, resume=resume)
        assert result.interrupted
        return result.drawing.fitted.points

    from_before = 0
    for iteration in range(19, 26, 2):
        points = interrupted(iteration, None)
        state = _crashed(_photo(), config, tmp_path / "fit", iteration, 1)
        assert torch.equal(interrupted(iteration, state), points)
        from_before += torch.equal(points, Scene.from_dict(state.state["best"]["scene"]).points)
    assert from_before > 1


def _population(count: int, seed: int) -> Population:
    torch.manual_seed(seed)
    return Population(circles(36, 48, count), FitConfig(), 24.0)


def test_the_state_of_a_population_is_all_of_it(tmp_path: Path) -> None:
    population = _population(9, 0)
    population.append(circles(36, 48, 3))
    population.keep(torch.tensor([11, 0, 3, 7, 2]))
    for _ in range(3):
        population.step(torch.rand(20, 3, 2), torch.rand(5, 3), torch.rand(5), torch.rand(3), 1.0)
    population.append(circles(36, 48, 2))
    write_checkpoint(tmp_path / "a", Checkpoint(FitConfig(), "", population.state()))
    other = _population(4, 1)
    other.restore(read_checkpoint(tmp_path / "a").state, None)
    assert other.serial.tolist() == population.serial.tolist() == [11, 0, 3, 7, 2, 12, 13]
    for each in (population, other):
        torch.manual_seed(2)
        each.step(torch.rand(28, 3, 2), torch.rand(7, 3), torch.rand(7), torch.rand(3), 1.0)
        each.append(circles(36, 48, 1))
    first, second = population.state(), other.state()
    for name, value in first.pop("live").items():
        found = second["live"][name]
        assert torch.equal(found, value) if isinstance(value, torch.Tensor) else found == value, name
    for name, value in first.items():
        assert torch.equal(second[name], value) if isinstance(value, torch.Tensor) else second[name] == value, name


def test_another_photo_is_refused(tmp_path: Path) -> None:
    config = make_config(**QUICK)
    state = _crashed(_photo(), config, tmp_path / "fit", 9, 4)
    for photo in (_photo() * 0.999, _photo()[:-1], np.dstack([_photo(), np.ones((36, 48), np.float32)])):
        with pytest.raises(InputError, match="^image must be the photo of the checkpoint"):
            drawn(photo.astype(np.float32), config, resume=state)
