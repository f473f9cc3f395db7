"""Ctrl-C that is noted at once and acted on between iterations."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType

# What the outermost block in the main thread has noted; at most one.
_open_blocks: list[threading.Event] = []


@contextmanager
def noted_interrupts() -> Iterator[Callable[[], bool]]:
    """Within this block the first Ctrl-C only makes the yielded function true; a second one raises KeyboardInterrupt.

    An interrupt is raised wherever Python happens to be. In a destructor, and arrays that come and go have many, it is
    printed and forgotten, and a loop would run on. Outside the main thread, or where the caller has a handler of its
    own, nothing changes and the function stays false. A block within another one shares its function.
    """
    in_main_thread = threading.current_thread() is threading.main_thread()
    if _open_blocks and in_main_thread:
        yield _open_blocks[-1].is_set
        return
    noted = threading.Event()

    def note(number: int, frame: FrameType | None) -> None:
        if noted.is_set():
            raise KeyboardInterrupt
        noted.set()

    if not in_main_thread or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield noted.is_set
        return
    signal.signal(signal.SIGINT, note)
    _open_blocks.append(noted)
    try:
        yield noted.is_set
    finally:
        _open_blocks.pop()
        signal.signal(signal.SIGINT, signal.default_int_handler)
