"""Defer Ctrl-C to the end of an iteration.

A library does not handle other signals. The command line does, with a listener that this module asks.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Protocol


class Listener(Protocol):
    """Handles the signals of the process instead of this module."""

    def has_signal(self) -> bool:
        """Return whether a signal asks the fit to end."""

    def hold(self) -> None:
        """Defer signals from now on, because there is a result that can be saved."""


# The flag of the outermost block in the main thread; at most one.
_open_blocks: list[threading.Event] = []

_listener: Listener | None = None


def listen_to(listener: Listener | None) -> None:
    """Let ``listener`` handle the signals from now on; None for nobody."""
    global _listener
    _listener = listener


def hold_signals() -> None:
    """Tell the listener, if there is one, that there is a result worth saving."""
    if _listener is not None:
        _listener.hold()


@contextmanager
def deferred_interrupts() -> Iterator[Callable[[], bool]]:
    """Defer Ctrl-C: the first one only makes the yielded function return True, a second raises KeyboardInterrupt.

    Python raises an interrupt at whatever line it has reached. If that happens in a destructor, Python only prints the
    exception, and the loop would not stop. Arrays run destructors often. Outside the main thread, or if the caller has
    a handler of its own, nothing changes and the function returns False. A block inside another one shares its
    function. If there is a listener, its answer is returned.
    """
    in_main_thread = threading.current_thread() is threading.main_thread()
    if _listener is not None and in_main_thread:
        yield _listener.has_signal
        return
    if _open_blocks and in_main_thread:
        yield _open_blocks[-1].is_set
        return
    interrupted = threading.Event()

    def note(number: int, frame: FrameType | None) -> None:
        if interrupted.is_set():
            raise KeyboardInterrupt
        interrupted.set()

    if not in_main_thread or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield interrupted.is_set
        return
    signal.signal(signal.SIGINT, note)
    _open_blocks.append(interrupted)
    try:
        yield interrupted.is_set
    finally:
        _open_blocks.pop()
        signal.signal(signal.SIGINT, signal.default_int_handler)
