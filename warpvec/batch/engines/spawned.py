"""Processes of this machine that work for another one, spawned with a pipe between the two.

They are spawned, not forked, because forking a process with threads and a GPU is not safe.
"""

from __future__ import annotations

import signal
from collections.abc import Callable
from multiprocessing import get_context, resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from typing import Any

from warpvec.watch.interrupt import blocked_signals

_CONTEXT = get_context("spawn")


def spawn(serve: Callable[..., None], *arguments: Any) -> tuple[SpawnProcess, Connection]:
    """Start a process that calls ``serve`` with its end of a pipe and the ``arguments``; return it and the other end.

    The pipe ends with the process.
    """
    ours, theirs = _CONTEXT.Pipe()
    process = _CONTEXT.Process(target=serve, args=(theirs, *arguments), daemon=True)
    if hasattr(signal, "pthread_sigmask"):
        resource_tracker.ensure_running()  # the first process that is spawned would start it, and it unblocks signals
    # Terminals and others send these to all processes of a command. Blocked, not ignored: an interrupt of this process
    # is only delayed, and the child prints no message while it starts.
    with blocked_signals():
        process.start()
    theirs.close()
    return process, ours


def end_of(process: SpawnProcess) -> str:
    """Return how ``process``, which has ended, came to its end: "exited with code 1"."""
    code = process.exitcode or 0
    hint = " (out of memory?)" if code == -signal.SIGKILL else ""
    return f"was killed by signal {-code}{hint}" if code < 0 else f"exited with code {code}"
