"""The worker process, seen from the server: started early, kept from job to job, replaced when it dies."""

from __future__ import annotations

import asyncio
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from multiprocessing import get_context, resource_tracker
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess

from warpvec.app.messages import FitJob, Report, Stop
from warpvec.app.worker import serve

_CONTEXT = get_context("spawn")
"""Forking a process with threads is not safe."""


class WorkerProcess:
    """A process that fits pictures. All methods are called in the thread of the event loop, as is ``receive``.

    Args:
        receive: takes the reports of the process; "died" is the report of its unexpected end.
        threads: CPU threads of fits; None for all cores.
    """

    def __init__(self, receive: Callable[[Report], None], threads: int | None) -> None:
        self._receive, self._threads = receive, threads
        self._process: SpawnProcess | None = None
        self._sender = ThreadPoolExecutor(1)  # a picture of many megabytes takes longer than the loop may wait

    def start(self) -> None:
        """Start the process; it reports "ready" when it has loaded what fits need."""
        ours, theirs = _CONTEXT.Pipe()
        process = _CONTEXT.Process(target=serve, args=(theirs, self._threads), daemon=True)
        with _blocked_signals():
            process.start()
        theirs.close()  # from here on the pipe ends with the process
        self._process, self._connection = process, ours
        loop = asyncio.get_running_loop()
        arguments = (ours, process, loop)
        threading.Thread(target=self._listen, args=arguments, daemon=True).start()

    def send(self, message: FitJob | Stop) -> None:
        """Send a message; one to a process that has died is lost, which its report tells."""
        connection = self._connection
        self._sender.submit(_send, connection, message)

    def restart(self) -> None:
        """End the process in whatever state it is, without a report, and start another."""
        self.end()
        self.start()

    def end(self) -> None:
        """End the process, whatever it does: it has nothing that must be kept."""
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.join()

    def _listen(self, connection: Connection, process: SpawnProcess, loop: asyncio.AbstractEventLoop) -> None:
        """Pass reports on to the event loop until the pipe ends."""

        def deliver(report: Report) -> None:
            if self._process is process:  # else it has been replaced
                self._receive(report)

        with suppress(RuntimeError):  # the loop is closed
            with suppress(EOFError, OSError):
                while True:
                    loop.call_soon_threadsafe(deliver, connection.recv())
            loop.call_soon_threadsafe(deliver, Report("died", 0, {"message": _end_of(process)}))


def _send(connection: Connection, message: FitJob | Stop) -> None:
    with suppress(OSError):
        connection.send(message)


@contextmanager
def _blocked_signals() -> Iterator[None]:
    """Start processes in this context that never see Ctrl-C, which terminals send to all processes of a command."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # the first process that is spawned would start it, and it unblocks signals
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT, signal.SIGTERM, signal.SIGHUP})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _end_of(process: SpawnProcess) -> str:
    process.join(1.0)
    code = process.exitcode or 0
    hint = " (out of memory?)" if code == -signal.SIGKILL else ""
    return f"the process that fits has ended with code {code}{hint}"
