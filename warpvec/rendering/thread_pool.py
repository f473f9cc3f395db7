"""Threads that wait actively for their share of a launch: one that sleeps takes longer to wake than the share takes.

A launch of a millisecond is over before a sleeping thread has been scheduled: 0.05 to 0.2 ms on an idle machine, and
where it is put on its caller's core, only once the caller is done. A thread that has worked goes on looking for work
for a while, in native code without the GIL, and then sleeps.
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

from warpvec.kernels.thread_pool import make_wait

_HELPER_TURNS = 60_000
"""About 2 ms: longer than what lies between two shared launches of a fit, so that its threads never sleep."""

_CALLER_TURNS = 10_000
"""About 0.3 ms: shares end at about the same time; a caller that waits for longer sleeps."""

_STOP = -1

# Address of what offers the core to whoever is queued for it, 0 where the system has no such call. It must be native:
# from Python it would take the GIL from the one who is waited for.
_GIVE_WAY = ctypes.cast(ctypes.CDLL(None).sched_yield, ctypes.c_void_p).value if sys.platform != "win32" else 0

Action = Callable[[], None]


class ThreadPool:
    """``count`` threads beside the caller's.

    Args:
        wait_actively: whether they, and the caller, look for what they wait for before they sleep. Not so where there
            are more threads than cores.
    """

    def __init__(self, count: int, wait_actively: bool) -> None:
        self._helpers = [_Helper(wait_actively) for _ in range(count)]
        for helper in self._helpers:
            threading.Thread(target=helper.serve, name="warpvec", daemon=True).start()
            weakref.finalize(self, helper.stop)

    def call(self, actions: Sequence[Action]) -> None:
        """Call the first of ``actions`` here and each other one on a thread of its own, and return when all are done.

        Raises:
            BaseException: what an action raised, once all are done.
        """
        helpers = self._helpers[: len(actions) - 1]
        for helper, action in zip(helpers, actions[1:], strict=True):
            helper.begin(action)
        try:
            actions[0]()
        finally:  # Ctrl-C too must find no helper still at work
            errors = [helper.end() for helper in helpers]
        for error in errors:
            if error is not None:
                raise error


class _Helper:
    """A thread's side of the crew: it knows nothing of those who use it, so that they can come to an end."""

    def __init__(self, wait_actively: bool) -> None:
        # The number of the last action that was given, and of the last that is done.
        self._words = np.zeros(2, np.int32)
        self._for_work = _Waiting(self._words, 0, _HELPER_TURNS if wait_actively else 0)
        self._for_end = _Waiting(self._words, 1, _CALLER_TURNS if wait_actively else 0)
        self._action: Action | None = None
        self._error: BaseException | None = None

    def begin(self, action: Action) -> None:
        self._action = action
        self._for_work.change(int(self._words[0]) + 1)

    def end(self) -> BaseException | None:
        """What the action raised, once it is done."""
        number = int(self._words[0])
        while self._words[1] != number:
            self._for_end.wait(int(self._words[1]))
        error, self._error = self._error, None
        return error

    def stop(self) -> None:
        self._for_work.change(_STOP)

    def serve(self) -> None:
        """Do what is given until told to stop."""
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


class _Waiting:
    """Waiting for one word to change: so many turns actively, and then asleep."""

    def __init__(self, words: np.ndarray[Any, Any], index: int, turns: int) -> None:
        self._words, self._index = words, index
        self._is_asleep = False
        self._awake = threading.Event()
        # Made here, on the thread of whoever launches kernels: Warp must not load two modules at a time.
        self._look = _look_command(words, index, turns) if turns else None

    def change(self, value: int) -> None:
        self._words[self._index] = value
        if self._is_asleep:
            self._awake.set()

    def wait(self, seen: int) -> None:
        """Until the word is no more ``seen``; now and then it returns early."""
        if self._look is not None:
            self._look.set_param_at_index(1, seen)
            self._look.launch()
        self._awake.clear()
        self._is_asleep = True
        # A change from here on finds the sleeper.
        if self._words[self._index] == seen:
            self._awake.wait()
        self._is_asleep = False


def _look_command(words: np.ndarray[Any, Any], index: int, turns: int) -> Any:
    array: Any = wp.array(words, dtype=int, device="cpu", copy=False)
    inputs = [index, 0, turns, array, _GIVE_WAY]
    return wp.launch(make_wait(), dim=1, inputs=inputs, device="cpu", record_tape=False, record_cmd=True)


def core_count() -> int:
    """Cores that this process may use: fewer than the machine has, in a container."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
