"""The server ends when a signal asks for it, whatever its requests do."""

from __future__ import annotations

import http.client
import threading
from collections.abc import Callable
from contextlib import closing, suppress

import pytest
from children import limit

from warpvec.app import routes, server
from warpvec.app.address import open_socket
from warpvec.app.identity import Identity
from warpvec.app.messages import FitJob, Report, Stop


class Signals:
    """A listener that hears a signal when a test says so."""

    def __init__(self) -> None:
        self.has_come = False

    def has_signal(self) -> bool:
        return self.has_come

    def hold(self) -> None:
        pass


class NoWorker:
    """A worker process that does nothing."""

    def __init__(self, threads: int | None) -> None:
        pass

    def start(self, receive: Callable[[Report], None]) -> None:
        pass

    def send(self, message: FitJob | Stop) -> None:
        pass

    def restart(self) -> None:
        pass

    def end(self) -> None:
        pass


def test_a_signal_ends_a_server_that_still_works_and_sends(monkeypatch: pytest.MonkeyPatch) -> None:
    works, may_end = threading.Event(), threading.Event()

    def work(*arguments: object, **options: object) -> bytes:
        works.set()
        may_end.wait(limit(120))
        return b""

    monkeypatch.setattr(routes, "encode", work)
    monkeypatch.setattr(server, "WorkerProcess", NoWorker)
    identity, signals, addresses = Identity("5a" * 32), Signals(), []
    begun = threading.Event()

    def on_start(address: str, ticket: str) -> None:
        addresses.append(address)
        begun.set()

    options = {"folder": None, "threads": 1, "on_start": on_start, "signals": signals}
    with open_socket(0) as listener:
        port = listener.getsockname()[1]
        serving = threading.Thread(target=server.run_server, args=(listener, identity), kwargs=options, daemon=True)
        serving.start()
        assert begun.wait(limit())

        path = f"/{identity.token}"
        tasks = [(port, "POST", f"{path}/export?format=svg", b"<svg/>"), (port, "GET", f"{path}/events?page=a", None)]
        asking = [threading.Thread(target=ask, args=task) for task in tasks]
        for thread in asking:
            thread.start()
        assert works.wait(limit())
        signals.has_come = True
        serving.join(limit())
        has_ended = not serving.is_alive()
        may_end.set()
        for thread in asking:
            thread.join(limit())
    assert has_ended


def ask(port: int, method: str, path: str, body: bytes | None) -> None:
    """Read the whole answer of the server, which may end before that."""
    with closing(http.client.HTTPConnection("127.0.0.1", port, timeout=limit())) as connection:
        connection.request(method, path, body)
        with suppress(OSError, http.client.HTTPException):
            connection.getresponse().read()
