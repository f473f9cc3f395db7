"""The fits that a goal takes: a sketch, a fit of as many paths as it asks for, and corrections that go on from there."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Protocol

from warpvec.config import FitConfig
from warpvec.errors import InputError
from warpvec.goal import (
    SKETCH_CURVES,
    Goal,
    Trial,
    is_met,
    is_worth_doubling,
    next_count,
)
from warpvec.scene import Scene

SHORT_SHARE = 0.25
"""Iterations of a sketch or a correction over those of a fit."""

CORRECTION_RATE = 0.4
"""Learning rates of a correction over those of a fit: paths that stand well must not be thrown. 288 paths grown to 320
in 500 iterations (kodim07): 28.04 dB with 0.3, 27.77 with 1; from nothing in 2000: 27.95."""

CORRECTIONS_MAX = 6
"""After so many the file stands as it is, cut down to the bytes; two or three are usual."""


class Candidate(Protocol):
    """What a fit gave."""

    @property
    def fitted_scene(self) -> Scene:
        """In pixels of the fitted image."""

    @property
    def interrupted(self) -> bool: ...

    def trial(self, goal: Goal) -> Trial:
        """Its figures, measured on its file."""

    def without(self, count: int) -> Candidate:
        """The same without its ``count`` least important paths, not fitted again."""


Fit = Callable[[FitConfig, Scene | None], Candidate]
"""Fits with the settings, from the scene or from nothing."""


@dataclass
class Search:
    """The fits that were made for a goal."""

    goal: Goal
    config: FitConfig
    curves_max: int
    fit: Fit
    trials: list[Trial] = field(default_factory=list)
    start_seconds: float = field(default_factory=time.perf_counter)

    def run(self) -> Candidate:
        """The candidate that meets the goal, or comes nearest; its file never has more bytes than the goal allows.

        Raises:
            InputError: not even one path fits into the bytes.
        """
        candidate = self._sketch()
        if not candidate.interrupted:
            count = self._auto_count(candidate) if self.goal.auto else self._next_count()
            candidate = self._try(self._settings(count, 1.0, 1.0), None)
        for _ in range(CORRECTIONS_MAX):
            if self._is_done(candidate):
                break
            settings = self._settings(self._next_count(), SHORT_SHARE, CORRECTION_RATE)
            candidate = self._try(settings, candidate.fitted_scene)
        return self._cut(candidate)

    def _sketch(self) -> Candidate:
        count = min(SKETCH_CURVES, self.curves_max)
        return self._try(self._settings(count, SHORT_SHARE, 1.0), None, settled=False)

    def _auto_count(self, candidate: Candidate) -> int:
        """Doubles the paths of the sketch for as long as that pays, then obeys the rest of the goal."""
        while is_worth_doubling(self.trials, self.curves_max) and not self._is_late():
            settings = self._settings(2 * self.trials[-1].curves, SHORT_SHARE, CORRECTION_RATE)
            candidate = self._try(settings, candidate.fitted_scene, settled=False)
        self.curves_max = self.trials[-1].curves
        return self._next_count()

    def _is_done(self, candidate: Candidate) -> bool:
        return candidate.interrupted or self._is_late() or is_met(self.goal, self.trials[-1], self.curves_max)

    def _next_count(self) -> int:
        return next_count(self.goal, self.trials, self.curves_max)

    def _settings(self, count: int, share: float, rate: float) -> FitConfig:
        config = self.config
        return replace(
            config,
            curves=count,
            iterations=max(1, round(share * config.iterations)),
            lr_scale=rate * config.lr_scale,
            time_budget=None if config.time_budget is None else max(self._seconds_left(), 1e-3),
        )

    def _try(self, config: FitConfig, start: Scene | None, settled: bool = True) -> Candidate:
        candidate = self.fit(config, start)
        self.trials.append(candidate.trial(self.goal)._replace(settled=settled))
        return candidate

    def _cut(self, candidate: Candidate) -> Candidate:
        """``candidate`` without as many paths as keep it from the bytes."""
        limit = self.goal.max_bytes
        while limit is not None and self.trials[-1].bytes > limit:
            trial = self.trials[-1]
            if trial.curves <= 1:
                raise InputError(f"max_bytes must hold a path, got {limit}; {trial.bytes} bytes is the least here")
            excess = max(1, round(trial.curves * (trial.bytes - limit) / trial.bytes))
            candidate = candidate.without(min(excess, trial.curves - 1))
            self.trials.append(candidate.trial(self.goal))
        return candidate

    def _seconds_left(self) -> float:
        assert self.config.time_budget is not None
        return self.config.time_budget - (time.perf_counter() - self.start_seconds)

    def _is_late(self) -> bool:
        """Whether no time is left for another fit of the short kind."""
        return self.config.time_budget is not None and self._seconds_left() < SHORT_SHARE * self.config.time_budget
