"""Fit paths to an image: render, compare, step, and let a policy add and remove paths."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit import schedule
from warpvec.fit.budget import ANY_FILE, Written, is_trim_due
from warpvec.fit.chain import Chain, can_chain
from warpvec.fit.clock import Clock
from warpvec.fit.loop_state import check_loop
from warpvec.fit.min_area import SmallPaths
from warpvec.fit.node_exchange import NodeExchange
from warpvec.fit.opacity_columns import OpacityColumns
from warpvec.fit.palette import START as PALETTE_START
from warpvec.fit.palette import Palette, with_pure_colors
from warpvec.fit.path_models import path_model
from warpvec.fit.policies.prefixes import prefix_length, with_prefix
from warpvec.fit.policies.registry import config_from_start, config_from_state, make_policy
from warpvec.fit.policies.scaffolding import Scaffolding
from warpvec.fit.population import Population, do_nothing
from warpvec.fit.population_state import check_scene
from warpvec.fit.population_step import CHAIN_MAX
from warpvec.fit.ramps import GradientChoice
from warpvec.fit.record import FitRecord, check_history
from warpvec.fit.start import first_paths, given_paths
from warpvec.fit.state import Saving, State
from warpvec.fit.state_form import row_count
from warpvec.fit.target import OutlineStep, Target
from warpvec.fit.written_grid import WrittenGrid
from warpvec.geometry.scene import Scene
from warpvec.image.alpha import is_transparent
from warpvec.rendering.launch import resolve_device
from warpvec.rendering.streams import on_warps_stream
from warpvec.rendering.tile_renderer import Adjoints
from warpvec.watch.progress import Progress
from warpvec.watch.watch import FitResult, Part, Watch


def fit(
    target: Tensor,
    config: FitConfig,
    part: Part | None = None,
    *,
    start: Scene | None = None,
    resume: State | None = None,
    saving: Saving | None = None,
    written: Written = ANY_FILE,
) -> FitResult:
    """Fit paths to ``target`` [h, w, 3], sRGB-encoded in [0, 1], or [h, w, 4] with straight alpha.

    For a target with alpha there is no canvas under the paths, and the loss is the mean of the losses over a black and
    a white matte. A KeyboardInterrupt ends the fit, which then returns the best scene so far.

    Args:
        target: the image to fit.
        config: the settings of the fit.
        part: the part of a run that this fit is; None for a run of its own.
        start: paths to begin with, in pixels of the target. If there are fewer than ``config.curves``, the fit adds
            paths; if there are more, it keeps those with the highest removal cost.
        resume: the state of an earlier fit of the same target with the same settings, to continue.
        saving: how often such states are saved, and where.
        written: what the file asks of the paths.

    Raises:
        InputError: the device does not exist, ``start`` does not have the path model of ``config``, or ``resume`` is no
            state of this fit.
    """
    device = resolve_device(config.device)
    part = Watch(time_budget=config.time_budget).part() if part is None else part
    with on_warps_stream(device), single_torch_thread(), torch.no_grad(), part:
        settings = config if resume is None else config_from_state(config, resume, *target.shape[:2])
        run = _Fit(target, settings, device, part, start, saving, written)
        if resume is not None:
            run.check(resume)
            run.restore(resume)
        try:
            run.iterate()
        except KeyboardInterrupt:
            part.interrupted = True
        return part.result(run.scene(), device)


@contextmanager
def single_torch_thread() -> Iterator[None]:
    """Run torch on one thread: its sums depend on the number of threads, and results must not."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(before)


class _Fit:
    """One run of the loop."""

    def __init__(
        self,
        image: Tensor,
        config: FitConfig,
        device: str,
        part: Part,
        start: Scene | None,
        saving: Saving | None,
        written: Written,
    ) -> None:
        self._height, self._width = height, width = image.shape[:2]
        self._device, self._part = device, part
        self._saving, self._budget = saving, written.budget
        self._grid = None if written.step is None else WrittenGrid(written.step)
        self._config = config = config if start is None else config_from_start(config, start, height, width)
        self._image = image.to(device, torch.float32)
        self._target = Target(self._image, config, device)
        first_generation = int(start.generation.max()) if start is not None and len(start) else 0
        self._policy = make_policy(self._image, config, first_generation, self._target)
        if is_transparent(image):
            # Soft alpha needs translucent paths.
            config = replace(config, opacity_weight=0.0)
        self._regularization = path_model(config).regularizer(height, width, config, device)
        self._small_paths = SmallPaths(self._target, config)
        self._gradients = GradientChoice(self._target, config)
        self._nodes = NodeExchange(config, start)
        self._clock = Clock(config.iterations, part, device)
        self._iteration = 0
        self._iteration_count = config.iterations
        self._steps_before = 0  # iterations that the paths' own counts lack
        self._seen_steps = 0  # of which the host has seen that they changed the paths
        self._loss = torch.zeros(())
        self._outlines: OutlineStep | None = None
        self._followed: Scene | None = None  # by which the target was shifted last
        self._record = FitRecord(config.iterations, device)
        if start is None:
            first = first_paths(self._image, config, self._policy)
        else:
            first = given_paths(self._image, config, self._target, start)
        has_room = can_chain(config, self._target, self._regularization, self._grid is not None)
        sides = (width / 2.0, height / 2.0)
        self._population = Population(first, config, max(sides), self._grid, sides, has_room=has_room)
        self._columns = OpacityColumns(device)
        self._chain = Chain(config, self._target, self._population, self._regularization)
        has_palette = config.palette is not None or config.colors > 0
        self._palette = Palette(config, height * width) if has_palette else None

    def iterate(self) -> None:
        """Run the loop to its end; raise KeyboardInterrupt once the user asks for the best result so far."""
        self._steps_before = self._iteration - self._population.step_count
        self._population.before_use = self._take_dropped_steps
        try:
            self._iterate()
        finally:  # a cycle of references would keep the memory of a GPU until Python looks for cycles
            self._population.before_use = do_nothing

    def _iterate(self) -> None:
        while self._iteration < self._iteration_count:
            if self._part.is_stopped():
                raise KeyboardInterrupt
            self._sort()
            if self._grid is not None:
                self._grid.begin(self._iteration, self._iteration_count)
            removal_cost = self._advance()
            self._iteration_count = self._clock.planned_iterations(self._iteration)
            is_last = self._iteration == self._iteration_count
            if is_last:
                self._sort()
            self._report()
            if not is_last:  # paths added now would never be fitted
                self._follow()
                self._change_population(removal_cost)
                self._save()

    def _advance(self) -> Tensor | None:
        """Take the next step, or all up to the next look of the host; return removal costs if the step wants them."""
        iteration, count, removal_cost = self._iteration, self._iteration_count, None
        self._outlines = None
        chained = self._clock.steps_to_look(self._chain_length())
        if chained:
            self._loss, chained = self._chain.take(iteration, chained, count)
        else:
            self._policy.look(self._population, iteration + 1, count, self._squared_error)
            wants_removal_cost, wants_outlines = self._wants(iteration + 1)
            removal_cost = self._step(iteration, wants_removal_cost, wants_outlines)
        self._iteration += max(chained, 1)
        return removal_cost

    def _wants(self, iteration: int) -> tuple[bool, bool]:
        """Return whether ``iteration``, of which 1 is the first, needs removal costs, and figures along outlines."""
        count = self._iteration_count
        wants_cost = self._policy.wants_removal_cost(iteration, count) or self._is_trimming(iteration)
        return wants_cost, schedule.is_exchanging_nodes(iteration, self._config, count)

    def _chain_length(self) -> int:
        """Return how many of the next steps can be one chain, after which the host may look; 0 for a step by itself."""
        if self._population.padded is None:
            return 0
        end = min(self._iteration + CHAIN_MAX, self._iteration_count)
        for iteration in range(self._iteration + 1, end + 1):
            if any(self._wants(iteration)) or self._policy.looks_before(iteration, self._iteration_count):
                return iteration - 1 - self._iteration
            if self._is_looking(iteration):
                return iteration - self._iteration
        return end - self._iteration

    def _is_looking(self, iteration: int) -> bool:
        """Return whether the host has something to do after ``iteration``: a report, a shift, new paths, a state."""
        is_due = self._record.is_check_due(iteration) or schedule.shifts_target(iteration, self._config)
        is_due = is_due or self._policy.is_due(iteration, self._iteration_count)
        is_due = is_due or self._small_paths.is_due(iteration, self._iteration_count)
        return is_due or (self._saving is not None and iteration % self._saving.every == 0)

    def scene(self) -> Scene:
        """Return the present scene, or a better one before the last change of the population.

        Only an interrupted fit may not have become better since that change.
        """
        self._take_dropped_steps()
        if self._palette is not None and not self._population.has_palette:  # interrupted or over before it began
            self._take_palette(self._palette)
        scene, loss = self._population.scene, float(self._loss)
        if self._part.interrupted and (before := self._record.better_than(loss)) is not None:
            scene = before
        return with_pure_colors(scene, self._image) if self._config.colors > 0 else scene

    def _step(self, iteration: int, want_removal_cost: bool, want_outlines: bool = False) -> Tensor | None:
        """Render, differentiate the loss and update the paths; return each path's removal cost [N] on request."""
        scene, config = self._population.live, self._config
        takes_palette = self._takes_palette(iteration)
        wanted = (want_removal_cost, want_outlines)
        if any(wanted) or takes_palette:
            self._take_dropped_steps(iteration)
        adjoints = self._differentiate(iteration, *wanted)
        if takes_palette and self._target.has_dropped():  # the palette cannot leave a step out
            self._target.make_room()
            adjoints = self._differentiate(iteration, *wanted)
        adj_opacity = self._columns.joined(adjoints.opacity.contiguous(), adjoints.side_opacity)
        self._regularization.add_adjoint(scene, adjoints.segments, adj_opacity)
        factor = schedule.lr_factor(iteration, config, self._iteration_count)
        if takes_palette:
            self._step_palette(adjoints, factor)
        values = (adjoints.segments, adjoints.color, adj_opacity, adjoints.background)
        self._population.step(*values, factor, self._target.fits)
        if adjoints.end_color is not None and adjoints.geometry is not None:
            self._population.step_gradients(adjoints.end_color, adjoints.geometry, factor, self._target.fits)
        self._loss = adjoints.loss
        if any(wanted):  # the host has looked, so this step has changed the paths
            self._seen_steps = iteration + 1
        return adjoints.removal_cost if want_removal_cost else None

    def _differentiate(self, iteration: int, want_removal_cost: bool, want_outlines: bool) -> Adjoints:
        scene, padded = self._population.live, self._population.padded
        if want_removal_cost and padded is not None and not want_outlines:
            adjoints = self._target.removal_step(padded, scene)
        elif want_outlines:
            adjoints, self._outlines = self._target.outline_step(scene)
        else:
            adjoints = self._target.fit_step(scene, want_removal_cost)
        if not self._config.lod:
            return adjoints
        count = prefix_length(self._population.prefix_counts, iteration)
        return with_prefix(adjoints, scene, self._target, count)

    def _take_dropped_steps(self, end: int | None = None) -> None:
        """Take the steps before ``end`` again that changed nothing because the renderer had no room for the paths.

        The renderer drops a recorded step together with all steps after it, so the paths are unchanged since. The
        repeated steps give the same result as steps with enough room.
        """
        if self._target.fits is None:
            return
        end = self._iteration if end is None else end
        if end <= self._seen_steps:
            return
        while (taken := self._steps_before + self._population.step_count) < end:
            self._target.make_room()
            while taken < end:
                chained = min(end - taken, CHAIN_MAX) if self._population.padded is not None else 0
                if chained:
                    self._loss, chained = self._chain.take(taken, chained, self._iteration_count)
                else:
                    self._step(taken, False)
                taken += max(chained, 1)
        self._seen_steps = end

    # Palette

    def _takes_palette(self, iteration: int) -> bool:
        """Return whether fills come from a palette from ``PALETTE_START`` on, and that is reached."""
        return self._palette is not None and iteration >= PALETTE_START * self._iteration_count

    def _step_palette(self, adjoints: Adjoints, factor: float) -> None:
        """Take fills from the palette, and step the palette from then on."""
        palette, population = self._palette, self._population
        assert palette is not None
        if not population.has_palette:
            self._take_palette(palette)
        else:
            visible_area = self._target.visible_areas(population.live) if palette.is_switching() else None
            palette.step(torch.cat([adjoints.color, adjoints.background[None]]), visible_area, factor)

    def _take_palette(self, palette: Palette) -> None:
        self._record.forget()  # its fills are not from the palette
        self._population.use_palette(palette, self._target.visible_areas(self._population.live))

    # State

    def state(self) -> State:
        """Return everything that decides the next iterations and what the fit reports."""
        return {
            **self._record.state(),
            "history": self._part.history,
            "config": self._config.to_dict(),
            "iteration": self._iteration,
            "iteration_count": self._iteration_count,
            "seconds": self._part.seconds(),
            "first_seconds": self._clock.first_seconds,
            "loss": self._loss,
            "followed": None if self._followed is None else self._followed.to_dict(),
            "policy": self._policy.state(),
            "nodes": self._nodes.state(),
            "population": self._population.state(),
        }

    def check(self, state: State) -> None:
        """Raise InputError unless :meth:`state` can have returned ``state`` in a fit with these settings."""
        check_loop(state, self._config)
        iteration, curves = state["iteration"], self._config.curves
        check_history(state["history"], iteration, state["seconds"], curves)
        count = row_count("population", state["population"], "serial", curves)
        generation_max = self._policy.check(state["policy"], iteration, count)
        self._nodes.check(state["nodes"])
        self._population.check(state["population"], self._palette, iteration, count, generation_max)
        kept = {"best.scene": state["best"] and state["best"]["scene"], "followed": state["followed"]}
        for name, scene in kept.items():
            if scene is not None:
                kept_count = row_count(name, scene, "color", curves)
                check_scene(name, scene, self._population.live, kept_count, generation_max)

    def restore(self, state: State) -> None:
        """Continue from ``state``, which :meth:`check` has accepted."""
        self._iteration, self._iteration_count = state["iteration"], state["iteration_count"]
        self._part.resume(state["seconds"], self._iteration, state["history"])
        self._clock.first_seconds = state["first_seconds"]
        self._loss = state["loss"].to(self._device)
        if state["followed"] is not None:
            self._followed = Scene.from_dict(state["followed"]).to(self._device)
            self._target.follow(self._followed, self._config.ssim_weight)
        self._record.restore(state)
        self._policy.restore(state["policy"])
        self._nodes.restore(state["nodes"])
        self._population.restore(state["population"], self._palette)

    def _save(self) -> None:
        if self._saving is not None and self._iteration % self._saving.every == 0:
            self._take_dropped_steps()
            self._saving.save(self.state())

    def _follow(self) -> None:
        """Shift the target anew for the structural similarity of the present scene, if that is due."""
        if schedule.shifts_target(self._iteration, self._config):
            self._followed = self._population.scene
            self._target.follow(self._followed, self._config.ssim_weight, self._population.padded)

    # Population

    def _change_population(self, removal_cost: Tensor | None) -> None:
        # An arena's memory is overwritten by what comes.
        before = self._population.live if self._population.padded is None else self._population.live.copied()
        iteration, iterations = self._iteration, self._iteration_count
        has_exchanged = self._outlines is not None and self._nodes.update(self._population, *self._outlines)
        has_cut = self._small_paths.cut(self._population, iteration, iterations)
        # The removal costs do not belong to the paths that a cut leaves.
        removal_cost = None if has_cut else self._small_paths.prefer(self._population, removal_cost)
        if self._budget is not None and removal_cost is not None:
            if self._is_trimming(self._iteration):
                has_cut = self._budget.trim(self._population, removal_cost, float(self._loss))
                removal_cost = None
            elif isinstance(self._policy, Scaffolding):
                count = self._budget.wanted_count(self._population.live, float(self._loss), iteration, iterations)
                self._policy.resize(count, len(self._population))
        has_changed = self._policy.update(self._population, iteration, iterations, removal_cost, self._squared_error)
        self._gradients.update(self._population, iteration, iterations, has_changed or has_cut)
        if has_changed or has_cut or has_exchanged:
            self._record.remember(float(self._loss), before)

    def _squared_error(self, scene: Scene) -> Tensor:
        """Return the squared error [h, w] of ``scene``: all paths that are there, which an arena has too, or some."""
        padded = self._population.padded
        is_whole = scene is padded or len(scene) == len(self._population)
        return self._target.squared_error(scene, padded if is_whole else None)

    def _is_trimming(self, iteration: int) -> bool:
        """Return whether paths that are too many for the file are removed after ``iteration``."""
        return self._budget is not None and is_trim_due(iteration, self._iteration_count)

    def _sort(self) -> None:
        if self._config.z_order == "area":
            self._population.sort_by_area()

    # Bookkeeping

    def _report(self) -> None:
        iteration, count = self._iteration, self._iteration_count
        if iteration == count or self._record.is_check_due(iteration):
            self._take_dropped_steps()
        population = self._population
        progress = Progress(
            iteration, count, len(population), self._part.seconds(), self._loss, lambda: population.scene
        )
        self._part.report(progress, is_entry=self._record.is_entry_due(iteration, count))
