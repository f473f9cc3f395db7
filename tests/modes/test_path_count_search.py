"""The number of paths as the knob of a goal, with circles in place of fits: the fits it makes, its end, its result."""

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
from trials import trial

from warpvec.config.fit_config import FitConfig
from warpvec.drawing.drawing import Drawing
from warpvec.drawing.encoding import Encoding
from warpvec.errors import InputError
from warpvec.geometry.scene import Scene
from warpvec.goals import search
from warpvec.goals.goal import SEARCHED_CURVES_MAX, Goal, make_goal
from warpvec.goals.search import Trial, meet
from warpvec.modes import next_count
from warpvec.modes.path_count import CORRECTIONS_MAX, PathCount
from warpvec.modes.request import Request
from warpvec.result import Result
from warpvec.watch import watch as watching
from warpvec.watch.progress import Progress
from warpvec.watch.watch import Part, Watch

HEIGHT, WIDTH = 48, 64
PHOTO = np.random.default_rng(0).random((HEIGHT, WIDTH, 3), np.float32)
CONFIG = FitConfig(curves=2000, iterations=40, lod=True)
"""With levels of detail no fit can follow a goal while it runs, so a goal takes several fits."""


class Fits:
    """Stands in for the fits of a photo: returns circles, and lists the settings and time budgets it was given.

    Args:
        count: number of circles for a number of paths.
        interrupted: number of the fit that the user interrupts.
        seconds: time of a whole fit.
    """

    def __init__(
        self,
        count: Callable[[int], int] = lambda asked: asked,
        interrupted: int | None = None,
        clock: Clock | None = None,
    ) -> None:
        self._count, self._interrupted, self._clock = count, interrupted, clock
        self.asked: list[FitConfig] = []
        self.budgets: list[float | None] = []
        self.starts: list[Scene | None] = []
        self.finished_as: list[tuple[int, bool]] = []
        self.request: Request

    def encoding(self, settings: FitConfig) -> Encoding:
        return self.request.encoding.of_photo(settings, gzip=self.request.goal.gzip)

    def _drawing(self, scene: Scene, encoding: Encoding) -> Drawing:
        return Drawing.of(scene, encoding, "cpu")

    def finished(self, drawing: Drawing, *, sharp: bool = False) -> Drawing:
        self.finished_as.append((len(drawing.fitted), sharp))
        return drawing

    def once(self, settings: FitConfig, start: Scene | None, part: Part, budget: Any = None) -> Drawing:
        self.asked.append(settings)
        self.budgets.append(part.time_budget)
        self.starts.append(start)
        torch.manual_seed(len(self.asked))
        scene = circles(HEIGHT, WIDTH, self._count(settings.curves))
        if self._clock is not None:
            self._clock.pass_fit(settings, part)
        for k in (1, settings.iterations):
            part.report(Progress(k, k, len(scene), 2.0 * k, torch.tensor(0.01), lambda: scene), is_entry=True)
        if len(self.asked) - 1 == self._interrupted:
            signal.raise_signal(signal.SIGINT)
        return self._drawing(scene, self.encoding(settings))


class QuickFits(Fits):
    """Makes drawings whose files are never looked at."""

    def _drawing(self, scene: Scene, encoding: Encoding) -> Drawing:
        return Drawing(scene, scene, 0.0, encoding, "cpu")


def _run(fits: Fits, goal: Goal, start: Scene | None = None, **settings: Any) -> Result:
    config = replace(CONFIG, **settings)
    with Watch(time_budget=config.time_budget) as watch:
        fits.request = Request.of(PHOTO, config, goal, title="A photo & more", watch=watch)
        drawing = meet(goal, PathCount(fits.request, fits, start))  # type: ignore[arg-type]
        return Result(drawing, watch.facts())


def _metadata(svg: str) -> dict[str, Any]:
    found = re.search(r"<metadata>(.*?)</metadata>", svg, re.DOTALL)
    assert found is not None
    return json.loads(found[1])


@pytest.mark.parametrize("zipped", [False, True])
def test_the_file_has_the_bytes_that_were_judged(zipped: bool) -> None:
    most = 2_000 if zipped else 9_000
    goal = make_goal(max_bytes=most, gzip=zipped)
    result = _run(Fits(), goal)
    text = result.svg().encode()
    size = len(gzip.compress(text, 9, mtime=0)) if zipped else len(text)
    assert result.goal_facts is not None
    assert size == result.goal_facts["bytes"] == result.metrics["gzip_bytes" if zipped else "bytes"]
    assert 0.9 * most <= size <= most
    assert "A photo &amp; more" in result.svg()


def test_the_file_states_the_settings_that_were_asked_for() -> None:
    stated = _metadata(_run(Fits(), make_goal(max_bytes=9_000), lr_scale=2.0).svg())
    assert (stated["iterations"], stated["lr_scale"]) == (40, 2.0)
    assert stated["curves"] < CONFIG.curves


@pytest.mark.parametrize("soft", ["auto", "0"])
def test_a_fit_to_a_size_is_finished_sharp_and_with_room_for_soft_paths(soft: str) -> None:
    fits = QuickFits(lambda asked: 200)
    _run(fits, make_goal(max_bytes=90_000), lod=False, soft=soft)
    assert fits.finished_as == [(200, True), (194, False)][: 2 if soft == "auto" else 1]


def test_a_probe_and_a_whole_fit_come_first_and_corrections_continue() -> None:
    fits = Fits(lambda asked: asked // 2)  # too few paths for the bytes, however many are asked for
    result = _run(fits, make_goal(max_bytes=9_000))
    assert len(fits.asked) == 2 + CORRECTIONS_MAX
    assert [config.iterations for config in fits.asked] == [10, 40, *[10] * CORRECTIONS_MAX]
    assert [config.lr_scale for config in fits.asked] == [1.0, 1.0, *[0.4] * CORRECTIONS_MAX]
    assert fits.asked[0].curves == 64
    assert fits.starts[:2] == [None, None]
    assert all(start is not None for start in fits.starts[2:])
    assert result.run.iterations == 10 + 40 + 10 * CORRECTIONS_MAX
    iterations = [entry["iteration"] for entry in result.history]
    assert iterations[:6] == [1, 10, 11, 50, 51, 60]


def test_the_probe_has_at_most_the_paths_of_the_fit() -> None:
    fits = Fits()
    _run(fits, make_goal(target_psnr=60.0), curves=10, initial_curves=4)
    assert [config.curves for config in fits.asked] == [10, 10]


def test_no_correction_is_made_twice() -> None:
    fits = Fits()
    _run(fits, make_goal(max_bytes=3_000, target_psnr=60.0))
    made = [(config.curves, id(start)) for config, start in zip(fits.asked, fits.starts, strict=True) if start]
    assert len(made) == len(set(made)) > 0


@pytest.mark.parametrize("interrupted", [0, 1, 2])
def test_an_interrupt_ends_the_search_with_what_fits(interrupted: int) -> None:
    fits = Fits(lambda asked: max(asked, 60), interrupted=interrupted)
    result = _run(fits, make_goal(max_bytes=5_000))
    assert len(fits.asked) == interrupted + 1
    assert result.interrupted
    assert len(result.svg().encode()) <= 5_000
    assert len(result.scene) > 10


@pytest.mark.parametrize("interrupted", [0, 1])
def test_an_interrupt_ends_the_doubling(interrupted: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(next_count, "is_worth_doubling", lambda _, trials, __: len(trials) < 4)
    fits = Fits(interrupted=interrupted)
    assert _run(fits, make_goal(auto=True)).interrupted
    assert len(fits.asked) == interrupted + 1


def test_too_many_bytes_are_cut_from_the_paths_that_are_missed_least() -> None:
    fits = Fits(lambda _: 80)  # whatever is asked for
    result = _run(fits, make_goal(max_bytes=6_000))
    assert 0.9 * 6_000 <= len(result.svg().encode()) <= 6_000
    whole = fits.once(replace(CONFIG, curves=3), None, Watch().part())  # other circles
    kept = len(result.scene)
    cut = whole.without(80 - kept)
    assert len(cut.fitted) == kept
    others = [whole.with_fitted(whole.fitted.select(torch.randperm(80)[:kept].sort().values)) for _ in range(5)]
    assert cut.psnr > max(other.psnr for other in others)


def test_less_than_one_path_is_refused_in_a_line() -> None:
    with pytest.raises(
        InputError, match="^max_bytes is too small for one path, got 300; give at least [0-9]+"
    ) as caught:
        _run(Fits(), make_goal(max_bytes=300))
    assert "\n" not in str(caught.value)
    least = int(re.findall(r"at least (\d+)", str(caught.value))[0])
    assert len(_run(Fits(), make_goal(max_bytes=least + 50)).scene) == 1


def test_a_policy_that_cannot_continue_is_refused_before_any_fit() -> None:
    fits = Fits()
    with pytest.raises(InputError, match="^policy must be scaffolding to meet a goal, got 'replacement'; give"):
        _run(fits, make_goal(max_bytes=9_000), policy="replacement", lod=False)
    assert not fits.asked


# from a drawing


@pytest.mark.parametrize(("most", "first"), [(2000, 30), (20, 20)])
def test_a_search_from_a_drawing_corrects_it(most: int, first: int) -> None:
    start, fits = circles(HEIGHT, WIDTH, 30), Fits()
    _run(fits, make_goal(max_bytes=9_000), start, curves=most)
    assert fits.starts[0] is start
    assert fits.asked[0].curves == first
    assert fits.asked[0].iterations == 10
    assert all(config.curves <= most for config in fits.asked)


def test_the_curves_of_a_drawing_are_doubled_too() -> None:
    fits = Fits()
    _run(fits, make_goal(auto=True), circles(HEIGHT, WIDTH, 30))
    assert fits.asked[0].curves == 30
    assert fits.asked[1].curves == 60


# auto


def test_curves_are_doubled_until_that_does_not_pay(monkeypatch: pytest.MonkeyPatch) -> None:
    fits = Fits()
    gains = iter([True, True, False])
    monkeypatch.setattr(next_count, "is_worth_doubling", lambda *_: next(gains))
    monkeypatch.setattr(next_count, "worthwhile_count", lambda trials: trials[-2].asked)
    result = _run(fits, make_goal(auto=True))
    assert [config.curves for config in fits.asked] == [64, 128, 256, 128]
    assert [config.iterations for config in fits.asked] == [10, 8, 8, 40]
    assert fits.starts[-1] is None
    assert result.goal_facts is not None and result.goal_facts["auto"]


# a time budget, with a clock that the fits advance


class Clock:
    """A clock that only fits advance, by ``seconds`` for each whole fit, or less if their time budget is less."""

    def __init__(self, seconds: float, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now, self._seconds = 100.0, seconds
        monkeypatch.setattr(watching.time, "perf_counter", lambda: self.now)

    def pass_fit(self, settings: FitConfig, part: Part) -> None:
        assert part.time_budget is not None
        self.now += min(self._seconds * settings.iterations / CONFIG.iterations, part.time_budget)


@pytest.mark.parametrize(("seconds", "fit_count"), [(60.0, 2), (1000.0, 2), (30.0, 6), (1.0, 8)])
def test_a_time_budget_ends_the_search(seconds: float, fit_count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    clock = Clock(seconds, monkeypatch)
    fits = Fits(lambda asked: asked // 2, clock=clock)
    result = _run(fits, make_goal(max_bytes=9_000), time_budget=80.0)
    assert clock.now - 100.0 <= 80.0
    assert len(fits.asked) == fit_count
    # Most of the time is for the fit, however long the probe would take.
    assert fits.budgets[0] == 20.0
    assert fits.budgets[1] is not None and fits.budgets[1] >= 60.0
    assert len(result.svg().encode()) <= 9_000
    assert _metadata(result.svg())["time_budget"] == 80.0


def test_if_doubling_takes_all_the_time_its_best_fit_is_the_result(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = Clock(1000.0, monkeypatch)
    fits = Fits(clock=clock)
    monkeypatch.setattr(next_count, "is_worth_doubling", lambda *_: True)
    result = _run(fits, make_goal(auto=True), time_budget=80.0)
    assert clock.now - 100.0 <= 80.0
    assert [config.curves for config in fits.asked] == [64, 128, 256, 512]
    assert result.goal_facts is not None
    best = max(result.goal_facts["trials"], key=lambda trial: trial["psnr"])
    assert result.goal_facts["bytes"] == best["bytes"]


def test_an_interrupt_between_two_fits_ends_the_search_with_the_best() -> None:
    fits = Fits(interrupted=1)
    result = _run(fits, make_goal(target_psnr=90.0))
    assert len(fits.asked) == 2
    assert result.interrupted
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_the_result_is_the_best_trial_not_the_last(monkeypatch: pytest.MonkeyPatch) -> None:
    fits = Fits()
    decibels = iter([20.0, 22.8, 18.8, 19.6, 18.3, 18.5, 18.0, 18.9])

    def figures(drawing: Drawing, goal: Goal) -> Trial:
        asked = drawing.encoding.settings.curves
        return trial(asked, 100 * asked, next(decibels))

    monkeypatch.setattr(search, "trial_of", figures)
    result = _run(fits, make_goal(target_psnr=19.0))
    facts = result.goal_facts
    assert facts is not None
    assert facts["met"]
    assert next(each for each in facts["trials"] if each["bytes"] == facts["bytes"])["psnr"] == 19.6


@pytest.mark.parametrize(("below", "above"), [(24.0, 34.0), (20.0, 45.0)])
def test_a_step_in_the_psnr_is_found_wherever_it_is(
    below: float, above: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    def figures(drawing: Drawing, goal: Goal) -> Trial:
        asked = drawing.encoding.settings.curves
        quality = (below if asked < step else above) + 0.5 * math.log2(asked / step)
        return trial(asked, 100 * asked, quality)

    monkeypatch.setattr(search, "trial_of", figures)
    for step in (*range(5, 50), *range(50, 401, 7)):  # `figures` reads it
        fits = QuickFits(lambda _: 1)
        facts = _run(fits, make_goal(target_psnr=30.0), curves=SEARCHED_CURVES_MAX).goal_facts
        assert facts is not None and facts["met"]
        assert step <= facts["bytes"] / 100 <= max(1.04 * step, step + 1), f"a step at {step}: {facts['trials']}"
        assert len(fits.asked) <= 10, f"a step at {step}: {facts['trials']}"
