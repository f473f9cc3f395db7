"""Defer Ctrl-C, so that a run can end with its best result.

A library handles no other signals. The command line and the worker of the page do: each gives its `Listener` to the
`warpvec.watch.watch.Watch` of a run.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Protocol

SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
"""The signals that ask a program to end. Windows has no SIGHUP."""


@contextmanager
def blocked_signals() -> Iterator[None]:
    """Block `SIGNALS` in this thread. Threads and processes that it starts in the block never see them."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, SIGNALS)
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


class Listener(Protocol):
    """Receives the wish of a user to end the run."""

    def has_signal(self) -> bool:
        """Return whether the run is to end."""

    def hold(self) -> None:
        """Lose nothing from now on: the run has a result that can be saved."""


class CtrlC:
    """The listener of a Python program, which defers Ctrl-C while it is open.

    The first Ctrl-C makes `has_signal` return True. A second one raises KeyboardInterrupt. Python raises an interrupt
    at whatever line it has reached. If this is in a destructor, Python only prints the exception, and the run would not
    stop; arrays run destructors often. Outside the main thread, or if the caller has a handler of its own, nothing
    changes and `has_signal` returns False.
    """

    def __init__(self) -> None:
        self._pressed = threading.Event()
        self._is_installed = False

    def open(self) -> None:
        """Defer Ctrl-C from now on."""
        in_main_thread = threading.current_thread() is threading.main_thread()
        if in_main_thread and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            signal.signal(signal.SIGINT, self._note)
            self._is_installed = True

    def close(self) -> None:
        """Give Ctrl-C back to Python."""
        if self._is_installed:
            signal.signal(signal.SIGINT, signal.default_int_handler)
            self._is_installed = False

    def has_signal(self) -> bool:
        """Return whether Ctrl-C was pressed."""
        return self._pressed.is_set()

    def hold(self) -> None:
        """Do nothing: Ctrl-C is deferred anyway."""

    def _note(self, number: int, frame: FrameType | None) -> None:
        if self._pressed.is_set():
            raise KeyboardInterrupt
        self._pressed.set()
