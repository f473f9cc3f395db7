"""The state of the server: pictures in memory, the queue of fits, and the pages that watch.

One fit runs at a time. A picture has at most one waiting fit, the newest that was asked for. Nothing is written: what
the page does not save is gone when the server ends, or soon after its page is closed.
"""

from __future__ import annotations

import asyncio
import secrets
import time
from dataclasses import dataclass, field
from typing import Any, Protocol

from warpvec.app.messages import FitJob, Report, Stop
from warpvec.app.pages import Pages
from warpvec.app.settings import FitSettings
from warpvec.app.streams import Stream

KEPT_BYTES = 2**30
"""Bytes of all pictures' files together. A new one beyond that is refused."""

STOP_SECONDS = 15.0
"""Time that a fit has to stop; stages of flat art cannot stop earlier. Then its process is ended."""

DROP_SECONDS = 3.0
"""The same if nobody wants the result."""


class FitProcess(Protocol):
    """What the desk needs of a worker process."""

    def send(self, message: FitJob | Stop) -> None:
        """Hand ``message`` to the process that fits."""

    def restart(self) -> None:
        """End the process that fits, and start another."""


@dataclass
class PagePicture:
    """A picture that a page has sent, and the fit that waits for it or is under way."""

    identifier: str
    run: str
    """The run of the server that has it, and its number among all pictures of that run."""
    number: int
    page: str
    key: str
    """The page's own name for it."""
    name: str
    data: bytes = field(repr=False)
    width: int
    height: int
    status: str = "idle"
    """"idle", "waiting", "fitting", "done", "stopped" or "failed"."""
    job: FitJob | None = None
    fit: int = 0
    """The page's own number for the job, which is in all that is told of it: news of another fit may be on its way."""
    last: dict[str, dict[str, Any]] = field(default_factory=dict)
    """The last facts of each kind of report, for a page that is loaded again."""
    share: float = 0.0
    """Share of a whole fit that the present drawing has had."""

    def facts(self) -> dict[str, Any]:
        """Return what a page shows of the picture in its list."""
        size = {"width": self.width, "height": self.height}
        own = {"id": self.identifier, "run": self.run, "number": self.number, "key": self.key}
        return {**own, "name": self.name, "status": self.status, "fit": self.fit, **size}


class Desk:
    """Pictures, the queue and the watching pages. All methods run in the event loop.

    Args:
        worker: the worker process, which reports to `receive`.
    """

    def __init__(self, worker: FitProcess) -> None:
        self.pictures: dict[str, PagePicture] = {}
        self.is_ready = False
        self.pages = Pages(self._forget)
        self._waiting: list[PagePicture] = []
        self._running: PagePicture | None = None
        self._run, self._count = secrets.token_hex(8), 0
        self._number = 0
        self._dropped: set[int] = set()
        self._deadline: asyncio.TimerHandle | None = None
        self._is_broken = False
        self._worker = worker

    # Pages

    def watch(self, page: str) -> Stream:
        """Return a stream of events for ``page``, which begins with all that it has to know."""
        stream = self.pages.join(page)
        own = [picture for picture in self.pictures.values() if picture.page == page]
        # A page may learn this after the answer for a picture that came later, which it tells by the number.
        moment = {"run": self._run, "count": self._count}
        stream.put("hello", {"ready": self.is_ready, **moment, "pictures": [p.facts() for p in own]})
        for picture in own:
            for kind, facts in picture.last.items():
                stream.put(kind, {"id": picture.identifier, **facts})
            self._set_status(picture, picture.status)  # after the drawing, as always
        self._tell_queue()
        return stream

    def _forget(self, page: str) -> None:
        """Forget the pictures of a page that does not come back."""
        for identifier in [p.identifier for p in self.pictures.values() if p.page == page]:
            self.remove(identifier)

    # Pictures

    def has_room(self, size: int) -> bool:
        """Return whether a picture of ``size`` bytes may be kept beside the others."""
        return size + sum(len(picture.data) for picture in self.pictures.values()) <= KEPT_BYTES

    def add(self, page: str, key: str, name: str, data: bytes, size: tuple[int, int]) -> PagePicture:
        """Keep a picture of ``size`` (width, height) that ``page`` has sent, which has a ``key`` of its own for it."""
        self._count += 1
        picture = PagePicture(secrets.token_hex(8), self._run, self._count, page, key, name, data, *size)
        self.pictures[picture.identifier] = picture
        self.pages.expect(page)
        return picture

    def remove(self, identifier: str) -> None:
        """Forget a picture; its fit ends."""
        picture = self.pictures.pop(identifier)
        self._withdraw(picture)
        self._tell_queue()

    # Fits

    def fit(self, picture: PagePicture, number: int, settings: FitSettings, **more: Any) -> None:
        """Put a fit of ``picture`` into the queue; it replaces the one that waits or runs.

        Args:
            number: the page's own one for it.
            settings: what the page asks for.
            more: further fields of a `FitJob`.
        """
        is_first = picture is self._running
        self._withdraw(picture)
        self._number += 1
        share = picture.share if more.get("start") is not None else 0.0
        picture.job = FitJob(self._number, picture.data, picture.name, settings, done_share=share, **more)
        picture.share, picture.fit = share, number
        picture.last.clear()
        self._waiting.insert(0 if is_first else len(self._waiting), picture)
        self._set_status(picture, "waiting")
        if self._is_broken:  # the user tries again, and so does the server
            self._restart()
        self._start_next()
        self._tell_queue()

    def stop(self, picture: PagePicture) -> None:
        """End the fit of ``picture``: with its best drawing so far if it runs, with nothing if it still waits."""
        if picture is self._running and picture.job is not None:
            self._worker.send(Stop(picture.job.number))
            self._limit(STOP_SECONDS)
        elif picture in self._waiting:
            self._waiting.remove(picture)
            self._set_status(picture, "stopped")
            self._tell_queue()

    def receive(self, report: Report) -> None:
        """Take a report of the worker process."""
        if report.kind == "ready":
            self.is_ready = True
            for page in self.pages:
                self.pages.send(page, "ready", {})
            self._start_next()
            return
        if report.kind == "died":
            self._replace_dead(report.facts)
            return
        if report.number in self._dropped:
            if report.kind in ("done", "failed", "dropped"):
                self._dropped.discard(report.number)
                self._free()
            return
        picture = self._running
        if picture is None or picture.job is None or picture.job.number != report.number:
            return
        if report.kind == "frame":
            iteration, count = report.facts["iteration"], report.facts["iterations"]
            picture.share = picture.job.done_share + (1.0 - picture.job.done_share) * iteration / max(count, 1)
        if report.kind in ("mode", "stage", "frame"):
            self._tell(picture, report.kind, report.facts)
        else:
            self._end_running(report.kind, report.facts)

    def _replace_dead(self, facts: dict[str, Any]) -> None:
        """Start another process after the end of one. One that ended before it was ready would do so again."""
        was_ready, self.is_ready = self.is_ready, False  # so that no fit begins before there is another
        self._end_running("failed", facts)
        if was_ready:
            self._restart()
            return
        self._is_broken = True
        while self._waiting:
            self._running = self._waiting.pop(0)
            self._end_running("failed", facts)

    def _end_running(self, kind: str, facts: dict[str, Any]) -> None:
        picture = self._running
        if picture is None:
            return
        for passing in ("stage", "frame"):
            picture.last.pop(passing, None)
        is_stopped = bool(facts.get("stopped"))
        picture.share = picture.share if is_stopped or kind == "failed" else 1.0
        # The result before the status: a page that says "done" has the drawing that it saves.
        self._tell(picture, kind, facts)
        self._set_status(picture, "stopped" if is_stopped else kind)
        self._free()

    def _free(self) -> None:
        """Let the next fit begin."""
        self._cancel_limit()
        self._running = None
        self._start_next()
        self._tell_queue()

    def _start_next(self) -> None:
        if not self.is_ready or self._running is not None or self._dropped or not self._waiting:
            return
        picture = self._running = self._waiting.pop(0)
        assert picture.job is not None
        self._set_status(picture, "fitting")
        self._worker.send(picture.job)

    def _withdraw(self, picture: PagePicture) -> None:
        """Take the fit of ``picture`` out of the queue, or end it without a result."""
        if picture in self._waiting:
            self._waiting.remove(picture)
        if picture is self._running and picture.job is not None:
            self._worker.send(Stop(picture.job.number, is_dropped=True))
            self._dropped.add(picture.job.number)
            self._running = None
            self._limit(DROP_SECONDS)

    def _limit(self, seconds: float) -> None:
        self._cancel_limit()
        self._deadline = asyncio.get_running_loop().call_later(seconds, self._end_by_force)

    def _cancel_limit(self) -> None:
        if self._deadline is not None:
            self._deadline.cancel()
            self._deadline = None

    def _end_by_force(self) -> None:
        """End a fit that does not stop. Its last frame is its drawing."""
        picture, self._deadline, self.is_ready = self._running, None, False
        frame = None if picture is None else picture.last.get("frame")
        if frame is not None:
            self._end_running("done", {**frame, "psnr": None, "stopped": True})
        else:
            self._end_running("failed", {"message": "it was stopped before there was a drawing"})
        self._restart()

    def _restart(self) -> None:
        self._cancel_limit()  # it was that of the old process
        self._dropped.clear()
        self._is_broken = False
        self._worker.restart()

    # Events

    def _set_status(self, picture: PagePicture, status: str) -> None:
        picture.status = status
        facts = {"id": picture.identifier, "fit": picture.fit, "status": status}
        self.pages.send(picture.page, "status", facts)

    def _tell(self, picture: PagePicture, kind: str, facts: dict[str, Any]) -> None:
        picture.last[kind] = {"fit": picture.fit, **facts}
        self.pages.send(picture.page, kind, {"id": picture.identifier, "at": time.time(), **picture.last[kind]})

    def _tell_queue(self) -> None:
        """Tell each page how many fits are before each of its own."""
        busy = self._running is not None
        for page in self.pages:
            places = {p.identifier: i + busy for i, p in enumerate(self._waiting) if p.page == page}
            self.pages.send(page, "queue", {"places": places})
