"""Processes of this machine that work for another one, spawned with a pipe between the two.

They are spawned, not forked, because forking a process with threads and a GPU is not safe.
"""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing import get_context, resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from typing import Any

_CONTEXT = get_context("spawn")


def spawn(serve: Callable[..., None], *arguments: Any) -> tuple[SpawnProcess, Connection]:
    """Start a process that calls ``serve`` with its end of a pipe and the ``arguments``; return it and the other end.

    The pipe ends with the process.
    """
    ours, theirs = _CONTEXT.Pipe()
    process = _CONTEXT.Process(target=serve, args=(theirs, *arguments), daemon=True)
    with _no_interrupts():
        process.start()
    theirs.close()
    return process, ours


def end_of(process: SpawnProcess) -> str:
    """Return how ``process``, which has ended, came to its end: "exited with code 1"."""
    code = process.exitcode or 0
    hint = " (out of memory?)" if code == -signal.SIGKILL else ""
    return f"was killed by signal {-code}{hint}" if code < 0 else f"exited with code {code}"


@contextmanager
def _no_interrupts() -> Iterator[None]:
    """Start processes in this context that never see Ctrl-C, nor another signal that asks a command to end.

    Terminals and others send them to all processes of a command. The signals are blocked, not ignored: an interrupt of
    this process is only delayed, and the child prints no message while it starts.
    """
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    # The first process that is spawned would start this helper, which unblocks signals.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM, signal.SIGHUP})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
