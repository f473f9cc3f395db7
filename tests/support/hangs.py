"""A test that hangs fails, and says where it hangs. Loaded by ``conftest.py``."""

from __future__ import annotations

import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from children import SECONDS, limit

CPU_SECONDS = 600.0
"""Longest time of a test that works all the time. At the first run a test may compile kernels for minutes."""


PERIOD = 5.0
"""Seconds from one check to the next, once a test has taken a minute."""


class HangError(Exception):
    """A test hangs."""


@contextmanager
def no_hang() -> Iterator[None]:
    """Raise `HangError` in the block, with its place, if it waits for more than a minute, or ends far too late.

    Time in which this process works does not count as waiting. Limits grow with the load of the machine.
    """
    if not hasattr(signal, "SIGALRM"):
        yield
        return
    wall, cpu = time.monotonic(), time.process_time()

    def check(*_: Any) -> None:
        seconds, worked = time.monotonic() - wall, time.process_time() - cpu
        if seconds - worked > limit(SECONDS) or seconds > limit(CPU_SECONDS):
            raise HangError(f"after {seconds:.0f} s, in {worked:.0f} s of which this process worked")

    before = signal.signal(signal.SIGALRM, check)
    signal.setitimer(signal.ITIMER_REAL, SECONDS, PERIOD)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
