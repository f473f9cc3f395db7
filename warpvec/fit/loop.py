"""The fit: render, compare, step, and let a policy change the population."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit import schedule
from warpvec.fit.interrupt import noted_interrupts
from warpvec.fit.min_area import SmallPaths
from warpvec.fit.palette import START as PALETTE_START
from warpvec.fit.palette import Palette
from warpvec.fit.policies.prefixes import with_prefix
from warpvec.fit.policies.registry import going_on, make_policy
from warpvec.fit.population import Population
from warpvec.fit.progress import FitResult, Progress, history_entry
from warpvec.fit.regularization import Regularization
from warpvec.fit.state import Saving, State
from warpvec.fit.target import Target
from warpvec.geometry.scene import Scene
from warpvec.image.alpha import is_transparent
from warpvec.rendering.launch import resolve_device

__all__ = ["FitResult", "Progress", "fit"]

# Of the target's sides in the coarse part of a run.
_REDUCTION = 2
# Iterations between entries of the history; each reads one number back, for which a GPU's queue runs empty.
_HISTORY_GAP, _HISTORY_GAP_CUDA = 10, 50


def fit(
    target: Tensor,
    config: FitConfig,
    on_progress: Callable[[Progress], None] | None = None,
    *,
    start: Scene | None = None,
    resume: State | None = None,
    saving: Saving | None = None,
) -> FitResult:
    """Fit paths to ``target`` [h, w, 3], sRGB-encoded in [0, 1], or [h, w, 4] with straight alpha.

    Paths for a target with alpha have no canvas under them, and the error is the mean of those over black and white.
    ``on_progress`` is called after every iteration. A KeyboardInterrupt ends the fit and gives the best scene so far.

    Args:
        start: paths to begin with, in pixels of the target; grown to ``config.curves`` or, where they are more, cut
            down to the most important ones.
        resume: the state of an earlier fit of the same target with the same settings, to go on from.
        saving: when and where to leave such states.

    Raises:
        InputError: the device does not exist, the policy needs what is not installed, or ``start`` is not of the
            model of ``config``.
    """
    device = resolve_device(config.device)
    with _single_torch_thread(), torch.no_grad(), noted_interrupts() as interrupted:
        settings = config if resume is None else FitConfig(**resume["config"])
        run = _Fit(target, settings, device, on_progress, start)
        if resume is not None:
            run.restore(resume)
        run.saving = saving
        try:
            run.iterate(interrupted)
        except KeyboardInterrupt:
            run.interrupted = True
        return run.result()


@contextmanager
def _single_torch_thread() -> Iterator[None]:
    """Torch's sums depend on its thread count, results must not; the kernels bring their own threads."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(before)


class _Fit:
    """The state of one run of the loop."""

    def __init__(
        self,
        target: Tensor,
        config: FitConfig,
        device: str,
        on_progress: Callable[[Progress], None] | None,
        start: Scene | None,
    ) -> None:
        self._device, self._on_progress = device, on_progress
        self._height, self._width = target.shape[:2]
        self._config = config = config if start is None else going_on(config, start, self._height, self._width)
        self._target = target.to(device, torch.float32)
        first_generation = int(start.generation.max()) if start is not None and len(start) else 0
        self._full = Target(self._target, config, device)
        self._policy = make_policy(self._target, config, first_generation, self._full)
        self._canvas = Target(self._target, config, device, _REDUCTION) if config.coarse_until > 0 else self._full
        if is_transparent(target):
            # Soft alpha is made of translucent paths.
            config = replace(config, opacity_weight=0.0)
        self._regularization = Regularization(self._height, self._width, config, device, config.point_degree)
        self._small_paths = SmallPaths(self._full, config)
        self._start = time.perf_counter()
        self._iteration = 0
        self._iteration_count = config.iterations
        self._first_seconds = 0.0
        self._loss = torch.zeros(())
        self._best: tuple[float, Scene] | None = None
        self._history_gap = _HISTORY_GAP if device == "cpu" else _HISTORY_GAP_CUDA
        self.history: list[dict[str, float]] = []
        self.interrupted = False
        self.saving: Saving | None = None
        first = self._first_paths() if start is None else self._most_important(start)
        self._population = Population(self._on_canvas(first), config, max(self._height, self._width) / 2)
        has_palette = config.palette is not None or config.colors > 0
        self._palette = Palette(config, self._height * self._width) if has_palette else None

    def iterate(self, interrupted: Callable[[], bool]) -> None:
        """Run the loop to its end, or until ``interrupted()``."""
        while self._iteration < self._iteration_count:
            if interrupted():
                raise KeyboardInterrupt
            self._choose_canvas()
            self._order()
            removal_cost = self._step(self._policy.wants_removal_cost(self._iteration + 1, self._iteration_count))
            self._iteration += 1
            self._iteration_count = self._planned_iterations()
            last = self._iteration == self._iteration_count
            if last:
                self._order()
            self._report()
            if not last:  # new paths would stay as they are spawned
                self._change_population(removal_cost)
                self._save()

    def result(self) -> FitResult:
        """The scene as it stands, or the best one before the last change of population if that was better."""
        if self._palette is not None and not self._population.has_palette:  # interrupted before, or over at once
            self._take_palette(self._palette)
        scene, loss = self._population.scene, float(self._loss)
        if self.interrupted and self._best is not None and self._best[0] < loss:
            scene = self._best[1]
        return FitResult(scene.cpu(), self.history, self._iteration, self._seconds(), self.interrupted, self._device)

    def _step(self, want_removal_cost: bool) -> Tensor | None:
        """Render, loss, adjoint, update; gives each path's removal cost if that was asked for."""
        scene, config = self._population.live, self._config
        adjoints = self._canvas.fit_step(scene, want_removal_cost)
        if config.lod:
            adjoints = with_prefix(adjoints, scene, self._canvas, self._iteration)
        adj_opacity = adjoints.opacity.contiguous()
        self._regularization.add_adjoint(scene.points, scene.opacity, adjoints.points, adj_opacity)
        factor = schedule.lr_factor(self._iteration, config, self._iteration_count)
        self._step_palette(adjoints, factor)
        values = (adjoints.points, adjoints.color, adj_opacity, adjoints.background)
        self._population.step(*values, factor, self._canvas.fits)
        self._loss = adjoints.loss
        return adjoints.removal_cost if want_removal_cost else None

    def _choose_canvas(self) -> None:
        """The full size, once the coarse part of the run is over; errors on the two do not compare."""
        if self._canvas is not self._full and self._iteration >= self._config.coarse_until * self._iteration_count:
            self._canvas, self._best = self._full, None

    def _step_palette(self, adjoints: Any, factor: float) -> None:
        """Fills from the palette, once the paths have found their places."""
        palette, population = self._palette, self._population
        if palette is None or self._iteration < PALETTE_START * self._iteration_count:
            return
        if not population.has_palette:
            self._take_palette(palette)
        else:
            shown = self._full.visible_areas(population.live) if palette.is_switching() else None
            palette.step(torch.cat([adjoints.color, adjoints.background[None]]), shown, factor)

    def _take_palette(self, palette: Palette) -> None:
        self._best = None  # it has any fills
        self._population.use_palette(palette, self._full.visible_areas(self._population.live))

    # The state

    def state(self) -> State:
        """Everything that decides what the next iterations do, and what the fit reports."""
        best = None if self._best is None else {"loss": self._best[0], "scene": self._best[1].to_dict()}
        return {
            "config": self._config.to_dict(),
            "iteration": self._iteration,
            "iteration_count": self._iteration_count,
            "seconds": self._seconds(),
            "first_seconds": self._first_seconds,
            "loss": self._loss,
            "best": best,
            "coarse": self._canvas is not self._full,
            "history": self.history,
            "policy": self._policy.state(),
            "population": self._population.state(),
        }

    def restore(self, state: State) -> None:
        """Go on from ``state``."""
        self._iteration, self._iteration_count = state["iteration"], state["iteration_count"]
        self._start, self._first_seconds = time.perf_counter() - state["seconds"], state["first_seconds"]
        self._loss = state["loss"].to(self._device)
        best = state["best"]
        self._best = None if best is None else (best["loss"], Scene(**best["scene"]).to(self._device))
        self._canvas = self._canvas if state["coarse"] else self._full
        self.history = list(state["history"])
        self._policy.restore(state["policy"])
        self._population.restore(state["population"], self._palette)

    def _save(self) -> None:
        if self.saving is not None and self._iteration % self.saving.every == 0:
            self.saving.save(self.state())

    # Population

    def _first_paths(self) -> Scene:
        learned = self._config.backdrop == "learned"
        return self._policy.first_paths(self._target[..., :3].mean((0, 1)) if learned else self._target.new_ones(3))

    def _on_canvas(self, scene: Scene) -> Scene:
        """``scene`` without a canvas of its own if the target has none."""
        if is_transparent(self._target):
            return replace(scene, background=torch.zeros_like(scene.background), transparent=True)
        return replace(scene, transparent=False)

    def _most_important(self, scene: Scene) -> Scene:
        """The N paths of ``scene`` whose removal would cost most; all of them if they are no more."""
        scene = scene.to(self._device)
        if len(scene) <= self._config.curves:
            return scene
        removal_cost = self._full.fit_step(scene, True).removal_cost
        return scene.select(removal_cost.topk(self._config.curves).indices.sort().values)

    def _change_population(self, removal_cost: Tensor | None) -> None:
        before = self._population.live
        iteration, iterations = self._iteration, self._iteration_count
        cut = self._small_paths.cut(self._population, iteration, iterations)
        # Costs of removal are of the paths before a cut.
        removal_cost = None if cut else self._small_paths.prefer(self._population, removal_cost)
        if self._policy.update(self._population, iteration, iterations, removal_cost, self._full.squared_error) or cut:
            self._remember(before)

    def _order(self) -> None:
        if self._config.z_order == "area":
            self._population.sort_by_area()

    # Bookkeeping

    def _remember(self, scene: Scene) -> None:
        """Keep the scene before its population changed, in case the fit is interrupted before it recovers."""
        loss = float(self._loss)
        if self._best is None or loss < self._best[0]:
            self._best = (loss, scene)

    def _report(self) -> None:
        progress = Progress(
            self._iteration,
            self._iteration_count,
            len(self._population),
            self._seconds(),
            self._loss,
            lambda: self._population.scene,
        )
        if self._iteration % self._history_gap == 0 or self._iteration == self._iteration_count:
            self.history.append(history_entry(progress))
        if self._on_progress is not None:
            self._on_progress(progress)

    def _planned_iterations(self) -> int:
        """The iterations that the settings ask for, or fewer if the time budget allows no more at the pace so far."""
        wanted, budget = self._config.iterations, self._config.time_budget
        if budget is None:
            return wanted
        if self._iteration == 1:
            # It may have compiled kernels, and tells nothing of the pace.
            self._first_seconds = self._seconds()
            return wanted if self._first_seconds < budget else 1
        pace = (self._seconds() - self._first_seconds) / (self._iteration - 1)
        return min(wanted, self._iteration + max(0, int((budget - self._seconds()) / pace)))

    def _seconds(self) -> float:
        return time.perf_counter() - self._start
