"""The search for a file that meets a goal: a probe, a whole fit, then corrections that continue from earlier fits."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from warpvec.config.fit_config import FitConfig
from warpvec.config.rules import require_scaffolding
from warpvec.fit.interrupt import deferred_interrupts
from warpvec.geometry.scene import Scene
from warpvec.vectorization.byte_limit import cut_to_bytes
from warpvec.vectorization.goal import CORRECTION_RATE, PROBE_CURVES, SHORT_SHARE, Goal, Trial, make_facts
from warpvec.vectorization.next_trial import (
    STEP_UP_MAX,
    best_trial,
    is_hopeless,
    is_met,
    is_worth_doubling,
    narrows_bracket,
    next_count,
    worthwhile_count,
)
from warpvec.vectorization.result import Result

CORRECTIONS_MAX = 6
"""Largest number of corrections before a miss of the target PSNR and a hit enclose the wanted number of paths; two or
three corrections are usual. Such a bracket is then narrowed until it is tight, which takes at most six corrections if
the numbers differ by a factor of 4. In the end the best file is cut down to the bytes."""

DOUBLING_SHARE = 0.2
"""Iterations of a fit that only tells whether twice the paths pay, as a share of those of a whole fit. All doublings
together take 0.7 of a fit, the one that does not pay included, and the whole fit, which starts with few paths, 0.64."""

FIRST_SLOPE = 7.0
"""Decibels from the PSNR of the probe to that of a whole fit for each doubling of its paths, for the first guess of a
fit whose number of paths follows its PSNR. Too few paths cost less than too many, as the fit adds them soon."""

Fit = Callable[[FitConfig, Scene | None], Result]
"""Function that fits with the settings, from a scene in pixels of the fitted image or, with None, from nothing."""


def can_follow_psnr(goal: Goal, config: FitConfig) -> bool:
    """Return whether the number of paths can follow the PSNR of ``goal`` during one fit: paths are recycled."""
    is_psnr = goal.target_psnr is not None and not goal.auto
    return is_psnr and config.policy == "scaffolding" and config.recycle_gap > 0 and not config.lod


@dataclass
class Search:
    """The fits that are made for a goal.

    Attributes:
        goal: the requirements on the file.
        config: settings of a whole fit; its ``curves`` are the most that the search may use.
        fit: makes one fit.
        start: paths to begin with, None for none.
        trials: figures of the fits so far.
        fit_to_psnr: makes one fit from nothing, whose number of paths follows the PSNR of the goal up to a number; None
            if none can.
    """

    goal: Goal
    config: FitConfig
    fit: Fit
    start: Scene | None = None
    trials: list[Trial] = field(default_factory=list)
    fit_to_psnr: Callable[[FitConfig, int], Result] | None = None
    _results: list[Result] = field(default_factory=list)
    _start_seconds: float = field(default_factory=time.perf_counter)
    _interrupted: Callable[[], bool] = bool

    def run(self) -> Result:
        """Return the result that meets the goal or comes nearest. It never has more bytes than the goal allows.

        Raises:
            InputError: not even one path fits into the bytes, or the policy cannot continue from given paths.
        """
        require_scaffolding(self.config.policy, "to meet a goal")
        with deferred_interrupts() as interrupted:
            self._interrupted = interrupted
            self._approach()
            best = best_trial(self.goal, self.trials)
            return self._with_totals(*cut_to_bytes(self._results[best], self.goal, self.trials, self.trials[best]))

    def _approach(self) -> None:
        """Make fits until one meets the goal or no other would."""
        if self.start is None:
            self._probe()
        else:
            self._begin(self.start)
        curves_max = self.config.curves
        if self.goal.auto:
            self._double()
            curves_max = worthwhile_count(self.trials)
        if self.start is None and not self._is_over():
            self._fit_whole(curves_max)
        outside_count = 0  # corrections that do not narrow a bracket
        last: tuple[int, Result] | None = None
        while not self._is_done(curves_max):
            count = self._next_count(curves_max)
            outside_count += not narrows_bracket(self.goal, self.trials, count)
            if outside_count > CORRECTIONS_MAX:
                break
            nearest = self._nearest(count)
            if last is not None and last[0] == count and last[1] is nearest:
                break  # the same fit would find the same again
            last = count, nearest
            self._correct(count, nearest.fitted.scene)

    def _probe(self) -> None:
        count = min(PROBE_CURVES, self.config.curves)
        self._try(self._settings(count, SHORT_SHARE, 1.0), None, eligible=False)

    def _fit_whole(self, curves_max: int) -> None:
        """Make a whole fit, whose number of paths follows its PSNR if it can."""
        if self.fit_to_psnr is None:
            self._try(self._settings(self._next_count(curves_max), 1.0, 1.0), None)
            return
        assert self.goal.target_psnr is not None
        probe = self.trials[-1]
        octaves = max(-2.0, min((self.goal.target_psnr - probe.psnr) / FIRST_SLOPE, math.log2(STEP_UP_MAX)))
        if self.goal.max_bytes is not None:
            curves_max = next_count(replace(self.goal, target_psnr=None), self.trials, curves_max)
        count = max(1, min(round(probe.asked * 2.0**octaves), curves_max))
        result = self.fit_to_psnr(self._settings(count, 1.0, 1.0), curves_max)
        self._keep(result, len(result.fitted.scene))

    def _begin(self, start: Scene) -> None:
        self._correct(max(1, min(len(start), self.config.curves)), start)

    def _double(self) -> None:
        """Double the paths of the last result for as long as that pays."""
        while is_worth_doubling(self.goal, self.trials, self.config.curves) and not self._is_over():
            config = self._settings(2 * self.trials[-1].asked, DOUBLING_SHARE, CORRECTION_RATE)
            self._try(config, self._results[-1].fitted.scene, eligible=False)

    def _correct(self, count: int, start: Scene, eligible: bool = True) -> None:
        self._try(self._settings(count, SHORT_SHARE, CORRECTION_RATE), start, eligible)

    def _next_count(self, curves_max: int) -> int:
        return next_count(self.goal, self.trials, curves_max)

    def _nearest(self, count: int) -> Result:
        """Return the result that a correction to ``count`` paths continues from.

        For a PSNR goal, it is the smallest result with at least ``count`` paths, or else the largest. Removing paths
        beats adding them: by 2 dB for 34 paths of a logo. Without a PSNR goal, it is the last result.
        """
        if self.goal.target_psnr is None:
            return self._results[-1]
        counts = [trial.asked for trial in self.trials]
        enough = [index for index, asked in enumerate(counts) if asked >= count]
        index = min(enough, key=counts.__getitem__) if enough else max(range(len(counts)), key=counts.__getitem__)
        return self._results[index]

    def _settings(self, count: int, share: float, rate: float) -> FitConfig:
        config = self.config
        return replace(
            config,
            curves=count,
            iterations=max(1, round(share * config.iterations)),
            lr_scale=rate * config.lr_scale,
            time_budget=None if config.time_budget is None else self._seconds_for(share),
        )

    def _try(self, config: FitConfig, start: Scene | None, eligible: bool = True) -> None:
        self._keep(self.fit(config, start), config.curves, eligible)

    def _keep(self, result: Result, count: int, eligible: bool = True) -> None:
        # The file states the settings that the user asked for, so that its measured size is its final one.
        result = replace(result, config=replace(self.config, curves=max(count, 1)))
        self._results.append(result)
        self.trials.append(result.trial(self.goal)._replace(eligible=eligible))

    def _with_totals(self, result: Result, trial: Trial) -> Result:
        """Return ``result`` with the history, iterations and seconds of all fits, and the facts about the goal."""
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
        return replace(result, fitted=fitted, goal_facts=make_facts(self.goal, self.trials, trial))

    def _seconds_for(self, share: float) -> float:
        """Return the seconds for a fit of that share of the iterations: that share of the budget, or what is left."""
        assert self.config.time_budget is not None
        return max(min(self._seconds_left(), share * self.config.time_budget), 1e-3)

    def _seconds_left(self) -> float:
        assert self.config.time_budget is not None
        return self.config.time_budget - (time.perf_counter() - self._start_seconds)

    def _is_interrupted(self) -> bool:
        return self._interrupted() or self._results[-1].interrupted

    def _is_done(self, curves_max: int) -> bool:
        goal, trials = self.goal, self.trials
        return self._is_over() or is_met(goal, trials, curves_max) or is_hopeless(goal, trials)

    def _is_over(self) -> bool:
        return self._is_interrupted() or self._is_late()

    def _is_late(self) -> bool:
        """Return whether too little time is left for another short fit."""
        return self.config.time_budget is not None and self._seconds_left() < SHORT_SHARE * self.config.time_budget
