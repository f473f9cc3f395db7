"""The messages of the server to its worker process, received while a fit runs."""

from __future__ import annotations

import os
import queue
import threading
from contextlib import suppress
from multiprocessing.connection import Connection

from warpvec.app.messages import FitJob, Stop


class Dropped(Exception):
    """The result of the present job is not wanted any more."""


class Mailbox:
    """The messages of the server, received by a thread, and the wish to stop the present job.

    It is also the listener of fits: see `warpvec.watch.interrupt.Listener`.
    """

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._jobs: queue.SimpleQueue[FitJob] = queue.SimpleQueue()
        self._stops: dict[int, bool] = {}
        self._number = 0
        threading.Thread(target=self._receive, daemon=True).start()

    def next_job(self) -> FitJob:
        """Wait for the next job."""
        job = self._jobs.get()
        self._number = job.number
        return job

    def has_signal(self) -> bool:
        """Return whether the present job is to end."""
        return self._number in self._stops

    def hold(self) -> None:
        """Do nothing: a job may end at any time."""

    def check(self) -> None:
        """Raise `Dropped` if nobody wants the result of the present job."""
        if self._stops.get(self._number):
            raise Dropped

    def _receive(self) -> None:
        with suppress(EOFError, OSError):
            while True:
                message = self._connection.recv()
                if isinstance(message, Stop):
                    self._stops[message.number] = message.is_dropped or self._stops.get(message.number, False)
                else:
                    self._jobs.put(message)
        os._exit(0)  # the server has ended, and nothing here is worth keeping
