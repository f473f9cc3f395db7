"""Reports of a running fit: its progress and the time left."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TypedDict

from torch import Tensor

from warpvec.checks import counted
from warpvec.geometry.scene import Scene
from warpvec.image.metrics import psnr_from_mse


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
"""Function that a fit calls after every iteration; on a GPU after a dozen or more that follow each other there."""


class HistoryEntry(TypedDict):
    """The record of an iteration: its number, the paths, the internal PSNR in dB and the seconds since the start."""

    iteration: int
    curves: int
    psnr: float
    seconds: float


def history_entry(progress: Progress) -> HistoryEntry:
    """Return the record of an iteration for the history; reads one number back from the device."""
    return {
        "iteration": progress.iteration,
        "curves": progress.curve_count,
        "psnr": progress.psnr,
        "seconds": progress.seconds,
    }


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

    def seconds_left(self, progress: Progress) -> float | None:
        """Return the seconds until the fit ends at its pace so far; None after its first iteration."""
        done = progress.iteration - self._first_iteration
        if not done:
            return None
        return (progress.seconds - self._first_seconds) / done * (progress.iteration_count - progress.iteration)

    def describe(self, progress: Progress) -> str:
        """Return one line with the iteration, the quality and the time left; reads one number back from the device."""
        self.see(progress)
        seconds = self.seconds_left(progress)
        left = "" if seconds is None else f", {seconds:.0f} s left"
        return (
            f"iteration {progress.iteration} of {progress.iteration_count}, {counted(progress.curve_count, 'path')}, "
            f"{progress.psnr:.2f} dB{left}"
        )


Show = Callable[[Progress, str], None]
"""Shows the progress of a fit, described by a text."""


class Regularly:
    """Callback that shows progress at once, then every ``interval`` seconds, and at the end."""

    def __init__(self, show: Show, interval: float) -> None:
        self._show, self._interval, self._due = show, interval, -math.inf
        self._pace = Pace()

    def __call__(self, progress: Progress) -> None:
        """Show ``progress`` if it is time."""
        self._pace.see(progress)
        now = time.monotonic()
        if now >= self._due:
            self._due = now + self._interval
        elif progress.iteration < progress.iteration_count:
            return
        self._show(progress, self._pace.describe(progress))
