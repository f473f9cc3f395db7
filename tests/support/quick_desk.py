"""The server of ``warpvec app`` with a worker that answers at once from drawings that were made before.

The page, the requests, the queue and the events are the real ones, so that many sequences of what a user does can be
tried. Only the fits are not: a job gets the drawing of its settings, or its own start if it is to be fitted again.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest
from children import limit
from PIL import Image, ImageDraw

from warpvec.app import server as server_module
from warpvec.app.address import open_socket
from warpvec.app.fitting import run_job
from warpvec.app.identity import Identity
from warpvec.app.messages import FitJob, Report, Stop
from warpvec.image.metrics import psnr
from warpvec.image.read import read_image
from warpvec.svg.measure import draw_like, file_facts
from warpvec.watch.watch import Watch

FRAME_SECONDS, DONE_SECONDS = 0.03, 0.12
"""Times after the start of a fit at which it has a frame and a result."""


def logo_bytes() -> bytes:
    """Return a PNG of four shapes on white, of which two overlap a third one."""
    image = Image.new("RGB", (960, 640), "white")
    pen = ImageDraw.Draw(image)
    pen.ellipse((80, 80, 480, 480), fill="#2e9b4f")
    pen.ellipse((180, 180, 320, 320), fill="#f2c230")
    pen.rectangle((400, 240, 800, 400), fill="#1c4fa0")
    pen.polygon([(600, 440), (880, 440), (740, 600)], fill="#c02030")
    stream = BytesIO()
    image.resize((240, 160), Image.Resampling.BOX).save(stream, "PNG")
    return stream.getvalue()


class QuickWorker:
    """A worker that knows the drawings of the logo for both states of "Cut out"."""

    drawings: dict[bool, dict[str, Any]] = {}

    def __init__(self, threads: int | None) -> None:
        self.timers: dict[int, list[threading.Timer]] = {}

    def start(self, receive: Callable[[Report], None]) -> None:
        import asyncio

        loop = asyncio.get_running_loop()
        self.report = lambda *facts: loop.call_soon_threadsafe(receive, Report(*facts))
        self.report("ready", 0)

    def send(self, message: FitJob | Stop) -> None:
        if isinstance(message, Stop):
            for timer in self.timers.pop(message.number, []):
                timer.cancel()
            kind = "dropped" if message.is_dropped else "done"
            self.report(kind, message.number, {**self.found, "stopped": True} if kind == "done" else {})
            return
        self.found = self.answer(message)
        frame: dict[str, Any] = {**self.found, "iteration": 1, "iterations": 2, "paths": 1, "left": 1.0}
        del frame["mode"]
        reason = "it has few colours" if message.settings.mode == "auto" else None
        mode = {"mode": "flat", "reason": reason, "width": 240, "height": 160}
        self.report("mode", message.number, mode)
        steps = [(FRAME_SECONDS, "frame", frame), (DONE_SECONDS, "done", self.found)]
        self.timers[message.number] = [
            threading.Timer(seconds, self.report, (kind, message.number, facts)) for seconds, kind, facts in steps
        ]
        for timer in self.timers[message.number]:
            timer.start()

    def answer(self, job: FitJob) -> dict[str, Any]:
        """Return the facts of the drawing for a job."""
        if job.cuts:
            return run_job(job, lambda kind, facts: None, Watch(), 1)
        if job.start is None or not job.keeps_paths:
            return self.drawing(bool(job.settings.values["cutout"]), job)
        target = read_image(job.data)
        measured = {**file_facts(job.start), "psnr": psnr(draw_like(job.start.encode(), target), target)}
        return {**self.drawings[False], **measured, "svg": job.start}

    @classmethod
    def drawing(cls, is_cut: bool, job: FitJob) -> dict[str, Any]:
        if is_cut not in cls.drawings:
            plain = FitJob(job.number, job.data, job.name, job.settings)
            cls.drawings[is_cut] = run_job(plain, lambda kind, facts: None, Watch(), 1)
        return cls.drawings[is_cut]

    def restart(self) -> None:
        pass

    def end(self) -> None:
        for timer in (timer for timers in self.timers.values() for timer in timers):
            timer.cancel()


class _Signals:
    has_come = False

    def has_signal(self) -> bool:
        return self.has_come

    def hold(self) -> None:
        pass


class QuickServer:
    """The server in a thread of the test; see `desk_browser.DeskServer`."""

    def __init__(self) -> None:
        self.port = 0
        self.start()

    def restart(self) -> None:
        """End the server, and start another one on the same port, which knows nothing of the pages."""
        self.end()
        self.start()

    def start(self) -> None:
        """Start the server, and wait for its address."""
        listener = open_socket(self.port)
        self.port = listener.getsockname()[1]
        self._signals, started = _Signals(), threading.Event()

        def begin(url: str, ticket: str) -> None:
            self.url = url
            started.set()

        def run() -> None:
            identity = Identity("5a" * 32)
            options = {"folder": None, "threads": 1, "on_start": begin, "signals": self._signals}
            server_module.run_server(listener, identity, **options)

        self._thread = threading.Thread(target=run, daemon=True)
        self._thread.start()
        assert started.wait(limit(60))

    def end(self) -> None:
        self._signals.has_come = True
        self._thread.join(limit(60))


@pytest.fixture(scope="module", name="quick_server")
def quick_server_fixture() -> Iterator[QuickServer]:
    """Run one server for a module."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(server_module, "WorkerProcess", QuickWorker)
        server = QuickServer()
        yield server
        server.end()


def write_logo(path: Path) -> Path:
    path.write_bytes(logo_bytes())
    return path
