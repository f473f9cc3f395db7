"""Threads that share a kernel launch with the calling thread.

The threads wait actively for their share, because waking a sleeping thread can take longer than the share itself: 0.05
to 0.2 ms on an idle machine, or until the caller is done if the scheduler puts the thread on the caller's core. After
its work a thread keeps looking for more for a while, in native code without the GIL, and then sleeps.
"""

from __future__ import annotations

import ctypes
import os
import sys
import threading
import weakref
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import warp as wp

from warpvec.kernels.making import making
from warpvec.kernels.thread_pool import make_wait

_HELPER_TURNS = 60_000
"""About 2 ms: longer than the time between two shared launches of a fit, so that its threads never sleep."""

_CALLER_TURNS = 10_000
"""About 0.3 ms: shares end at about the same time. A caller that has to wait longer sleeps."""

_STOP = -1

# Address of a function that offers the core to queued threads; 0 if the system has none. It must be native code: a
# Python function would take the GIL from the thread that is waited for.
_YIELD_CORE = ctypes.cast(ctypes.CDLL(None).sched_yield, ctypes.c_void_p).value if sys.platform != "win32" else 0

_THREADS_PER_CORE_MAX = 4
"""More threads than cores only take turns. A few per core do no harm; thousands that wait for each other never end."""

Action = Callable[[], None]


class ThreadPool:
    """``count`` threads in addition to the caller's. In a forked process they start anew at the first call.

    Args:
        wait_actively: whether the threads and the caller wait actively before they sleep. Set it to False if there are
            more threads than cores.
    """

    def __init__(self, count: int, wait_actively: bool) -> None:
        self._count, self._wait_actively = count, wait_actively
        self._start()

    def call(self, actions: Sequence[Action]) -> None:
        """Run the first of ``actions`` on this thread, each other one on a thread of its own, and wait for all.

        Raises:
            BaseException: the error of an action, after all actions have ended.
        """
        if self._process != os.getpid():  # a forked process has its parent's objects, but none of its threads
            self._start()
        helpers = self._helpers[: len(actions) - 1]
        for helper, action in zip(helpers, actions[1:], strict=True):
            helper.begin(action)
        try:
            actions[0]()
        finally:  # after Ctrl-C too, no helper may be at work any more
            errors = [helper.end() for helper in helpers]
        for error in errors:
            if error is not None:
                raise error

    def _start(self) -> None:
        self._process = os.getpid()
        self._helpers = [_Helper(self._wait_actively) for _ in range(self._count)]
        for helper in self._helpers:
            threading.Thread(target=helper.serve, name="warpvec", daemon=True).start()
            weakref.finalize(self, helper.stop)


class _Helper:
    """One thread of the pool. It holds no reference to the pool, so that the pool can be garbage-collected."""

    def __init__(self, wait_actively: bool) -> None:
        # Number of the last action that was given, and of the last one that is done.
        self._words = np.zeros(2, np.int32)
        self._for_work = _Word(self._words, 0, _HELPER_TURNS if wait_actively else 0)
        self._for_end = _Word(self._words, 1, _CALLER_TURNS if wait_actively else 0)
        self._action: Action | None = None
        self._error: BaseException | None = None
        self._process = os.getpid()

    def begin(self, action: Action) -> None:
        """Give the thread an action to run."""
        self._action = action
        self._for_work.change(int(self._words[0]) + 1)

    def end(self) -> BaseException | None:
        """Wait until the action is done; return the error that it raised, if any."""
        number = int(self._words[0])
        while self._words[1] != number:
            self._for_end.wait(int(self._words[1]))
        error, self._error = self._error, None
        return error

    def stop(self) -> None:
        """End the thread. A forked process has none to end, and its copy of the thread's lock may be held for ever."""
        if self._process == os.getpid():
            self._for_work.change(_STOP)

    def serve(self) -> None:
        """Run the actions that are given, until stopped."""
        done = 0
        while True:
            while self._words[0] == done:
                self._for_work.wait(done)
            done = int(self._words[0])
            action, self._action = self._action, None
            if done == _STOP or action is None:
                return
            try:
                action()
            except BaseException as error:
                self._error = error
            del action
            self._for_end.change(done)


class _Word:
    """A word of memory that one thread changes and another waits for: actively for ``turns`` turns, then asleep."""

    def __init__(self, words: np.ndarray[Any, Any], index: int, turns: int) -> None:
        self._words, self._index = words, index
        self._is_asleep = False
        self._awake = threading.Event()
        # Made here, on the thread that launches kernels, because Warp must not load two modules at the same time.
        self._wait_actively = _wait_command(words, index, turns) if turns else None

    def change(self, value: int) -> None:
        """Set the word, and wake the thread that waits for it."""
        self._words[self._index] = value
        if self._is_asleep:
            self._awake.set()

    def wait(self, seen: int) -> None:
        """Wait until the word is not ``seen``; this may return too early."""
        if self._wait_actively is not None:
            self._wait_actively.set_param_at_index(1, seen)
            self._wait_actively.launch()
        self._awake.clear()
        self._is_asleep = True
        # From here on a change wakes this thread.
        if self._words[self._index] == seen:
            self._awake.wait()
        self._is_asleep = False


def _wait_command(words: np.ndarray[Any, Any], index: int, turns: int) -> Any:
    array: Any = wp.array(words, dtype=int, device="cpu", copy=False)
    inputs = [index, 0, turns, array, _YIELD_CORE]
    with making:
        return wp.launch(make_wait(), dim=1, inputs=inputs, device="cpu", record_tape=False, record_cmd=True)


def usable_threads(threads: int | None) -> int:
    """Return how many threads to start if ``threads`` are asked for (None: one per core): at most four per core."""
    return min(threads or core_count(), _THREADS_PER_CORE_MAX * core_count())


def core_count() -> int:
    """Return how many cores this process may use; in a container these are fewer than the machine has."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
