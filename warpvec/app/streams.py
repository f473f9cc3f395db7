"""A stream of server-sent events to one page, which never holds more than the newest of each kind."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from typing import Any

BEAT_SECONDS = 10.0
"""Time without events after which a comment is sent, so that a broken connection is noticed."""

RETRY_MS = 1000
"""Time after which a page that has lost the server tries again."""


class Stream:
    """Events that a page has not received yet. A page that is behind gets only the newest frame of a picture."""

    def __init__(self) -> None:
        self._events: dict[str, tuple[str, dict[str, Any]]] = {}
        self._news = asyncio.Event()
        self._has_ended = False

    def put(self, kind: str, facts: dict[str, Any]) -> None:
        """Add an event; one of the same kind and picture that has not been sent is left out."""
        key = f"{kind} {facts.get('id')}"
        self._events.pop(key, None)  # the new one goes to the end
        self._events[key] = (kind, facts)
        self._news.set()

    def end(self) -> None:
        """Send no more events."""
        self._has_ended = True
        self._news.set()

    async def texts(self) -> AsyncIterator[bytes]:
        """Yield the events as a page receives them, until `end`."""
        yield f"retry: {RETRY_MS}\n\n".encode()
        while not self._has_ended:
            if not self._events:
                try:
                    await asyncio.wait_for(self._news.wait(), BEAT_SECONDS)
                except TimeoutError:
                    yield b": still here\n\n"
            self._news.clear()
            while self._events:
                key = next(iter(self._events))
                kind, facts = self._events.pop(key)
                yield f"event: {kind}\ndata: {json.dumps(facts, allow_nan=False)}\n\n".encode()
