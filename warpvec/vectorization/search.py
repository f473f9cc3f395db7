"""The fits that a goal takes: a sketch, one of as many paths as it should need, and corrections that go on from it."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from warpvec.config.fit_config import FitConfig
from warpvec.errors import InputError
from warpvec.fit.interrupt import noted_interrupts
from warpvec.geometry.scene import Scene
from warpvec.vectorization.goal import (
    CORRECTION_RATE,
    SHORT_SHARE,
    SKETCH_CURVES,
    Goal,
    Trial,
    best_trial,
    facts_of,
    is_in_vain,
    is_met,
    is_worth_doubling,
    next_count,
    worthwhile_count,
)
from warpvec.vectorization.result import Result

CORRECTIONS_MAX = 6
"""After so many the file stands as it is, cut down to the bytes; two or three are usual."""


Fit = Callable[[FitConfig, Scene | None], Result]
"""Fits with the settings, from the scene, in pixels of the fitted image, or from nothing."""


@dataclass
class Search:
    """The fits that are made for a goal.

    Attributes:
        goal: what is asked.
        config: settings of a fit; its curves are the most that may be taken.
        fit: makes one.
        start: paths to begin with, None for nothing.
        trials: figures of the fits so far.
    """

    goal: Goal
    config: FitConfig
    fit: Fit
    start: Scene | None = None
    trials: list[Trial] = field(default_factory=list)
    _results: list[Result] = field(default_factory=list)
    _start_seconds: float = field(default_factory=time.perf_counter)
    _interrupted: Callable[[], bool] = bool

    def run(self) -> Result:
        """What meets the goal, or comes nearest; its file never has more bytes than the goal allows.

        Raises:
            InputError: not even one path fits into the bytes, or the policy does not go on from given paths.
        """
        if self.config.policy != "scaffolding":
            raise InputError(f"policy must be scaffolding to meet a goal, got {self.config.policy!r}; give scaffolding")
        with noted_interrupts() as interrupted:
            self._interrupted = interrupted
            self._approach()
            best = best_trial(self.goal, self.trials)
            return self._summed(*self._cut(self._results[best], self.trials[best]))

    def _approach(self) -> None:
        """Fits, until one meets the goal or no other would."""
        result = self._sketch() if self.start is None else self._begin(self.start)
        most = self.config.curves
        if self.goal.auto:
            result = self._doubled(result)
            most = worthwhile_count(self.trials)
        if self.start is None and not self._is_over():
            result = self._try(self._settings(self._next_count(most), 1.0, 1.0), None)
        for _ in range(CORRECTIONS_MAX):
            if self._is_over() or is_met(self.goal, self.trials[-1], most) or is_in_vain(self.goal, self.trials):
                break
            result = self._correct(self._next_count(most), result.fitted.scene)

    def _sketch(self) -> Result:
        count = min(SKETCH_CURVES, self.config.curves)
        return self._try(self._settings(count, SHORT_SHARE, 1.0), None, settled=False)

    def _begin(self, start: Scene) -> Result:
        return self._correct(max(1, min(len(start), self.config.curves)), start)

    def _correct(self, count: int, start: Scene, settled: bool = True) -> Result:
        return self._try(self._settings(count, SHORT_SHARE, CORRECTION_RATE), start, settled)

    def _doubled(self, result: Result) -> Result:
        """``result`` with its paths doubled for as long as that pays."""
        while is_worth_doubling(self.trials, self.config.curves) and not self._is_over():
            result = self._correct(2 * self.trials[-1].asked, result.fitted.scene, settled=False)
        return result

    def _next_count(self, most: int) -> int:
        return next_count(self.goal, self.trials, most)

    def _settings(self, count: int, share: float, rate: float) -> FitConfig:
        config = self.config
        return replace(
            config,
            curves=count,
            iterations=max(1, round(share * config.iterations)),
            lr_scale=rate * config.lr_scale,
            time_budget=None if config.time_budget is None else self._seconds_for(share),
        )

    def _try(self, config: FitConfig, start: Scene | None, settled: bool = True) -> Result:
        # Its file states the settings that were asked for: what is measured is what would be written.
        result = replace(self.fit(config, start), config=replace(self.config, curves=config.curves))
        self._results.append(result)
        self.trials.append(result.trial(self.goal)._replace(settled=settled))
        return result

    def _cut(self, result: Result, trial: Trial) -> tuple[Result, Trial]:
        """``result``, and its ``trial``, without as many paths as keep it from the bytes."""
        limit = self.goal.max_bytes
        while limit is not None and trial.bytes > limit:
            if trial.curves <= 1:
                raise InputError(f"max_bytes must hold a path, got {limit}; {trial.bytes} bytes is the least here")
            excess = max(1, round(trial.curves * (trial.bytes - limit) / trial.bytes))
            result = result.without(min(excess, trial.curves - 1))
            trial = result.trial(self.goal)
            self.trials.append(trial)
        return result, trial

    def _summed(self, result: Result, trial: Trial) -> Result:
        """``result`` with the settings that were asked for, and what all fits took."""
        history: list[dict[str, float]] = []
        iterations, seconds = 0, 0.0
        for fitted in (each.fitted for each in self._results):
            history += [
                {**entry, "iteration": entry["iteration"] + iterations, "seconds": entry["seconds"] + seconds}
                for entry in fitted.history
            ]
            iterations, seconds = iterations + fitted.iterations, seconds + fitted.seconds
        fitted = replace(
            result.fitted,
            history=history,
            iterations=iterations,
            seconds=seconds,
            interrupted=self._is_interrupted(),
        )
        return replace(result, fitted=fitted, goal_facts=facts_of(self.goal, self.trials, trial))

    def _seconds_for(self, share: float) -> float:
        """For a fit of that share of the iterations: its share of the budget, so that a sketch leaves time for more."""
        assert self.config.time_budget is not None
        return max(min(self._seconds_left(), share * self.config.time_budget), 1e-3)

    def _seconds_left(self) -> float:
        assert self.config.time_budget is not None
        return self.config.time_budget - (time.perf_counter() - self._start_seconds)

    def _is_interrupted(self) -> bool:
        return self._interrupted() or self._results[-1].interrupted

    def _is_over(self) -> bool:
        return self._is_interrupted() or self._is_late()

    def _is_late(self) -> bool:
        """Whether no time is left for another fit of the short kind."""
        return self.config.time_budget is not None and self._seconds_left() < SHORT_SHARE * self.config.time_budget
