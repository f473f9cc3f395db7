"""How many iterations of a fit its time budget allows."""

from __future__ import annotations

from warpvec.rendering.streams import StepQueue
from warpvec.watch.watch import Part


class Clock:
    """Plans the iterations of a fit that wants so many ``iterations`` in the time of its ``part``.

    Attributes:
        first_seconds: time of the first iteration, which may have compiled kernels, so it says nothing about the pace.
    """

    def __init__(self, iterations: int, part: Part, device: str) -> None:
        self._wanted, self._part = iterations, part
        self.first_seconds = 0.0
        self._queue = StepQueue(device)

    def planned_iterations(self, iteration: int) -> int:
        """Return the iterations that are wanted, or fewer if the time budget allows no more at the pace so far.

        Call it once after each ``iteration``.
        """
        budget = self._part.time_budget
        if budget is None:
            return self._wanted
        self._queue.add()
        if iteration == 1:
            self._queue.wait()
            self.first_seconds = self._part.seconds()
            return self._wanted if self.first_seconds < budget else 1
        seconds = self._part.seconds()
        pace = (seconds - self.first_seconds) / (iteration - 1)
        return min(self._wanted, iteration + max(0, int((budget - seconds) / pace)))
