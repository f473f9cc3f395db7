"""The worker process, seen from the server: started early, kept from job to job, replaced when it dies."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess

from warpvec.app.messages import FitJob, Report, Stop
from warpvec.app.worker import serve
from warpvec.batch.engines.spawned import end_of, spawn


class WorkerProcess:
    """A process that fits pictures. All methods are called in the thread of the event loop, as is ``receive``.

    Args:
        threads: CPU threads of fits; None for all cores.
    """

    def __init__(self, threads: int | None) -> None:
        self._threads = threads
        self._process: SpawnProcess | None = None
        self._sender = ThreadPoolExecutor(1)  # a picture of many megabytes takes longer than the loop may wait

    def start(self, receive: Callable[[Report], None]) -> None:
        """Start the process; it reports "ready" when it has loaded what fits need.

        Args:
            receive: takes the reports of the process; "died" is the report of its unexpected end.
        """
        self._receive = receive
        self._process, self._connection = spawn(serve, self._threads)
        arguments = (self._connection, self._process, asyncio.get_running_loop())
        threading.Thread(target=self._listen, args=arguments, daemon=True).start()

    def send(self, message: FitJob | Stop) -> None:
        """Send a message; one to a process that has died is lost, which its report tells."""
        self._sender.submit(_send, self._connection, message)

    def restart(self) -> None:
        """End the process in whatever state it is, without a report, and start another."""
        self.end()
        self.start(self._receive)

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
            process.join(1.0)
            message = f"the process that fits {end_of(process)}"
            loop.call_soon_threadsafe(deliver, Report("died", 0, {"message": message}))


def _send(connection: Connection, message: FitJob | Stop) -> None:
    with suppress(OSError):
        connection.send(message)
