"""The search for a file that meets a goal, with circles in place of fits: the fits it makes, its end, its result."""

from __future__ import annotations

import gzip
import json
import math
import re
import signal
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch
from stubs import circles

from warpvec.config.fit_config import FitConfig
from warpvec.errors import InputError
from warpvec.fit.progress import FitResult
from warpvec.geometry.scene import Scene
from warpvec.vectorization import search
from warpvec.vectorization.goal import CURVES_MAX, Goal, Trial
from warpvec.vectorization.result import Result
from warpvec.vectorization.search import CORRECTIONS_MAX, Search

HEIGHT, WIDTH = 48, 64
PHOTO = np.random.default_rng(0).random((HEIGHT, WIDTH, 3), np.float32)
CONFIG = FitConfig(curves=2000, iterations=40, time_budget=None)


class Fits:
    """Stands in for the fit: returns circles after two seconds an iteration, and lists the settings it was given."""

    def __init__(self, count: Callable[[int], int] = lambda asked: asked, interrupted: int | None = None) -> None:
        self._count, self._interrupted = count, interrupted
        self.asked: list[FitConfig] = []
        self.starts: list[Scene | None] = []

    def __call__(self, config: FitConfig, start: Scene | None) -> Result:
        self.asked.append(config)
        self.starts.append(start)
        torch.manual_seed(len(self.asked))
        scene = circles(HEIGHT, WIDTH, self._count(config.curves))
        history = [{"iteration": k, "curves": len(scene), "psnr": 20.0, "seconds": 2.0 * k} for k in (1, 10)]
        stopped = len(self.asked) - 1 == self._interrupted
        fitted = FitResult(scene, history, config.iterations, 2.0 * config.iterations, stopped, "cpu")
        return Result(PHOTO, (HEIGHT, WIDTH), config, fitted, title="A photo & more")


def _run(fits: Fits, goal: Goal, start: Scene | None = None, **settings: Any) -> Result:
    return Search(goal, replace(CONFIG, **settings), fits, start).run()


def _metadata(svg: str) -> dict[str, Any]:
    found = re.search(r"<metadata>(.*?)</metadata>", svg, re.DOTALL)
    assert found is not None
    return json.loads(found[1])


@pytest.mark.parametrize("zipped", [False, True])
def test_the_file_has_the_bytes_that_were_judged(zipped: bool) -> None:
    most = 2_000 if zipped else 9_000
    goal = Goal(max_bytes=most, gzip=zipped)
    result = _run(Fits(), goal)
    text = result.svg().encode()
    size = len(gzip.compress(text, 9, mtime=0)) if zipped else len(text)
    assert result.goal_facts is not None
    assert size == result.goal_facts["bytes"] == result.metrics["gzip_bytes" if zipped else "bytes"]
    assert 0.9 * most <= size <= most
    assert "A photo &amp; more" in result.svg()


def test_the_file_states_the_settings_that_were_asked_for() -> None:
    stated = _metadata(_run(Fits(), Goal(max_bytes=9_000), lr_scale=2.0).svg())
    assert (stated["iterations"], stated["lr_scale"]) == (40, 2.0)
    assert stated["curves"] < CONFIG.curves


def test_a_probe_and_a_whole_fit_come_first_and_corrections_continue() -> None:
    fits = Fits(lambda asked: asked // 2)  # too few paths for the bytes, however many are asked for
    result = _run(fits, Goal(max_bytes=9_000))
    assert len(fits.asked) == 2 + CORRECTIONS_MAX
    assert [config.iterations for config in fits.asked] == [10, 40, *[10] * CORRECTIONS_MAX]
    assert [config.lr_scale for config in fits.asked] == [1.0, 1.0, *[0.4] * CORRECTIONS_MAX]
    assert fits.asked[0].curves == 64
    assert fits.starts[:2] == [None, None]
    assert all(start is not None for start in fits.starts[2:])
    assert result.fitted.iterations == 10 + 40 + 10 * CORRECTIONS_MAX
    assert result.fitted.seconds == 2.0 * result.fitted.iterations
    iterations = [entry["iteration"] for entry in result.history]
    assert iterations[:6] == [1, 10, 11, 20, 51, 60]
    assert all(entry["seconds"] == 2.0 * entry["iteration"] for entry in result.history)


def test_the_probe_has_at_most_the_paths_of_the_fit() -> None:
    fits = Fits()
    _run(fits, Goal(target_psnr=60.0), curves=10, initial_curves=4)
    assert [config.curves for config in fits.asked] == [10, 10]


def test_no_correction_is_made_twice() -> None:
    fits = Fits()
    _run(fits, Goal(max_bytes=3_000, target_psnr=60.0))
    made = [(config.curves, id(start)) for config, start in zip(fits.asked, fits.starts, strict=True) if start]
    assert len(made) == len(set(made)) > 0


@pytest.mark.parametrize("interrupted", [0, 1, 2])
def test_an_interrupt_ends_the_search_with_what_fits(interrupted: int) -> None:
    fits = Fits(lambda asked: max(asked, 60), interrupted=interrupted)
    result = _run(fits, Goal(max_bytes=5_000))
    assert len(fits.asked) == interrupted + 1
    assert result.interrupted
    assert len(result.svg().encode()) <= 5_000
    assert len(result.scene) > 10


@pytest.mark.parametrize("interrupted", [0, 1])
def test_an_interrupt_ends_the_doubling(interrupted: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "is_worth_doubling", lambda _, trials, __: len(trials) < 4)
    fits = Fits(interrupted=interrupted)
    assert _run(fits, Goal(auto=True)).interrupted
    assert len(fits.asked) == interrupted + 1


def test_too_many_bytes_are_cut_from_the_paths_that_are_missed_least() -> None:
    fits = Fits(lambda _: 80)  # whatever is asked for
    result = _run(fits, Goal(max_bytes=6_000))
    assert 0.9 * 6_000 <= len(result.svg().encode()) <= 6_000
    whole = fits(replace(CONFIG, curves=3), None)  # other circles
    kept = len(result.scene)
    cut = whole.without(80 - kept)
    assert len(cut.fitted.scene) == kept
    others = [whole.fitted.scene.select(torch.randperm(80)[:kept].sort().values) for _ in range(5)]
    quality = [_psnr(whole, scene) for scene in others]
    assert _psnr(whole, cut.fitted.scene) > max(quality)


def _psnr(result: Result, scene: Scene) -> float:
    other = replace(result, fitted=replace(result.fitted, scene=scene))
    return float(other.metrics["psnr"])


def test_less_than_one_path_is_refused_in_a_line() -> None:
    with pytest.raises(
        InputError, match="^max_bytes must be enough for a path, got 300; give at least [0-9]+"
    ) as caught:
        _run(Fits(), Goal(max_bytes=300))
    assert "\n" not in str(caught.value)
    least = int(re.findall(r"at least (\d+)", str(caught.value))[0])
    assert len(_run(Fits(), Goal(max_bytes=least + 50)).scene) == 1


def test_a_policy_that_cannot_continue_is_refused_before_any_fit() -> None:
    fits = Fits()
    with pytest.raises(InputError, match="^policy must be scaffolding to meet a goal, got 'replacement'; give"):
        _run(fits, Goal(max_bytes=9_000), policy="replacement")
    assert not fits.asked


# from a drawing


@pytest.mark.parametrize(("most", "first"), [(2000, 30), (20, 20)])
def test_a_search_from_a_drawing_corrects_it(most: int, first: int) -> None:
    start, fits = circles(HEIGHT, WIDTH, 30), Fits()
    _run(fits, Goal(max_bytes=9_000), start, curves=most)
    assert fits.starts[0] is start
    assert fits.asked[0].curves == first
    assert fits.asked[0].iterations == 10
    assert all(config.curves <= most for config in fits.asked)


def test_the_curves_of_a_drawing_are_doubled_too() -> None:
    fits = Fits()
    _run(fits, Goal(auto=True), circles(HEIGHT, WIDTH, 30))
    assert fits.asked[0].curves == 30
    assert fits.asked[1].curves == 60


# auto


def test_curves_are_doubled_until_that_does_not_pay(monkeypatch: pytest.MonkeyPatch) -> None:
    fits = Fits()
    gains = iter([True, True, False])
    monkeypatch.setattr(search, "is_worth_doubling", lambda *_: next(gains))
    monkeypatch.setattr(search, "worthwhile_count", lambda trials: trials[-2].asked)
    result = _run(fits, Goal(auto=True))
    assert [config.curves for config in fits.asked] == [64, 128, 256, 128]
    assert [config.iterations for config in fits.asked] == [10, 8, 8, 40]
    assert fits.starts[-1] is None
    assert result.goal_facts is not None and result.goal_facts["auto"]


# a time budget, with a clock that the fits advance


class Clock:
    def __init__(self, fits: Fits, seconds: float) -> None:
        self.now, self._fits, self._seconds = 100.0, fits, seconds

    def __call__(self) -> float:
        return self.now

    def fit(self, config: FitConfig, start: Scene | None) -> Result:
        assert config.time_budget is not None
        wanted = self._seconds * config.iterations / CONFIG.iterations
        self.now += min(wanted, config.time_budget)
        return self._fits(config, start)


@pytest.mark.parametrize(("seconds", "fit_count"), [(60.0, 2), (1000.0, 2), (30.0, 6), (1.0, 8)])
def test_a_time_budget_ends_the_search(seconds: float, fit_count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    fits = Fits(lambda asked: asked // 2)
    clock = Clock(fits, seconds)
    monkeypatch.setattr(search.time, "perf_counter", clock)
    config = replace(CONFIG, time_budget=80.0)
    result = Search(Goal(max_bytes=9_000), config, clock.fit, _start_seconds=clock.now).run()
    assert clock.now - 100.0 <= 80.0
    assert len(fits.asked) == fit_count
    # Most of the time is for the fit, however long the probe would take.
    assert fits.asked[0].time_budget == 20.0
    assert fits.asked[1].time_budget is not None and fits.asked[1].time_budget >= 60.0
    assert len(result.svg().encode()) <= 9_000
    assert _metadata(result.svg())["time_budget"] == 80.0


def test_if_doubling_takes_all_the_time_its_best_fit_is_the_result(monkeypatch: pytest.MonkeyPatch) -> None:
    fits = Fits()
    clock = Clock(fits, 1000.0)
    monkeypatch.setattr(search.time, "perf_counter", clock)
    monkeypatch.setattr(search, "is_worth_doubling", lambda *_: True)
    result = Search(Goal(auto=True), replace(CONFIG, time_budget=80.0), clock.fit, _start_seconds=clock.now).run()
    assert clock.now - 100.0 <= 80.0
    assert [config.curves for config in fits.asked] == [64, 128, 256, 512]
    assert result.goal_facts is not None
    best = max(result.goal_facts["trials"], key=lambda trial: trial["psnr"])
    assert result.goal_facts["bytes"] == best["bytes"]


def test_an_interrupt_between_two_fits_ends_the_search_with_the_best() -> None:
    fits = Fits()

    def fit(config: FitConfig, start: Scene | None) -> Result:
        result = fits(config, start)
        if len(fits.asked) == 2:  # the fit is over: its file is drawn and measured now
            signal.raise_signal(signal.SIGINT)
        return result

    result = Search(Goal(target_psnr=90.0), CONFIG, fit).run()
    assert len(fits.asked) == 2
    assert result.interrupted
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_the_result_is_the_best_trial_not_the_last(monkeypatch: pytest.MonkeyPatch) -> None:
    fits = Fits()
    decibels = iter([20.0, 22.8, 18.8, 19.6, 18.3, 18.5, 18.0, 18.9])

    def trial(result: Result, goal: Goal) -> Trial:
        asked = result.config.curves
        return Trial(asked, asked, 100 * asked, next(decibels))

    monkeypatch.setattr(Result, "trial", trial)
    result = _run(fits, Goal(target_psnr=19.0))
    facts = result.goal_facts
    assert facts is not None
    assert facts["met"]
    assert next(each for each in facts["trials"] if each["bytes"] == facts["bytes"])["psnr"] == 19.6


@pytest.mark.parametrize(("below", "above"), [(24.0, 34.0), (20.0, 45.0)])
def test_a_step_in_the_psnr_is_found_wherever_it_is(
    below: float, above: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    def trial(result: Result, goal: Goal) -> Trial:
        asked = result.config.curves
        quality = (below if asked < step else above) + 0.5 * math.log2(asked / step)
        return Trial(asked, asked, 100 * asked, quality)

    monkeypatch.setattr(Result, "trial", trial)
    for step in (*range(5, 50), *range(50, 401, 7)):  # `trial` reads it
        fits = Fits(lambda _: 1)
        facts = _run(fits, Goal(target_psnr=30.0), curves=CURVES_MAX).goal_facts
        assert facts is not None and facts["met"]
        assert step <= facts["bytes"] / 100 <= max(1.04 * step, step + 1), f"a step at {step}: {facts['trials']}"
        assert len(fits.asked) <= 10, f"a step at {step}: {facts['trials']}"
