"""The time that a fit has taken, and how many iterations its time budget allows."""

from __future__ import annotations

import time

from warpvec.config.fit_config import FitConfig
from warpvec.rendering.streams import StepQueue


class Clock:
    """Counts the seconds of a fit from now on.

    Attributes:
        first_seconds: time of the first iteration, which may have compiled kernels, so it says nothing about the pace.
    """

    def __init__(self, config: FitConfig, device: str) -> None:
        self._wanted, self._budget = config.iterations, config.time_budget
        self._start, self.first_seconds = time.perf_counter(), 0.0
        self._queue = StepQueue(device)

    def seconds(self) -> float:
        """Return the time of the fit, with that before it was resumed."""
        return time.perf_counter() - self._start

    def resume(self, seconds: float, first_seconds: float) -> None:
        """Go on as if the fit had taken ``seconds`` so far, and its first iteration ``first_seconds``."""
        self._start, self.first_seconds = time.perf_counter() - seconds, first_seconds

    def planned_iterations(self, iteration: int) -> int:
        """Return the iterations of the settings, or fewer if the time budget allows no more at the pace so far.

        Call it once after each ``iteration``.
        """
        if self._budget is None:
            return self._wanted
        self._queue.add()
        if iteration == 1:
            self._queue.drain()
            self.first_seconds = self.seconds()
            return self._wanted if self.first_seconds < self._budget else 1
        pace = (self.seconds() - self.first_seconds) / (iteration - 1)
        return min(self._wanted, iteration + max(0, int((self._budget - self.seconds()) / pace)))
