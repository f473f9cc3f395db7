"""Connections that bring no request, or half a one, do not take up room for long."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable

import pytest
import uvicorn
from children import limit

from warpvec.app import server
from warpvec.app.address import open_socket

REQUEST = b"GET / HTTP/1.1\r\nHost: x\r\n\r\n"


async def app(
    scope: dict[str, object], receive: Callable[[], Awaitable[object]], send: Callable[..., Awaitable[None]]
) -> None:
    """Answer "ok" to every request."""
    await send({"type": "http.response.start", "status": 200, "headers": [(b"content-length", b"2")]})
    await send({"type": "http.response.body", "body": b"ok"})


async def talk(port: int, *pieces: bytes) -> bytes:
    """Send pieces with a pause after each, and return all that the server answers until it ends the connection."""
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    try:
        for piece in pieces:
            writer.write(piece)
            await writer.drain()
            await asyncio.sleep(0.1)
        return await asyncio.wait_for(_rest(reader), limit(10))
    finally:
        writer.close()


async def _rest(reader: asyncio.StreamReader) -> bytes:
    found = b""
    try:
        while piece := await reader.read(1000):
            found += piece
    except ConnectionError:
        pass
    return found


@pytest.mark.parametrize(
    ("pieces", "answers"),
    [
        ((), 0),
        ((REQUEST[:9],), 0),
        ((REQUEST[:9], REQUEST[9:], b"G"), 1),
        ((REQUEST, REQUEST[:9], REQUEST[9:12]), 1),
        ((REQUEST, REQUEST, REQUEST[:9]), 2),
    ],
)
def test_half_a_request_ends_a_connection(
    monkeypatch: pytest.MonkeyPatch, pieces: tuple[bytes, ...], answers: int
) -> None:
    monkeypatch.setattr(server, "SILENT_SECONDS", limit(0.4))  # longer than the pauses of `talk`, on a busy machine too

    async def run() -> bytes:
        with open_socket(0) as listener:
            listener.listen()
            # Idle connections must not end by themselves here, so that only ours ends them.
            config = uvicorn.Config(
                app, http=server._Connection, lifespan="off", log_level="error", timeout_keep_alive=600
            )
            running = server._Server(config)
            serving = asyncio.create_task(running.serve([listener]))
            try:
                return await talk(listener.getsockname()[1], *pieces)
            finally:
                running.should_exit = True
                await serving

    assert asyncio.run(run()).count(b"ok") == answers
