"""The number of threads that share launches: all of them on an idle machine, fewer on a busy one.

Threads that share a launch end it together. If other programs take the core of one of them, all the others wait, and
what the sharing gains is lost. The choice therefore watches how much time the threads lose while they work. On a very
busy machine one thread works alone. In between, the choice compares the rates at which two numbers of threads get work
done, each over a window of launches, and keeps the better one. Results do not depend on the number of threads.
"""

from __future__ import annotations

import time
from collections.abc import Hashable
from typing import NamedTuple

_WINDOW_LAUNCHES = 15
"""Launches of a window: about three steps of a fit, so that it has some of all kernels."""

_WINDOW_SECONDS = 0.02
"""Shortest window: several times the time slice of a scheduler, which is 3 ms on Linux."""

_BUSY = 0.15
"""Share of their time that threads lose on a busy machine. On an idle one they lose 1 to 5 %, to interrupts."""

_VERY_BUSY = 0.4
"""Share of their time that threads lose where sharing does harm. Two threads on two cores lose a third of it beside one
other program, half beside two, and four fifths beside eight, where they take 1.2 to 1.35 times as long as one."""

_GAIN = 1.1
"""More threads on a busy machine must get work done this much faster: they take time from other programs."""

_TRIAL_GAP = 20
"""Windows between two trials on a busy machine. Trials take up to 1.4 times as long, which adds 2 %."""

_COST_GROWTH = 1.0005
"""Factor of the least known cost of a kernel at each launch, so that it follows changes of the scene."""

_CLOCK_MAX = 1e-4
"""Coarsest clock of a thread's CPU time, in seconds, that can time a share of a launch. (On Windows it has 16 ms.)"""


class Launch(NamedTuple):
    """A launch of a kernel on some items: its wall seconds, and those that its threads spent and had a core for."""

    kernel: Hashable
    items: int
    wall: float
    spent: float
    cpu: float


class ThreadChoice:
    """Chooses among ``threads``, half as many, and so on down to one."""

    def __init__(self, threads: int) -> None:
        self._counts = [threads]
        while self._counts[-1] > 1 and time.get_clock_info("thread_time").resolution <= _CLOCK_MAX:
            self._counts.append(self._counts[-1] // 2)
        # Indices into the counts: what serves best so far, and what the present window uses.
        self._best = self._present = 0
        self._window: list[Launch] = []
        self._window_seconds = 0.0
        self._last: dict[int, list[Launch]] = {}
        self._costs: dict[Hashable, float] = {}
        self._windows_since_trial = _TRIAL_GAP

    @property
    def count(self) -> int:
        """Number of threads for the next launch."""
        return self._counts[self._present]

    def record(self, launch: Launch) -> None:
        """Note a launch that `count` threads have shared."""
        cost = launch.cpu / launch.items
        self._costs[launch.kernel] = min(_COST_GROWTH * self._costs.get(launch.kernel, cost), cost)
        self._window.append(launch)
        self._window_seconds += launch.wall
        if len(self._window) >= _WINDOW_LAUNCHES and self._window_seconds >= _WINDOW_SECONDS:
            self._end_window()

    def _end_window(self) -> None:
        lost = 1 - sum(each.cpu for each in self._window) / sum(each.spent for each in self._window)
        self._last[self._present], self._window, self._window_seconds = self._window, [], 0.0
        self._windows_since_trial += 1
        fewest = len(self._counts) - 1
        if lost > _VERY_BUSY:
            self._best = fewest
        elif self._present != self._best:
            self._best = self._better(_GAIN if lost > _BUSY else 1.0)
        self._present = self._best
        is_trial_due = lost <= _VERY_BUSY and self._windows_since_trial > _TRIAL_GAP
        if lost <= _BUSY and self._best > 0:
            self._present, self._windows_since_trial = self._best - 1, 0
        elif lost > _BUSY and fewest > 0 and is_trial_due:
            self._present = self._best + 1 if self._best < fewest else self._best - 1
            self._windows_since_trial = 0

    def _better(self, gain_min: float) -> int:
        """Return the better one of the trial that has just ended and the best number of threads before."""
        more, fewer = sorted((self._present, self._best))
        is_gain = fewer not in self._last or self._rate(more) > gain_min * self._rate(fewer)
        return more if is_gain else fewer

    def _rate(self, index: int) -> float:
        """Return the work done per second with a number of threads, in CPU seconds of a thread that works undisturbed.

        It is not the CPU time itself: the same work takes more of it while a thread works on the core's sibling.
        """
        work = sum(self._costs[launch.kernel] * launch.items for launch in self._last[index])
        return work / sum(launch.wall for launch in self._last[index])
