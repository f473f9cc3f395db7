"""The stages from a picture of flat art to a drawing of few clean paths, with their time, interrupts and progress."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.polish import PATHS_EXACT_MAX, polish
from warpvec.fit.progress import FitResult, OnProgress, Progress
from warpvec.flat.curves.curve_fitting import TOLERANCE
from warpvec.flat.fewer_colors import with_colors, with_flat_paints, with_palette
from warpvec.flat.fewer_paths import with_fewer_paths
from warpvec.flat.regions.fewer_regions import with_fewer_regions
from warpvec.flat.regions.regions import Regions, find_regions
from warpvec.flat.scene_building import scene_of
from warpvec.flat.simplification.path_removal import remove_paths
from warpvec.flat.simplification.regularity import regularize
from warpvec.flat.simplification.simplify import VALUES_EXACT_MAX, simplify
from warpvec.geometry.gradients import FLAT
from warpvec.geometry.scene import Scene
from warpvec.image.colors import parse_color

FIRST_ITERATIONS, LAST_ITERATIONS = 8, 16
"""Iterations of the fit of the traced outlines, and of that of the simplified ones. With 60 and 60 the mean PSNR of
four pictures is 0.2 dB higher, for 1.3 times the time of the whole run."""

MANY_VALUES = 12_000
"""Coordinates of a drawing from which on each fit takes half as many iterations: a screenshot of 500 paths loses 0.2 dB
and takes a third of the time less."""

GRADIENT_STEPS = 6
"""Steps by gradients alone, with which large drawings are fitted, in place of each iteration."""

SMALL_SIDE, SMALL_TOLERANCE = 128, 0.14
"""Longer side of small pictures in pixels, and the largest distance in pixels of their traced outlines from the curves:
they are shown several times larger. The mean PSNR of icons at four times their size is 0.8 dB higher so."""

SNAP = 2.5 / 255.0
"""A fitted colour that differs by less in every channel from what the inside of its region shows is that colour:
white stays #fff."""


@dataclass
class FlatDrawing:
    """The work on one picture of flat art.

    Attributes:
        image: the picture [h, w, 3 or 4], sRGB-encoded in [0, 1], with straight alpha if it has four channels.
        config: settings of the run; ``time_budget`` is for all of it.
        on_progress: called after every iteration of a fit.
        is_interrupted: says whether Ctrl-C asks for the best result so far.
        may_refuse: whether to refuse a picture that is plainly no flat art; see `NotFlatArtError`.
        left_out: what the last drawing left out, by its name: "path", "loop" and "node".
    """

    image: Tensor
    config: FitConfig
    on_progress: OnProgress | None = None
    is_interrupted: Callable[[], bool] = bool
    may_refuse: bool = False
    left_out: dict[str, int] = field(default_factory=dict)
    _traced: Scene | None = None
    _outlined: Scene | None = None
    _history: list[dict[str, float]] = field(default_factory=list)
    _iterations: int = 0
    _begin: float = field(default_factory=time.perf_counter)

    def draw(self, detail: float) -> FitResult:
        """Return the drawing with the nodes and paths that show at ``detail`` pixels, and facts about all fits so far.

        The regions and their first outlines are found once.

        Raises:
            NotFlatArtError: the picture is plainly no flat art, and ``may_refuse``.
        """
        scene = self._outlines()
        if not self.is_over():
            removal = remove_paths(scene, self.image, self.config, detail, self.is_over)
            scene, self.left_out = removal.scene, {"path": removal.path_count, "loop": removal.loop_count}
        if len(scene) and not self.is_over():
            simplified = simplify(scene, self.image, self._timed_config(), detail, is_over=self.is_over)
            scene, self.left_out["node"] = simplified.scene, simplified.dropped
            scene = self._polished(scene, LAST_ITERATIONS)
            # Last, as a fit would undo exact circles and level lines.
            scene = regularize(scene, self.image, self._timed_config(), detail, self.is_over)
        history, interrupted = list(self._history), self.is_interrupted()
        return FitResult(self._snapped(scene), history, self._iterations, self.seconds(), interrupted, "cpu")

    def again(self, on_progress: OnProgress | None, is_interrupted: Callable[[], bool]) -> FlatDrawing:
        """Return new work on the same picture with the outlines that this one has found."""
        fresh = FlatDrawing(self.image, self.config, on_progress, is_interrupted)
        fresh._traced, fresh._outlined = self._traced, self._outlined
        return fresh

    def is_over(self) -> bool:
        """Return whether Ctrl-C or the time budget asks for the best result so far."""
        budget = self.config.time_budget
        return self.is_interrupted() or (budget is not None and self.seconds() >= budget)

    def seconds(self) -> float:
        """Return the seconds since the work began."""
        return time.perf_counter() - self._begin

    def _outlines(self) -> Scene:
        """Return the outlines of the regions, with more nodes than they need, fitted to the picture."""
        if self._outlined is None:
            found = find_regions(self.image.numpy(), self.config.min_area, self.is_over, self.may_refuse)
            regions = self._repainted(with_fewer_regions(found))
            tolerance = TOLERANCE if max(self.image.shape[:2]) >= SMALL_SIDE else SMALL_TOLERANCE
            traced = self._on_canvas(scene_of(regions, tolerance, is_over=self.is_over))
            # Numbered, so that a path that stays finds its colour again.
            self._traced = replace(traced, generation=torch.arange(len(traced)))
            fewer = with_fewer_paths(self._traced, self.image, self.config, self.config.curves)
            self._outlined = self._polished(fewer, FIRST_ITERATIONS)
        return self._outlined

    def _on_canvas(self, scene: Scene) -> Scene:
        """Return ``scene`` with a canvas if the picture is opaque: that of its lowest path if no region is one."""
        if not len(scene):  # tensors of no rows that come from NumPy have strides that kernels refuse
            scene = replace(scene, color=torch.zeros(0, 3), opacity=torch.zeros(0))
        if self.image.shape[2] == 4 or not scene.transparent:
            return scene
        background = scene.color[0] if len(scene) else torch.ones(3)
        return replace(scene, background=background.clone(), transparent=False)

    def _polished(self, scene: Scene, iterations: int) -> Scene:
        if not len(scene):
            return scene
        is_small = len(scene) <= PATHS_EXACT_MAX and scene.segments.numel() <= VALUES_EXACT_MAX
        if scene.segments.numel() > MANY_VALUES:
            iterations //= 2
        steps = iterations if is_small else GRADIENT_STEPS * iterations
        first, count = self._iterations, min(steps, self.config.iterations)
        begin = self.seconds()

        def report(progress: Progress) -> None:
            if self.on_progress is not None:
                planned = max(FIRST_ITERATIONS + LAST_ITERATIONS, first + count)
                number, seconds = first + progress.iteration, begin + progress.seconds
                self.on_progress(replace(progress, iteration=number, iteration_count=planned, seconds=seconds))

        found = polish(
            self.image, scene, self._timed_config(), report, iterations=count, values_exact_max=VALUES_EXACT_MAX
        )
        for entry in found.history:
            shifted = {"iteration": entry["iteration"] + first, "seconds": entry["seconds"] + begin}
            self._history.append({**entry, **shifted})
        self._iterations += found.iterations
        return found.scene

    def _repainted(self, regions: Regions) -> Regions:
        if self.config.opacity == "opaque":
            regions = replace(regions, opacity=np.where(regions.opacity >= 0.5, 1.0, 0.0).astype(np.float32))
        if self.config.palette is not None:
            palette = np.array([parse_color(name) for name in self.config.palette.split(",")], np.float64)
            return with_palette(regions, palette)
        if self.config.colors:
            return with_colors(regions, self.config.colors)
        return regions if self.config.gradients != 0.0 else with_flat_paints(regions)

    def _snapped(self, scene: Scene) -> Scene:
        """Return ``scene`` with the colours of the regions, where the fitted ones hardly differ or paths share one."""
        assert self._traced is not None
        color = self._traced.color[scene.generation]
        snap = math.inf if self.config.colors or self.config.palette else SNAP
        is_shared = (color[:, None] == color[None]).all(2).sum(1) > 1
        is_near = is_shared | ((scene.color - color).abs().amax(1) <= snap)
        if scene.gradients is not None:
            is_near &= scene.gradients.kind == FLAT
        canvas = self._traced.background
        background = canvas if bool((scene.background - canvas).abs().amax() <= snap) else scene.background
        return replace(scene, color=torch.where(is_near[:, None], color, scene.color), background=background)

    def _timed_config(self) -> FitConfig:
        budget = self.config.time_budget
        return self.config if budget is None else replace(self.config, time_budget=max(budget - self.seconds(), 1e-3))
