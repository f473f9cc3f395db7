"""The fits of a photo: one with the given settings, one that follows a goal, or a search of several."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import torch
from numpy.typing import NDArray

from warpvec.config.fit_config import FitConfig
from warpvec.fit.byte_budget import Budget, Written
from warpvec.fit.interrupt import deferred_interrupts
from warpvec.fit.loop import fit
from warpvec.fit.progress import OnProgress, no_fit
from warpvec.fit.psnr_budget import PsnrBudget
from warpvec.fit.state import Saving, State
from warpvec.flat.classify import Choice
from warpvec.geometry.scene import Scene
from warpvec.vectorization.byte_fit import budget_of, can_fit_once, first_count, settings_for_bytes, within_bytes
from warpvec.vectorization.file_options import FileOptions
from warpvec.vectorization.goal import Goal
from warpvec.vectorization.minified_form import minified_form
from warpvec.vectorization.result import Result
from warpvec.vectorization.search import Search, can_follow_psnr


@dataclass(frozen=True)
class PhotoFit:
    """A photo, and all that its fits have in common.

    Attributes:
        photo: [h, w, 3 or 4] at full size.
        target: the same, reduced to the size of the fit.
        config: the settings that the user has given.
        goal: requirements on the file; false for none.
        title: of the SVG, or None.
        file_options: choices about the file alone.
        choice: why the mode is that of photos; None if it was asked for.
        on_progress: called after every iteration.
        state: of an earlier fit, to continue from.
        saving: how often such states are saved, and where.
    """

    photo: NDArray[np.float32]
    target: NDArray[np.float32]
    config: FitConfig
    goal: Goal
    title: str | None
    file_options: FileOptions
    choice: Choice | None
    on_progress: OnProgress | None
    state: State | None
    saving: Saving | None

    def run(self, start: Scene | None) -> Result:
        """Fit the photo, from the paths ``start`` in pixels of the photo if there are any."""
        config, goal = self.config, self.goal
        first = None if start is None else start.scaled(*self._factors)
        if not goal:
            return self.once(config, first)
        if start is None and can_fit_once(goal, config):
            settings = settings_for_bytes(goal, config, self._size[0] * self._size[1])
            settings = replace(settings, curves=first_count(goal, settings))
            with deferred_interrupts() as is_interrupted:  # Ctrl-C after the fit must not lose it
                found = within_bytes(goal, self.once(settings, None), config.iterations)
                is_cut_short = is_interrupted() or found.interrupted
            return replace(found, fitted=replace(found.fitted, interrupted=is_cut_short))
        follow = self._to_psnr if can_follow_psnr(goal, config) else None
        return Search(goal, config, self.once, first, fit_to_psnr=follow).run()

    def once(self, settings: FitConfig, start: Scene | None) -> Result:
        """Fit once with ``settings``, from the paths ``start`` in pixels of the fit if there are any."""
        blank = self._blank(settings)
        budget = None if start is not None else budget_of(self.goal, self.config, blank)
        return self._fitted(blank, start, budget)

    def _to_psnr(self, settings: FitConfig, curves_max: int) -> Result:
        """Fit once with as many paths, up to ``curves_max``, as the PSNR of the goal takes."""
        assert self.goal.target_psnr is not None
        blank = self._blank(settings)
        return self._fitted(blank, None, PsnrBudget(self.goal.target_psnr, curves_max, blank.psnr_of))

    def _fitted(self, blank: Result, start: Scene | None, budget: Budget | None) -> Result:
        """Return ``blank`` with the scene of a fit, whose number of paths follows ``budget``."""
        across, down = self._factors
        reduced = replace(blank.config, min_area=blank.config.min_area * across * down)
        fitted = fit(
            torch.from_numpy(self.target),
            reduced,
            self.on_progress,
            start=start,
            resume=self.state,
            saving=self.saving,
            written=Written(blank.grid_step, budget),
        )
        return replace(blank, fitted=fitted)

    def _blank(self, settings: FitConfig) -> Result:
        """Return the result of a fit with ``settings`` before it has any paths."""
        photo_size = (self.photo.shape[0], self.photo.shape[1])
        form = minified_form(settings, photo_size, self._size, gzip=self.goal.gzip) if settings.minify else None
        return Result(
            self.photo,
            self._size,
            settings,
            no_fit(),
            self.title,
            file_options=self.file_options,
            form=form,
            choice=self.choice,
        )

    @property
    def _size(self) -> tuple[int, int]:
        """Height and width of the fit."""
        return self.target.shape[0], self.target.shape[1]

    @property
    def _factors(self) -> tuple[float, float]:
        """Width and height of the fit over those of the photo."""
        return self._size[1] / self.photo.shape[1], self._size[0] / self.photo.shape[0]
