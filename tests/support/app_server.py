"""The server of ``warpvec app`` without a port and without a worker process: a test plays the worker."""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from httpx import ASGITransport, AsyncClient, Response

from warpvec.app.desk import Desk
from warpvec.app.guard import Guard
from warpvec.app.identity import Identity
from warpvec.app.messages import FitJob, Report, Stop
from warpvec.app.routes import Routes
from warpvec.app.streams import Stream

PORT = 8437
IDENTITY = Identity("5a" * 32)
TOKEN = IDENTITY.token


class FakeWorker:
    """A worker process that notes what it is sent and reports what a test says."""

    def __init__(self) -> None:
        self.sent: list[FitJob | Stop] = []
        self.restarts = 0

    def send(self, message: FitJob | Stop) -> None:
        self.sent.append(message)

    def restart(self) -> None:
        self.restarts += 1

    @property
    def jobs(self) -> list[FitJob]:
        return [message for message in self.sent if isinstance(message, FitJob)]

    @property
    def stops(self) -> list[Stop]:
        return [message for message in self.sent if isinstance(message, Stop)]


class Server:
    """The server, with ``get`` and ``post`` below its token. All of it runs in the event loop of ``runner``."""

    def __init__(self, runner: asyncio.Runner, folder: Path | None = None) -> None:
        self.runner = runner
        self.worker = FakeWorker()
        self.desk = Desk(self.worker)
        routes = Routes(self.desk, folder, ["svg", "svgz", "png"], IDENTITY.key)
        self.guard = Guard(routes.application(), PORT, IDENTITY)
        transport = ASGITransport(self.guard)
        self.client = AsyncClient(transport=transport, base_url=f"http://127.0.0.1:{PORT}")

    def ask(self, method: str, path: str, **options: Any) -> Response:
        """Return the answer to a request for any path."""
        return self.runner.run(self.client.request(method, path, **options))

    def get(self, path: str) -> Response:
        return self.ask("GET", f"/{TOKEN}/{path}")

    def post(self, path: str, body: bytes | dict[str, Any] = b"") -> Response:
        content = {"json": body} if isinstance(body, dict) else {"content": body}
        return self.ask("POST", f"/{TOKEN}/{path}", **content)

    def delete(self, path: str) -> Response:
        return self.ask("DELETE", f"/{TOKEN}/{path}")

    def report(self, kind: str, number: int = 0, **facts: Any) -> None:
        """Let the worker report."""
        self.act(lambda: self.desk.receive(Report(kind, number, facts)))

    def act(self, action: Callable[[], Any]) -> Any:
        """Run a function of the desk inside the event loop, as the server does."""

        async def run() -> Any:
            return action()

        return self.runner.run(run())

    def events(self, stream: Stream, count: int) -> list[tuple[str, dict[str, Any]]]:
        """Return name and facts of the next ``count`` events of a stream."""

        async def read() -> list[tuple[str, dict[str, Any]]]:
            found: list[tuple[str, dict[str, Any]]] = []
            async for text in stream.texts():
                if text.startswith(b"event: "):
                    first, second = text.decode().strip().split("\n")
                    found.append((first.removeprefix("event: "), json.loads(second.removeprefix("data: "))))
                if len(found) == count:
                    break
            return found

        return self.runner.run(read())


@pytest.fixture(name="server")
def server_fixture(tmp_path: Path) -> Iterator[Server]:
    """Serve the folder of the test."""
    with asyncio.Runner() as runner:
        server = Server(runner, tmp_path)
        yield server
        runner.run(server.client.aclose())
