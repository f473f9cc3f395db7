"""The knob of photos: the number of paths.

A number of bytes takes one fit, whose number of paths follows the bytes while it runs. A quality takes a short probe, a
whole fit whose number of paths follows the quality, and corrections that continue from earlier fits. Without either,
the paths are doubled for as long as that pays.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Protocol

from warpvec.config.cross_rules import require_scaffolding
from warpvec.config.fit_config import FitConfig
from warpvec.config.limits import MAX_COUNT
from warpvec.config.presets import MINIFIED
from warpvec.drawing.drawing import Drawing
from warpvec.drawing.encoding import Encoding
from warpvec.files import text_bytes
from warpvec.fit.budget import Budget, ByteBudget, QualityBudget
from warpvec.geometry.cubics import to_cubics
from warpvec.geometry.scene import Scene
from warpvec.goals.goal import Goal
from warpvec.goals.search import Attempt, Trial, within_limit
from warpvec.modes import next_count
from warpvec.modes.request import Request
from warpvec.watch.watch import Part

SHORT_BYTES, LONG_BYTES = (170, 40.0, 2.8), (1300, 66.0, 3.8)
"""Bytes of a file besides its paths, of a path besides the numbers of its cubics, and of each number: minified, and in
the long form with its settings and two decimals."""

GZIP_SHARE = 0.42
"""Bytes of the paths after gzip over the bytes before."""

RICH_BYTES = 0.2
"""Bytes per pixel of the fitted image from which paths of `RICH_SEGMENTS` cubics are better than those of `MINIFIED`:
at 0.13 these gain 0.1 dB, at 0.25 they lose 0.03 (kodim07)."""

RICH_SEGMENTS = 2
"""Average number of cubics per path in files of many bytes, and in files that gzip makes small: it takes more off the
text around the numbers than off the numbers."""

LONGER = 1.25
"""Iterations of the one fit to a number of bytes over those of a fit without a goal. A search by several fits took 1.5
times as many and more; 1.25 times gain 0.05 dB."""

PROBE_CURVES = 64
"""Paths of the probe, a first short fit from which the search guesses the number of paths. It takes a second."""

SHORT_SHARE = 0.25
"""Iterations of a short fit (the probe or a correction) as a share of those of a whole fit."""

CORRECTION_RATE = 0.4
"""Factor for the learning rates of a correction, so that it keeps the paths near their places. 288 paths grown to 320
in 500 iterations (kodim07) reach 28.04 dB with 0.3 and 27.77 with 1; from nothing in 2000 iterations: 27.95."""

CORRECTIONS_MAX = 6
"""Largest number of corrections before a miss of the quality and a hit enclose the wanted number of paths; two or three
corrections are usual. Such a bracket is then narrowed until it is tight, which takes at most six corrections if the
numbers differ by a factor of 4."""

DOUBLING_SHARE = 0.2
"""Iterations of a fit that only tells whether twice the paths pay, as a share of those of a whole fit. All doublings
together take 0.7 of a fit, the one that does not pay included, and the whole fit, which starts with few paths, 0.64."""

SOFT_ROOM = 0.03
"""Share of the paths of a file of a given size that go, those of lowest removal cost, to make room for what soft paths
need: eight filters of 125 bytes, and 17 bytes for each path."""

FIRST_SLOPE = 7.0
"""Decibels from the probe to a whole fit for each doubling of its paths, for the first guess of a fit whose number of
paths follows its quality. Too few paths cost less than too many, as the fit adds them soon."""


class Fits(Protocol):
    """What makes the fits of a photo; see `warpvec.modes.photo.PhotoFits`."""

    def encoding(self, settings: FitConfig) -> Encoding:
        """Return the encoding of the file of a fit with ``settings``."""

    def finished(self, drawing: Drawing, *, sharp: bool = False) -> Drawing:
        """Return the ``drawing`` of a whole fit with the best values, and soft paths unless it must stay ``sharp``."""

    def once(self, settings: FitConfig, start: Scene | None, part: Part, budget: Budget | None = None) -> Drawing:
        """Fit once with ``settings``, and return the drawing."""


class PathCount:
    """The knob of one photo.

    Args:
        request: its ``settings`` are those of a whole fit.
        fits: makes the fits.
        start: paths to begin with, in pixels of the reduced picture; None for none.
    """

    cuts_smallest = False
    refusal: tuple[str, str] | None = None

    def __init__(self, request: Request, fits: Fits, start: Scene | None) -> None:
        require_scaffolding(request.settings.policy, "to meet a goal")
        self._goal, self._config, self._watch = request.goal, request.settings, request.watch
        self._picture, self._fits, self._start = request.picture, fits, start
        self._drawings: list[Drawing] = []

    def attempts(self, trials: Sequence[Trial]) -> Iterator[Attempt]:
        """Make drawings until one meets the goal or no other would."""
        if self._start is None and can_follow_size(self._goal, self._config):
            yield from self._fits_to_size()
            return
        if self._start is None:
            yield self._probe()
        else:
            yield self._correct(max(1, min(len(self._start), self._config.curves)), self._start)
        curves_max = self._config.curves
        if self._goal.auto:
            yield from self._doublings(trials)
            curves_max = next_count.worthwhile_count(trials)
        if self._start is None and not self._is_over():
            yield self._fit_whole(trials, curves_max)
        yield from self._corrections(trials, curves_max)
        if self._start is None and not self._goal.bounds and not self._is_over():
            yield from self._finished(self._drawings[-1])

    def _corrections(self, trials: Sequence[Trial], curves_max: int) -> Iterator[Attempt]:
        outside_count = 0  # corrections that do not narrow a bracket
        last: tuple[int, Drawing] | None = None
        while not self._is_done(trials, curves_max):
            count = next_count.next_count(self._goal, trials, curves_max)
            outside_count += not next_count.narrows_bracket(self._goal, trials, count)
            if outside_count > CORRECTIONS_MAX:
                break
            nearest = self._nearest(trials, count)
            if last is not None and last[0] == count and last[1] is nearest:
                break  # the same fit would find the same again
            last = count, nearest
            yield self._correct(count, nearest.fitted)

    # Fits

    def _probe(self) -> Attempt:
        count = min(PROBE_CURVES, self._config.curves)
        return self._try(count, SHORT_SHARE, 1.0, None, eligible=False)

    def _fit_whole(self, trials: Sequence[Trial], curves_max: int) -> Attempt:
        """Make a whole fit, whose number of paths follows its quality if it can."""
        if not can_follow_quality(self._goal, self._config):
            return self._try(next_count.next_count(self._goal, trials, curves_max), 1.0, 1.0, None)
        assert self._goal.level is not None
        probe = trials[-1]
        octaves = max(-2.0, min((self._goal.level - probe.level) / FIRST_SLOPE, math.log2(next_count.STEP_UP_MAX)))
        if self._goal.limit is not None:
            curves_max = next_count.next_count(self._goal.without_quality(), trials, curves_max)
        count = max(1, min(round(probe.asked * 2.0**octaves), curves_max))
        return self._fit_to_quality(count, curves_max)

    def _doublings(self, trials: Sequence[Trial]) -> Iterator[Attempt]:
        """Double the paths of the last drawing for as long as that pays."""
        while next_count.is_worth_doubling(self._goal, trials, self._config.curves) and not self._is_over():
            count, start = 2 * trials[-1].asked, self._drawings[-1].fitted
            yield self._try(count, DOUBLING_SHARE, CORRECTION_RATE, start, eligible=False)

    def _correct(self, count: int, start: Scene) -> Attempt:
        return self._try(count, SHORT_SHARE, CORRECTION_RATE, start)

    def _fits_to_size(self) -> Iterator[Attempt]:
        """Make the one fit for a largest size, and finish it twice: sharp, and with soft paths in place of others."""
        yield self._fit_to_size()
        fitted = self._drawings[-1]
        if not self._is_over():
            yield from self._finished(fitted, sharp=True)
        count = math.ceil(SOFT_ROOM * len(fitted.fitted))
        if self._config.soft_max != 0 and count < len(fitted.fitted) and not self._is_over():
            yield from self._finished(fitted.without(count))

    def _finished(self, drawing: Drawing, *, sharp: bool = False) -> Iterator[Attempt]:
        """Yield the finished ``drawing`` of a whole fit, within the size of the goal, if that is another one."""
        found = self._fits.finished(drawing, sharp=sharp)
        if found is not drawing:
            yield Attempt(within_limit(found, self._goal))

    def _fit_to_size(self) -> Attempt:
        """Make the one fit for a largest size: its number of paths follows the size while it runs."""
        settings = settings_for_size(self._goal, self._config, self._picture.reduced[..., 0].size)
        settings = replace(settings, curves=first_count(self._goal, settings))
        drawing = self._fits.once(settings, None, self._watch.part(), self._size_budget(settings))
        stated = replace(settings, iterations=self._config.iterations)
        return self._kept(drawing, len(drawing.fitted), stated)

    def _fit_to_quality(self, count: int, curves_max: int) -> Attempt:
        """Make a fit that begins with ``count`` paths, whose number follows the quality up to ``curves_max``."""
        settings = self._settings(count, 1.0, 1.0)
        encoding, goal = self._fits.encoding(settings), self._goal
        assert goal.quality is not None and goal.level is not None

        def level_of(scene: Scene) -> float:
            """Return the quality in decibels of the file that would show all paths of a fit's ``scene``."""
            assert goal.quality is not None
            cubics = to_cubics(scene.cpu().scaled(*self._picture.enlargement))[0]
            shown = Drawing(scene, cubics, 0.0, encoding, "cpu")
            return goal.quality[0].decibels(goal.quality[0].measure(shown, goal.gzip))

        budget = QualityBudget(goal.level, curves_max, level_of)
        drawing = self._fits.once(settings, None, self._watch.part(), budget)
        return self._kept(drawing, len(drawing.fitted), self._config)

    def _try(self, count: int, share: float, rate: float, start: Scene | None, eligible: bool = True) -> Attempt:
        """Fit ``count`` paths in a share of the iterations and of the time, with learning rates times ``rate``."""
        settings = self._settings(count, share, rate)
        drawing = self._fits.once(settings, start, self._watch.part(share=share))
        return self._kept(drawing, settings.curves, self._config, eligible)

    def _settings(self, count: int, share: float, rate: float) -> FitConfig:
        config = self._config
        iterations = max(1, round(share * config.iterations))
        return replace(config, curves=count, iterations=iterations, lr_scale=rate * config.lr_scale)

    def _size_budget(self, settings: FitConfig) -> Budget:
        encoding, picture, gzip = self._fits.encoding(settings), self._picture, self._goal.gzip
        assert self._goal.limit is not None

        def count_bytes(scene: Scene) -> int:
            return text_bytes(encoding.text(scene.scaled(*picture.enlargement)), gzip=gzip)

        return ByteBudget(int(self._goal.limit[1]), count_bytes, self._config.curves)

    def _kept(self, drawing: Drawing, count: int, stated: FitConfig, eligible: bool = True) -> Attempt:
        """Keep a drawing of ``count`` paths, whose file states the settings ``stated``."""
        settings = replace(stated, curves=max(count, 1))
        drawing = replace(drawing, encoding=replace(drawing.encoding, settings=settings))
        self._drawings.append(drawing)
        return Attempt(drawing, eligible)

    def _nearest(self, trials: Sequence[Trial], count: int) -> Drawing:
        """Return the drawing that a correction to ``count`` paths continues from.

        For a quality, it is the smallest drawing with at least ``count`` paths, or else the largest. Removing paths
        beats adding them: by 2 dB for 34 paths of a logo. Without a quality, it is the last drawing.
        """
        if self._goal.quality is None:
            return self._drawings[-1]
        counts = [trial.asked for trial in trials]
        enough = [index for index, asked in enumerate(counts) if asked >= count]
        index = min(enough, key=counts.__getitem__) if enough else max(range(len(counts)), key=counts.__getitem__)
        return self._drawings[index]

    # The end of the search

    def _is_done(self, trials: Sequence[Trial], curves_max: int) -> bool:
        goal = self._goal
        return self._is_over() or next_count.is_met(goal, trials, curves_max) or next_count.is_hopeless(goal, trials)

    def _is_over(self) -> bool:
        """Return whether the user has asked for the end, or too little time is left for another short fit."""
        return self._watch.is_stopped() or not self._watch.has_time_for(SHORT_SHARE)


def can_follow_size(goal: Goal, config: FitConfig) -> bool:
    """Return whether one fit meets ``goal``: a largest size alone, and paths of cubics that are recycled."""
    is_size = goal.limit is not None and goal.limit[0].is_of_text and goal.quality is None and not goal.auto
    return is_size and config.path_model == "segments" and config.policy == "scaffolding" and not config.lod


def can_follow_quality(goal: Goal, config: FitConfig) -> bool:
    """Return whether the number of paths can follow the quality of ``goal`` during one fit: paths are recycled."""
    is_quality = goal.quality is not None and not goal.auto
    return is_quality and config.policy == "scaffolding" and config.recycle_gap > 0 and not config.lod


def settings_for_size(goal: Goal, config: FitConfig, pixel_count: int) -> FitConfig:
    """Return ``config`` with the iterations of the one fit and, unless ``goal`` keeps them, the cubics per path.

    Args:
        goal: the size of the file.
        config: settings of the fit.
        pixel_count: number of pixels of the fitted image.
    """
    assert goal.limit is not None
    config = replace(config, iterations=min(round(LONGER * config.iterations), MAX_COUNT))
    is_rich = goal.gzip or goal.limit[1] > RICH_BYTES * pixel_count
    is_free = not goal.keeps_segments and config.segments == MINIFIED["segments"]
    return replace(config, segments=RICH_SEGMENTS) if config.minify and is_rich and is_free else config


def first_count(goal: Goal, config: FitConfig) -> int:
    """Return a guess at the number of paths, which the fit corrects."""
    assert goal.limit is not None
    head, path, number = SHORT_BYTES if config.minify else LONG_BYTES
    share = GZIP_SHARE if goal.gzip else 1.0
    count = (goal.limit[1] / share - head) / (path + 6 * config.segments * number)
    return max(1, min(round(count), config.curves))
