"""Reports of a fit: its progress while it runs, the time left, and its result."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import torch
from torch import Tensor

from warpvec.checks import counted
from warpvec.fit.state_form import Fields, Form, ListOf, Number, Whole, require
from warpvec.geometry.scene import Scene
from warpvec.image.metrics import psnr_from_mse

LOSS_MAX = 1.01
"""Largest mean squared error of values in [0, 1], with room for rounding."""

SECONDS_MAX = 1e9
"""Longest time of a fit, in seconds: 32 years."""


@dataclass(frozen=True)
class Progress:
    """The progress of a fit after an iteration."""

    iteration: int
    iteration_count: int
    curve_count: int
    seconds: float
    loss: Tensor = field(repr=False)
    scene: Callable[[], Scene] = field(repr=False)
    """Returns the present scene, in pixels of the fitted image."""

    @property
    def psnr(self) -> float:
        """Internal PSNR of the iteration's image, in dB; reads one number back from the device."""
        return psnr_from_mse(float(self.loss))


OnProgress = Callable[[Progress], None]
"""Function that a fit calls after every iteration."""


@dataclass(frozen=True)
class FitResult:
    """The result of a fit: the scene in pixels of the fitted image, on the CPU, and facts about the run."""

    scene: Scene
    history: list[dict[str, float]]
    iterations: int
    seconds: float
    interrupted: bool
    device: str


def no_fit() -> FitResult:
    """Return the result of no fit: no paths over black."""
    nothing = torch.zeros(0)
    scene = Scene.uniform(torch.zeros(0, 6, 2), torch.zeros(0, 3), nothing, torch.zeros(3), nothing.long())
    return FitResult(scene, [], 0, 0.0, False, "cpu")


def history_entry(progress: Progress) -> dict[str, Any]:
    """Return the record of an iteration for the history; reads one number back from the device."""
    return {
        "iteration": progress.iteration,
        "curves": progress.curve_count,
        "psnr": progress.psnr,
        "seconds": progress.seconds,
    }


def check_history(history: list[Any], iteration: int, seconds: float, curves: int) -> None:
    """Refuse a history that a fit of at most ``curves`` paths cannot have after ``iteration`` and ``seconds``.

    Raises:
        InputError: it cannot.
    """
    entry: dict[str, Form] = {
        "iteration": Whole(1, iteration),
        "curves": Whole(0, curves),
        "psnr": Number(psnr_from_mse(LOSS_MAX), math.inf),
        "seconds": Number(0.0, seconds),
    }
    ListOf(Fields(entry)).check("history", history)
    for name, is_forward in (("iteration", operator.lt), ("seconds", operator.le)):
        values = [record[name] for record in history]
        require(all(is_forward(a, b) for a, b in pairwise(values)), "history", "does not run forward")


class Pace:
    """An estimate of the time left. It leaves out the first iteration, which loads or compiles the kernels.

    Pass it every iteration. An iteration number below the last one starts a new fit.
    """

    def __init__(self) -> None:
        self._first_iteration = self._last_iteration = 0
        self._first_seconds = 0.0

    def see(self, progress: Progress) -> None:
        """Record an iteration. This costs nothing."""
        if self._last_iteration == 0 or progress.iteration < self._last_iteration:
            self._first_iteration, self._first_seconds = progress.iteration, progress.seconds
        self._last_iteration = progress.iteration

    def describe(self, progress: Progress) -> str:
        """Return one line with the iteration, the quality and the time left; reads one number back from the device."""
        self.see(progress)
        done = progress.iteration - self._first_iteration
        remaining = progress.iteration_count - progress.iteration
        left = f", {(progress.seconds - self._first_seconds) / done * remaining:.0f} s left" if done else ""
        return (
            f"iteration {progress.iteration} of {progress.iteration_count}, {counted(progress.curve_count, 'curve')}, "
            f"{progress.psnr:.2f} dB{left}"
        )
