"""The number of threads that share launches: all of them on an idle machine, fewer on a busy one.

Threads that share a launch end it together. If other programs take the core of one of them, all the others wait, and
what the sharing gains is lost. The choice therefore watches how much time the threads lose while they work. On a very
busy machine one thread works alone. In between, the choice compares the rates at which two numbers of threads get work
done, each over a window of launches, and keeps the better one. Results do not depend on the number of threads.
"""

from __future__ import annotations

import time
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field
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


class Share(NamedTuple):
    """Seconds of a thread for its share of a launch, and the seconds in which it had a core."""

    wall: float
    cpu: float


@dataclass
class _Window:
    """The totals of some launches in a row: wall seconds, and those that the threads spent and had a core for."""

    launches: int = 0
    wall: float = 0.0
    spent: float = 0.0
    cpu: float = 0.0
    items: dict[Hashable, int] = field(default_factory=dict)


class ThreadChoice:
    """Chooses among ``threads``, half as many, and so on down to one.

    Attributes:
        count: the number of threads that the next launch should use.
        seconds: for each number, the seconds of the launches that used it.
    """

    def __init__(self, threads: int) -> None:
        counts = [threads]
        while counts[-1] > 1 and time.get_clock_info("thread_time").resolution <= _CLOCK_MAX:
            counts.append(counts[-1] // 2)
        self._counts = counts
        self.seconds = dict.fromkeys(counts, 0.0)
        # Indices into the counts: what serves best so far, and what the present window uses.
        self._best = self._present = 0
        self._last: dict[int, _Window] = {}
        self._costs: dict[Hashable, float] = {}
        self._windows_since_trial = _TRIAL_GAP
        self._window = _Window()

    @property
    def count(self) -> int:
        """Number of threads for the next launch."""
        return self._counts[self._present]

    def record(self, kernel: Hashable, item_count: int, wall: float, shares: Sequence[Share]) -> None:
        """Note a launch of ``kernel`` on ``item_count`` items that took ``wall`` seconds, and the threads' shares."""
        cpu = sum(share.cpu for share in shares)
        cost = cpu / item_count
        self._costs[kernel] = min(_COST_GROWTH * self._costs.get(kernel, cost), cost)
        window = self._window
        window.launches += 1
        window.wall += wall
        window.cpu += cpu
        window.spent += sum(share.wall for share in shares)
        window.items[kernel] = window.items.get(kernel, 0) + item_count
        if window.launches >= _WINDOW_LAUNCHES and window.wall >= _WINDOW_SECONDS:
            self._end_window(window)
            self._window = _Window()

    def _end_window(self, window: _Window) -> None:
        lost = 1 - window.cpu / window.spent
        self.seconds[self.count] += window.wall
        self._last[self._present] = window
        self._windows_since_trial += 1
        if lost > _VERY_BUSY:
            self._best = len(self._counts) - 1
        elif self._present != self._best:
            self._judge(lost > _BUSY)
        self._present = self._best
        if lost <= _BUSY and self._best > 0:
            self._try(self._best - 1)
        elif _BUSY < lost <= _VERY_BUSY and len(self._counts) > 1 and self._windows_since_trial > _TRIAL_GAP:
            self._try(self._best + 1 if self._best + 1 < len(self._counts) else self._best - 1)

    def _try(self, index: int) -> None:
        self._present, self._windows_since_trial = index, 0

    def _judge(self, is_busy: bool) -> None:
        """Compare the trial that has just ended with the best number of threads before."""
        more, fewer = sorted((self._present, self._best))
        if fewer in self._last:
            gain = self._rate(self._last[more]) / self._rate(self._last[fewer])
            self._best = more if gain > (_GAIN if is_busy else 1.0) else fewer
        else:
            self._best = more

    def _rate(self, window: _Window) -> float:
        """Return the work done per second, in CPU seconds of a thread that works undisturbed.

        It is not the CPU time itself: the same work takes more of it while a thread works on the core's sibling.
        """
        return sum(self._costs[kernel] * item_count for kernel, item_count in window.items.items()) / window.wall
