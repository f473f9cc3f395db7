"""The open pages: their streams of events, and when a page that has left is forgotten.

A page that is hidden may give up its stream, since a browser opens only six connections to a server. It is kept as long
as it has not said that it is closed.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from typing import Any

from warpvec.app.streams import Stream

FORGET_SECONDS = 60.0
"""Time after which a closed page is forgotten: long enough to reload it."""

REST_SECONDS = 86_400.0
"""The same for a hidden page: a working day and a night. It says when it is closed, unless its browser has crashed."""


class Pages:
    """Streams of events by page. All methods run in the event loop.

    Args:
        forget: called with a page that does not come back.
    """

    def __init__(self, forget: Callable[[str], None]) -> None:
        self._forget = forget
        self._streams: dict[str, set[Stream]] = {}
        self._resting: set[str] = set()
        self._timers: dict[str, asyncio.TimerHandle] = {}

    def __iter__(self) -> Iterator[str]:
        """Yield the pages that listen."""
        return iter(self._streams)

    def expect(self, page: str) -> None:
        """Forget ``page`` after a while unless it listens, or is hidden."""
        if page not in self._streams and page not in self._timers:
            self._forget_after(page, FORGET_SECONDS)

    def join(self, page: str) -> Stream:
        """Return a new stream of events for ``page``."""
        self._resting.discard(page)
        self._stop_timer(page)
        stream = Stream()
        self._streams.setdefault(page, set()).add(stream)
        return stream

    def leave(self, page: str, stream: Stream) -> None:
        """Drop a stream. If it was the last one of its page, that is forgotten after a while."""
        streams = self._streams.get(page, set())
        streams.discard(stream)
        if not streams:
            self._streams.pop(page, None)
            self._forget_after(page, REST_SECONDS if page in self._resting else FORGET_SECONDS)

    def rest(self, page: str) -> None:
        """Note that ``page`` is hidden and has given up its stream, which may be seen later or earlier than this."""
        if page in self._streams:
            self._resting.add(page)
        elif page in self._timers:
            self._forget_after(page, REST_SECONDS)

    def close(self, page: str) -> None:
        """Note that ``page``, which was hidden, is closed or loaded again."""
        if page in self._timers:
            self._forget_after(page, FORGET_SECONDS)

    def send(self, page: str, kind: str, facts: dict[str, Any]) -> None:
        """Send an event to ``page``; see `Stream.put`."""
        for stream in self._streams.get(page, ()):
            stream.put(kind, facts)

    def end(self) -> None:
        """End all streams: the server ends."""
        for streams in self._streams.values():
            for stream in streams:
                stream.end()

    def _forget_after(self, page: str, seconds: float) -> None:
        self._stop_timer(page)
        self._timers[page] = asyncio.get_running_loop().call_later(seconds, self._end, page)

    def _stop_timer(self, page: str) -> None:
        timer = self._timers.pop(page, None)
        if timer is not None:
            timer.cancel()

    def _end(self, page: str) -> None:
        del self._timers[page]
        self._resting.discard(page)
        self._forget(page)
