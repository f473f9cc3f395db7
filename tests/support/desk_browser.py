"""Drive ``warpvec app`` in a real Chromium: the command as a process, and its page as a user uses it."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from browser import CHROMIUM, window_positions
from children import limit, start

from warpvec.app.address import open_socket

WAIT_SECONDS = 240.0
"""Longest wait for a fit, on a machine with a free core."""


THUMB_PX = 16
"""Width of the thumb of a slider in Chromium."""

NOTE_STATUS = """document.addEventListener("DOMContentLoaded", () => {
    window.statuses = [];
    const status = document.getElementById("fit-status");
    const note = () => window.statuses.push(status.textContent);
    new MutationObserver(note).observe(status, { childList: true, characterData: true, subtree: true });
});"""
"""Notes all that the page says of its fits: a short one comes and goes between two looks at the page."""


class DeskServer:
    """``warpvec app --no-browser`` as a process.

    Args:
        folder: of the pictures, or None.
        runtime: folder of the key.
        port: where it listens; None for a free one.
    """

    def __init__(self, runtime: Path, folder: Path | None = None, port: int | None = None) -> None:
        self.runtime, self.folder = runtime, folder
        if port is None:
            with open_socket(0) as listener:
                port = listener.getsockname()[1]
        self.port = port
        self.start()

    def start(self) -> None:
        """Start the process, also after it was killed, and wait for its address."""
        command = [sys.executable, "-m", "warpvec", "app", "--no-browser", "--port", str(self.port), "--threads", "1"]
        more = [] if self.folder is None else [str(self.folder)]
        environment = {**os.environ, "XDG_RUNTIME_DIR": str(self.runtime)}
        self.process = start([*command, *more], stderr=subprocess.PIPE, text=True, env=environment)
        assert self.process.stderr is not None
        line = self.process.stderr.readline()
        found = re.search(r"http://127\.0\.0\.1:\d+/[\w-]{32}/", line)
        assert found, line + self.process.stderr.read()
        self.url = found[0]

    def end(self, number: int = signal.SIGINT) -> int:
        """Send a signal and return the exit code."""
        self.process.send_signal(number)
        code = self.process.wait(limit(30))
        assert self.process.stderr is not None
        self.process.stderr.close()
        return code

    def restart(self) -> None:
        """Kill the server, and start it again."""
        self.end(signal.SIGKILL)
        self.start()

    def children(self) -> list[int]:
        """Return the processes that the server has started."""
        path = Path(f"/proc/{self.process.pid}/task/{self.process.pid}/children")
        return [int(text) for text in path.read_text().split()]


class DeskPage:
    """A tab with the page, which records its errors and its requests to other hosts."""

    def __init__(self, browser: Any, server: DeskServer, folder: Path, **options: Any) -> None:
        viewport = {"width": 1280, "height": 850}
        self._watch(browser.new_page(**{"viewport": viewport, "accept_downloads": True, **options}), server, folder)
        self.page.goto(server.url)
        self.page.wait_for_selector("body[data-desk]")

    @classmethod
    def of(cls, page: Any, other: DeskPage) -> DeskPage:
        """Return a tab that was opened by the page of ``other``."""
        desk = cls.__new__(cls)
        desk._watch(page, other.server, other.folder)
        desk.page.reload()  # so that it notes all
        desk.page.wait_for_selector("body[data-desk]")
        return desk

    def _watch(self, page: Any, server: DeskServer, folder: Path) -> None:
        self.page, self.server, self.folder = page, server, folder
        self.page.set_default_timeout(1000 * limit(WAIT_SECONDS))
        self.complaints: list[str] = []
        self.page.on("console", self._note_message)
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("request", self._note_request)
        self.dialogs: list[str] = []
        self.page.on("dialog", self._accept)
        self.page.add_init_script(NOTE_STATUS)

    def _note_message(self, message: Any) -> None:
        """Keep errors. Hints of the browser about its own speed come and go with the machine."""
        if message.type == "error":
            self.complaints.append(f"{message.text} ({message.location.get('url')})")

    def _accept(self, dialog: Any) -> None:
        self.dialogs.append(dialog.type)
        dialog.accept()

    def _note_request(self, request: Any) -> None:
        own = (self.server.url, f"http://127.0.0.1:{self.server.port}/proof?nonce=")
        if not request.url.startswith((*own, "data:", "blob:")):
            self.complaints.append(request.url)

    def drop(self, *files: Path) -> None:
        """Drop files on the page, as a file manager does."""
        data = [{"name": file.name, "bytes": list(file.read_bytes())} for file in files]
        script = """(files) => {
            const transfer = new DataTransfer();
            const type = (name) => (name.endsWith("jpg") ? "image/jpeg" : "image/png");
            for (const { name, bytes } of files) {
                transfer.items.add(new File([new Uint8Array(bytes)], name, { type: type(name) }));
            }
            const options = { dataTransfer: transfer, bubbles: true, cancelable: true };
            for (const kind of ["dragover", "drop"]) document.body.dispatchEvent(new DragEvent(kind, options));
        }"""
        self.page.evaluate(script, data)

    def status(self) -> str:
        return str(self.page.inner_text("#fit-status"))

    def states(self) -> list[str]:
        """Return name and state of each picture in the list."""
        return [" ".join(text.split("\n")[:2]) for text in self.page.locator("#pictures li").all_inner_texts()]

    def wait_for_status(self, words: str) -> None:
        script = "(words) => document.getElementById('fit-status').textContent.includes(words)"
        self.page.wait_for_function(script, arg=words)

    def begins_to_draw(self, seen: int) -> None:
        """Wait until the page has said that a fit starts, and then that it draws, since its first ``seen`` words."""
        script = """(seen) => {
            const later = window.statuses.slice(seen);
            const start = later.findIndex((text) => text.startsWith("Starting"));
            return start >= 0 && later.slice(start).some((text) => text.startsWith("Drawing"));
        }"""
        self.page.wait_for_function(script, arg=seen)

    @contextmanager
    def fitting(self) -> Iterator[None]:
        """Wait at the end of the block until a fit that began in it is done."""
        count = self.page.evaluate("() => window.statuses.length")
        yield
        script = """(count) => {
            const later = window.statuses.slice(count);
            return later.some((text) => /^(Starting|Waiting|Drawing)/.test(text)) && later.at(-1).includes("done");
        }"""
        self.page.wait_for_function(script, arg=count)

    def wait_for_frame(self, psnr: float = 0.0) -> None:
        """Wait for a frame of a running fit, of at least ``psnr`` dB."""
        script = """(psnr) => {
            const text = document.getElementById("fit-figures").textContent.match(/Closeness([\\d.]+)/);
            return window.warpvecView.state.live && text && Number(text[1]) >= psnr;
        }"""
        self.page.wait_for_function(script, arg=psnr)

    def slide(self, identifier: str, value: int) -> None:
        self.page.locator(f"#{identifier}").fill(str(value))

    def drag_slider(self, identifier: str, value: int) -> None:
        """Drag the thumb of a slider with the mouse until it stands at ``value``."""
        slider = self.page.locator(f"#{identifier}")
        slider.scroll_into_view_if_needed()
        low, high, now = slider.evaluate("({ min, max, value }) => [min, max, value].map(Number)")
        box = slider.bounding_box()
        assert box is not None
        travel = box["width"] - THUMB_PX

        def place(at: float) -> tuple[float, float]:
            share = (at - low) / (high - low)
            return box["x"] + THUMB_PX / 2 + share * travel, box["y"] + box["height"] / 2

        self.page.mouse.move(*place(now))
        self.page.mouse.down()
        self.page.mouse.move(*place(value), steps=5)
        self.page.mouse.up()

    def paths(self) -> int:
        return int(self.page.evaluate("() => window.warpvecView.state.paths"))

    def click(self, x: float, y: float) -> None:
        """Click on the point x, y of the drawing."""
        self.page.mouse.click(*window_positions(self.page, [(x, y)])[0])

    def drag(self, *points: tuple[float, float]) -> None:
        """Press at the first point of the drawing, move along the others, and release."""
        for i, place in enumerate(window_positions(self.page, list(points))):
            self.page.mouse.move(*place, steps=6)
            if i == 0:
                self.page.mouse.down()
        self.page.mouse.up()

    def caret_gap(self, x: float, y: float) -> list[float]:
        """Return the pixels to the right and down from the cross for keys to the point x, y of the drawing."""
        script = """([x, y]) => {
            const { view, caret } = document.getElementById("surface").dataset;
            const [[scale, left, top], [column, row]] = [view, caret].map((text) => text.split(" ").map(Number));
            return [left + scale * x - column, top + scale * y - row];
        }"""
        return list(self.page.evaluate(script, [x, y]))

    def color(self, x: float, y: float) -> tuple[int, ...]:
        """Return red, green and blue that the page shows at the point x, y of the drawing."""
        script = """async ([x, y]) => {
            await new Promise(requestAnimationFrame);
            await new Promise(requestAnimationFrame);
            const [scale, left, top] = document.getElementById("surface").dataset.view.split(" ").map(Number);
            const scratch = new OffscreenCanvas(1, 1).getContext("2d");
            const [column, row] = [Math.floor(left + scale * x), Math.floor(top + scale * y)];
            scratch.drawImage(document.getElementById("art"), -column, -row);
            return [...scratch.getImageData(0, 0, 1, 1).data.slice(0, 3)];
        }"""
        return tuple(self.page.evaluate(script, [x, y]))

    def save(self, kind: str = "svg") -> Path:
        """Save with the button of a format and return the file."""
        with self.page.expect_download() as download:
            self.page.locator(f"[data-format={kind}]").click()
        path = self.folder / f"{time.monotonic_ns()}-{download.value.suggested_filename}"
        download.value.save_as(path)
        return path

    def close(self) -> None:
        """Close the tab, and assert that it reported no error and asked no other host."""
        self.page.close()
        assert not self.complaints, self.complaints


@pytest.fixture(scope="module", name="desk_server")
def desk_server_fixture(tmp_path_factory: pytest.TempPathFactory) -> Iterator[DeskServer]:
    """Run one server for a module."""
    server = DeskServer(tmp_path_factory.mktemp("runtime"))
    yield server
    assert server.end() == 130


@pytest.fixture(name="desk")
def desk_fixture(browser: Any, desk_server: DeskServer, tmp_path: Path) -> Iterator[DeskPage]:
    """Open a tab for a test."""
    page = DeskPage(browser, desk_server, tmp_path)
    yield page
    page.close()


__all__ = ["CHROMIUM", "DeskPage", "DeskServer", "desk_fixture", "desk_server_fixture"]
