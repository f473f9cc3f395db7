"""How many iterations of a fit its time budget allows, and how many of them the host may launch at once."""

from __future__ import annotations

from warpvec.rendering.streams import STEPS_AHEAD, StepQueue
from warpvec.watch.watch import Part

LOOK_SECONDS = 0.05
"""Time between two looks of the host for a wish to stop, and between two reports: 20 a second look like no wait."""


class Clock:
    """Plans the iterations of a fit that wants so many ``iterations`` in the time of its ``part``.

    Attributes:
        first_seconds: time of the first iteration, which may have compiled kernels, so it says nothing about the pace.
    """

    def __init__(self, iterations: int, part: Part, device: str) -> None:
        self._wanted, self._part = iterations, part
        self.first_seconds = 0.0
        self._queue = StepQueue(device)
        self._pace = 0.0  # seconds of a step, measured last; 0 before
        self._measured = (0, part.seconds())  # iteration and seconds

    def planned_iterations(self, iteration: int) -> int:
        """Return the iterations that are wanted, or fewer if the time budget allows no more at the pace so far.

        Call it once after each ``iteration``, or after each chain of them.
        """
        self._queue.add()
        self._measure(iteration)
        budget = self._part.time_budget
        if budget is None:
            return self._wanted
        if iteration == 1:
            self._queue.wait()
            self.first_seconds = self._part.seconds()
            return self._wanted if self.first_seconds < budget else 1
        seconds = self._part.seconds()
        pace = (seconds - self.first_seconds) / (iteration - 1)
        return min(self._wanted, iteration + max(0, int((budget - seconds) / pace)))

    def steps_to_look(self, most: int) -> int:
        """Return how many steps, up to ``most``, may be launched at once so that the host looks in time.

        As many again wait in the queue.
        """
        share = LOOK_SECONDS / (STEPS_AHEAD + 1)
        return most if self._pace * most <= share else max(1, int(share / self._pace))

    def _measure(self, iteration: int) -> None:
        """Measure the pace anew if enough time has passed that the steps in the queue hardly count."""
        before, since = self._measured
        seconds = self._part.seconds()
        if seconds - since >= LOOK_SECONDS and iteration > before:
            self._pace, self._measured = (seconds - since) / (iteration - before), (iteration, seconds)
