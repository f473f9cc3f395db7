"""Run the server of the page until it is asked to end.

Starlette and uvicorn are the most used and best kept pair of an ASGI library and server: few dependencies, streams
whose client has left are noticed, and a test client that needs no port.
"""

from __future__ import annotations

import asyncio
import logging
import socket
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
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

END_SECONDS = 3
"""Time for requests to be answered after a signal: a file that is being saved is written whole."""


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
    """
    if signals is not None:
        signals.hold()
    host, port = listener.getsockname()
    root = f"http://{host}:{port}"

    async def serve() -> None:
        asyncio.get_running_loop().set_default_executor(_Threads())
        worker = WorkerProcess(threads)
        desk = Desk(worker)
        worker.start(desk.receive)
        try:
            routes = Routes(desk, folder, await asyncio.to_thread(usable_formats), identity.key)
            guard = Guard(routes.application(), port, identity)
            config = uvicorn.Config(
                guard, http=_Connection, backlog=BACKLOG, log_level="error",
                access_log=False, server_header=False, lifespan="off", ws="none", timeout_graceful_shutdown=END_SECONDS,
            )  # fmt: skip
            logging.getLogger("uvicorn.error").addFilter(_is_mistake)
            server = _Server(config, signals, desk.pages.end)
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


class _Threads(ThreadPoolExecutor):
    """Threads for requests, for which the end of the event loop does not wait: a drawing may take long."""

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        super().shutdown(wait=False, cancel_futures=True)


def _is_mistake(record: logging.LogRecord) -> bool:
    """Return whether a message is of more than requests that the end of the server has cut off."""
    return record.exc_info is not None and not isinstance(record.exc_info[1], asyncio.CancelledError)


class _Server(uvicorn.Server):
    """A server that leaves the signals to the command, and asks ten times a second whether one has come.

    Neither a handler nor the loop of the server may raise. uvicorn takes an exception within a request for a fault of
    that request, and after one in its own loop it still accepts connections, while asyncio waits for all requests.

    Args:
        config: uvicorn's.
        signals: says when a signal has come; None for Python's own handling of Ctrl-C.
        on_end: called when a signal has come; ends what would be sent without end.
    """

    def __init__(
        self, config: uvicorn.Config, signals: Listener | None = None, on_end: Callable[[], None] = lambda: None
    ) -> None:
        super().__init__(config)
        self._signals, self._on_end = signals, on_end

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        yield

    async def on_tick(self, counter: int) -> bool:
        if self._signals is not None and self._signals.has_signal():
            self._on_end()
            return True
        return await super().on_tick(counter)
