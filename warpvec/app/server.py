"""Run the server of the page until it is asked to end.

Starlette and uvicorn are the most used and best kept pair of an ASGI library and server: few dependencies, streams
whose client has left are noticed, and a test client that needs no port.
"""

from __future__ import annotations

import asyncio
import logging
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol

from warpvec.app.desk import Desk
from warpvec.app.export import usable_formats
from warpvec.app.guard import Guard
from warpvec.app.identity import Identity
from warpvec.app.routes import Routes
from warpvec.app.worker_process import WorkerProcess
from warpvec.watch.interrupt import Listener

CONNECTIONS_MAX = 128
"""Most open connections. Browsers open six to a server, and a process may often have 1,024 files, or 256."""

BACKLOG = 64
"""Most connections that are accepted before the first of them is counted."""

SILENT_SECONDS = 10.0
"""Time in which a new connection must bring its first request, and any connection the rest of one that it has begun:
other programs' silent ones take up room."""


def run_server(
    listener: socket.socket,
    identity: Identity,
    *,
    folder: Path | None,
    threads: int | None,
    on_start: Callable[[str, str], None],
    signals: Listener | None,
) -> None:
    """Serve the page on ``listener`` until a signal ends it.

    Args:
        listener: a socket that listens at a port of this machine: a browser that is quicker than the server waits.
        identity: its secrets.
        folder: where pictures are listed and drawings are saved; None for nowhere.
        threads: CPU threads of fits; None for all cores.
        on_start: called with the address of the page when it can be opened, and with one that leads there only once.
        signals: says when a signal has come; None for Python's own handling of Ctrl-C.

    Raises:
        KeyboardInterrupt: a signal has come.
    """
    if signals is not None:
        signals.hold()
    host, port = listener.getsockname()
    root = f"http://{host}:{port}"

    async def serve() -> None:
        worker = WorkerProcess(threads)
        desk = Desk(worker)
        worker.start(desk.receive)
        try:
            routes = Routes(desk, folder, await asyncio.to_thread(usable_formats), identity.key)
            guard = Guard(routes.application(), port, identity)
            config = uvicorn.Config(
                guard, http=_Connection, backlog=BACKLOG, log_level="error",
                access_log=False, server_header=False, lifespan="off", ws="none",
            )  # fmt: skip
            logging.getLogger("uvicorn.error").addFilter(_is_mistake)
            server = _Server(config, signals)
            on_start(f"{root}/{identity.token}/", f"{root}/{guard.new_ticket()}")
            await server.serve([listener])
        finally:
            worker.end()

    asyncio.run(serve())


class _Connection(H11Protocol):
    """A connection that ends at once if there are too many, and soon if it is silent or sends half a request.

    An idle one between two requests has a time limit of uvicorn's own.
    """

    _patience: asyncio.TimerHandle | None = None
    _patience_since: object = None
    """The request after which the time of ``_patience`` began; None before the first."""

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override] # as uvicorn's own
        super().connection_made(transport)
        if len(self.connections) > CONNECTIONS_MAX:
            transport.abort()
            return
        self._wait_for_request()

    def data_received(self, data: bytes) -> None:
        super().data_received(data)
        if self.cycle is None or self.cycle.response_complete:  # no request has begun by it
            self._wait_for_request()

    def _wait_for_request(self) -> None:
        """Start the time limit. More pieces of the same request do not extend it."""
        if self._patience is not None:
            if self._patience_since is self.cycle:
                return
            self._patience.cancel()
        self._patience_since = self.cycle
        self._patience = self.loop.call_later(SILENT_SECONDS, self._end_if_silent)

    def _end_if_silent(self) -> None:
        if self.cycle is self._patience_since:  # there was no other request
            self.transport.abort()


def _is_mistake(record: logging.LogRecord) -> bool:
    """Return whether a message is of more than a request that the end of the server has cut off."""
    error = record.exc_info[1] if record.exc_info else None
    return not isinstance(error, (asyncio.CancelledError, KeyboardInterrupt))


class _Server(uvicorn.Server):
    """A server that leaves the signals to the command, and asks ten times a second whether one has come.

    A handler that raises would not do: uvicorn takes an exception within a request for a fault of that request.
    """

    def __init__(self, config: uvicorn.Config, signals: Listener | None = None) -> None:
        super().__init__(config)
        self._signals = signals

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        yield

    async def on_tick(self, counter: int) -> bool:
        if self._signals is not None and self._signals.has_signal():
            raise KeyboardInterrupt
        return await super().on_tick(counter)
