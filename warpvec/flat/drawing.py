"""The stages from a picture of flat art to a drawing of few clean paths, with their time, interrupts and progress."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.polish import polish
from warpvec.fit.progress import FitResult, OnProgress, Progress
from warpvec.fit.target import Target
from warpvec.flat.regions import AREA_MIN, Regions, find_regions
from warpvec.flat.scene_building import scene_of
from warpvec.flat.simplify import simplify
from warpvec.geometry.gradients import FLAT
from warpvec.geometry.scene import Scene

FIRST_ITERATIONS, LAST_ITERATIONS = 60, 60
"""Iterations of the fit of the traced outlines, and of that of the simplified ones."""

SNAP = 2.5 / 255.0
"""A fitted colour that differs by less in every channel from what the inside of its region shows is that colour:
white stays #fff."""

WORTHLESS = 15.0
"""A path is dropped if the squared error, summed over channels, rises by less than this many times ``detail`` squared
per segment. The simplification pays up to 50 for a segment of full contrast; a path also costs its colour."""

REMOVAL_SHARE = 0.25
"""Largest share of the surplus paths that one round removes. The rest are valued again without them."""

REMOVED_MIN = 4
"""Fewest paths that one round removes, if so many are to go."""


@dataclass
class FlatDrawing:
    """The work on one picture of flat art.

    Attributes:
        image: the picture [h, w, 3 or 4], sRGB-encoded in [0, 1], with straight alpha if it has four channels.
        config: settings of the run; ``time_budget`` is for all of it.
        on_progress: called after every iteration of a fit.
        is_interrupted: says whether Ctrl-C asks for the best result so far.
        regions: the regions of the picture, once they are found.
    """

    image: Tensor
    config: FitConfig
    on_progress: OnProgress | None = None
    is_interrupted: Callable[[], bool] = bool
    regions: Regions | None = None
    _traced: Scene | None = None
    _history: list[dict[str, float]] = field(default_factory=list)
    _iterations: int = 0
    _planned: int = FIRST_ITERATIONS + LAST_ITERATIONS
    _begin: float = field(default_factory=time.perf_counter)

    def outlined(self) -> Scene:
        """Return the outlines of the regions, with more nodes than they need, fitted to the picture."""
        self.regions = find_regions(self.image.numpy(), max(AREA_MIN, self.config.min_area))
        traced = scene_of(self.regions)
        # Numbered, so that a path that stays finds its colour again.
        self._traced = replace(traced, generation=torch.arange(len(traced)))
        fewer = with_fewer_paths(self._traced, self.image, self.config, self.config.curves)
        return self._polished(fewer, FIRST_ITERATIONS)

    def simplified(self, outlined: Scene, detail: float) -> Scene:
        """Return a scene of `outlined` with the nodes and paths that show at ``detail`` pixels, fitted again."""
        if self.is_over():
            return self._snapped(outlined)
        kept = without_worthless(outlined, self.image, self.config, detail)
        simple = simplify(kept, self.image, self._timed_config(), detail).scene
        return self._snapped(self._polished(simple, LAST_ITERATIONS))

    def result(self, scene: Scene) -> FitResult:
        """Return ``scene`` with the facts about the fits so far."""
        interrupted = self.is_interrupted()
        return FitResult(scene, self._history, self._iterations, self.seconds(), interrupted, "cpu")

    def is_over(self) -> bool:
        """Return whether Ctrl-C or the time budget asks for the best result so far."""
        budget = self.config.time_budget
        return self.is_interrupted() or (budget is not None and self.seconds() >= budget)

    def seconds(self) -> float:
        """Return the seconds since the work began."""
        return time.perf_counter() - self._begin

    def plan(self, count: int) -> None:
        """Announce so many calls of `simplified` in all, for the progress."""
        self._planned = FIRST_ITERATIONS + count * LAST_ITERATIONS

    def _polished(self, scene: Scene, iterations: int) -> Scene:
        if not len(scene):
            return scene
        first, count = self._iterations, min(iterations, self.config.iterations)
        begin = self.seconds()

        def report(progress: Progress) -> None:
            if self.on_progress is not None:
                planned = max(self._planned, first + progress.iteration_count)
                number, seconds = first + progress.iteration, begin + progress.seconds
                self.on_progress(replace(progress, iteration=number, iteration_count=planned, seconds=seconds))

        found = polish(self.image, scene, self._timed_config(), report, iterations=count)
        for entry in found.history:
            shifted = {"iteration": entry["iteration"] + first, "seconds": entry["seconds"] + begin}
            self._history.append({**entry, **shifted})
        self._iterations += found.iterations
        return found.scene

    def _snapped(self, scene: Scene) -> Scene:
        """Return ``scene`` with the colours of the regions where the fitted ones hardly differ."""
        assert self._traced is not None
        color = self._traced.color[scene.generation]
        is_near = (scene.color - color).abs().amax(1) <= SNAP
        if scene.gradients is not None:
            is_near &= scene.gradients.kind == FLAT
        canvas = self._traced.background
        background = canvas if bool((scene.background - canvas).abs().amax() <= SNAP) else scene.background
        return replace(scene, color=torch.where(is_near[:, None], color, scene.color), background=background)

    def _timed_config(self) -> FitConfig:
        budget = self.config.time_budget
        return self.config if budget is None else replace(self.config, time_budget=max(budget - self.seconds(), 1e-3))


def without_worthless(scene: Scene, image: Tensor, config: FitConfig, detail: float) -> Scene:
    """Return ``scene`` without the paths that cost more than they show at ``detail`` pixels, the least first."""
    price = WORTHLESS * detail**2
    while len(scene):
        cost = removal_costs(scene, image, config)
        worth = cost / (price * scene.structure.path_first_segment.diff())
        doomed = int((worth < 1.0).sum())
        if not doomed:
            return scene
        scene = _without(scene, worth, _removed_at_once(doomed))
    return scene


def with_fewer_paths(scene: Scene, image: Tensor, config: FitConfig, count: int) -> Scene:
    """Return the ``count`` paths of ``scene`` that matter most, the removal costs counted again as paths go."""
    while len(scene) > count:
        surplus = len(scene) - count
        scene = _without(scene, removal_costs(scene, image, config), min(surplus, _removed_at_once(surplus)))
    return scene


def removal_costs(scene: Scene, image: Tensor, config: FitConfig) -> Tensor:
    """Return the rise of the squared error, summed over pixels and channels, without each path [N]."""
    target = Target(image, config, "cpu")
    with torch.no_grad():
        return target.fit_step(scene, True).removal_cost / target.error_scale


def _removed_at_once(surplus: int) -> int:
    return max(REMOVED_MIN, round(REMOVAL_SHARE * surplus))


def _without(scene: Scene, worth: Tensor, count: int) -> Scene:
    """Return ``scene`` without its ``count`` paths of least ``worth`` [N]."""
    kept = worth.topk(max(len(scene) - count, 0)).indices.sort().values
    return scene.select(kept)
