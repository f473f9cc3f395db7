"""A test that hangs fails, and says where it hangs. Loaded by ``conftest.py``."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from time import monotonic  # as it is now: tests replace it in the module
from typing import Any

from children import SECONDS, descendants, limit, work_of

CPU_SECONDS = 600.0
"""Longest time of a test that works all the time. At the first run a test may compile kernels for minutes."""


PERIOD = 5.0
"""Seconds from one check to the next, once a test has taken a minute."""


class HangError(BaseException):
    """A test hangs. The code under test may catch an `Exception`."""


@contextmanager
def no_hang(seconds: float = SECONDS) -> Iterator[None]:
    """Raise `HangError` in the block, with its place, if it waits for more than ``seconds``, or ends far too late.

    Time in which this process works, or one that it has started, does not count as waiting. Limits grow with the load
    of the machine.
    """
    if not hasattr(signal, "SIGALRM"):
        yield
        return
    wall, cpu = monotonic(), _work()

    def check(*_: Any) -> None:
        passed, worked = monotonic() - wall, _work() - cpu
        if passed - worked > limit(seconds) or passed > limit(CPU_SECONDS):
            raise HangError(f"after {passed:.0f} s, in {worked:.0f} s of which it or its children worked")

    before = signal.signal(signal.SIGALRM, check)
    signal.setitimer(signal.ITIMER_REAL, seconds, PERIOD)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def _work() -> float:
    """Return seconds of processor time of this process, of its children that have ended, and of those that run."""
    times = os.times()
    own = times.user + times.system + times.children_user + times.children_system
    return own + sum(map(work_of, descendants(os.getpid())))
