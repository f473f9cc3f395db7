"""Drive a page of ``warpvec view`` in a real Chromium, as a user does."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from children import limit

from warpvec.viewer.page import write_page

NAMES = ("chromium", "chromium-browser", "google-chrome")

CHROMIUM = os.environ.get("WARPVEC_CHROMIUM") or next(filter(None, map(shutil.which, NAMES)), None)
"""Path of the browser that WARPVEC_CHROMIUM names, or of an installed one."""


def _why_no_browser() -> str | None:
    if find_spec("playwright") is None:
        return "playwright is not installed"
    return None if CHROMIUM else "no chromium in the PATH or in WARPVEC_CHROMIUM"


NEEDS_BROWSER = [
    pytest.mark.slow,
    pytest.mark.skipif(_why_no_browser() is not None, reason=str(_why_no_browser())),
]
"""Marks of a module whose tests take the fixtures below, which it imports."""


@pytest.fixture(scope="module", name="browser")
def browser_fixture() -> Iterator[Any]:
    """Start a headless Chromium for a module; for the whole session its event loop would disturb other tests."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as driver:
        chromium = driver.chromium.launch(executable_path=CHROMIUM)
        yield chromium
        chromium.close()


@pytest.fixture(name="open_page")
def open_page_fixture(browser: Any, tmp_path: Path) -> Iterator[Callable[..., Viewer]]:
    """Open drawings; at the end, assert that no page reported an error or requested anything from outside."""
    viewers: list[Viewer] = []

    def opened(svg: str, **options: Any) -> Viewer:
        viewers.append(Viewer(browser, tmp_path, svg, **options))
        return viewers[-1]

    yield opened
    for viewer in viewers:
        viewer.close()


def window_positions(page: Any, points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Return the window positions of ``points`` of the drawing that ``page`` shows."""
    script = """() => {
        const surface = document.getElementById("surface"), { left, top } = surface.getBoundingClientRect();
        const [scale, x, y] = surface.dataset.view.split(" ").map(Number);
        return [scale, x + left, y + top];
    }"""
    scale, left, top = page.evaluate(script)
    return [(left + scale * x, top + scale * y) for x, y in points]


class Viewer:
    """A drawing in a page of its own, which records the errors and outside requests of the page.

    Args:
        browser: Playwright's.
        folder: folder of the page and of the files saved from it.
        svg: the drawing.
        options: further arguments of `write_page`.
    """

    def __init__(self, browser: Any, folder: Path, svg: str, scheme: str = "light", **options: Any) -> None:
        self.folder = folder
        html = folder / "drawing.html"
        write_page(html, svg.encode(), **options)
        viewport = {"width": 1200, "height": 800}
        self.page = browser.new_page(viewport=viewport, accept_downloads=True, color_scheme=scheme)
        self.page.set_default_timeout(1000 * limit(10))
        self.complaints: list[str] = []
        self.page.on("console", self._note_message)
        self.page.on("pageerror", lambda error: self.complaints.append(str(error)))
        self.page.on("request", self._note_request)
        self.page.goto(html.as_uri())
        self.page.wait_for_selector("body[data-ready]")
        self.settle()

    def _note_message(self, message: Any) -> None:
        """Keep errors. Hints of the browser about its own speed come and go with the machine."""
        if message.type == "error":
            self.complaints.append(f"{message.text} ({message.location.get('url')})")

    def _note_request(self, request: Any) -> None:
        if not request.url.startswith(("file:", "data:", "blob:")):
            self.complaints.append(request.url)

    def settle(self) -> None:
        """Wait for the next frame, in which the page draws all earlier changes."""
        self.page.evaluate("() => new Promise(requestAnimationFrame)")

    def text(self, identifier: str) -> str:
        self.settle()
        return self.page.inner_text(f"#{identifier}")

    def at(self, x: float, y: float) -> tuple[float, float]:
        """Return the window position of the point x, y of the drawing."""
        return self.all_at([(x, y)])[0]

    def all_at(self, points: list[tuple[float, float]]) -> list[tuple[float, float]]:
        """Return the window positions of points of the drawing."""
        return window_positions(self.page, points)

    def click(self, x: float, y: float, *modifiers: str) -> str:
        """Click on the drawing and return the text about the selection."""
        for key in modifiers:
            self.page.keyboard.down(key)
        self.page.mouse.click(*self.at(x, y))
        for key in modifiers:
            self.page.keyboard.up(key)
        return self.selected()

    def drag(self, *points: tuple[float, float]) -> None:
        """Press at the first point of the drawing, move along the others, and release."""
        self.page.mouse.move(*self.at(*points[0]))
        self.page.mouse.down()
        for point in points[1:]:
            self.page.mouse.move(*self.at(*point), steps=8)
        self.page.mouse.up()
        self.settle()

    def press(self, *keys: str) -> None:
        for key in keys:
            self.page.keyboard.press(key)
        self.settle()

    def slide(self, identifier: str, value: str) -> None:
        """Set a control as a drag does, and release it."""
        self.page.locator(f"#{identifier}").fill(value)
        self.page.locator(f"#{identifier}").dispatch_event("change")
        self.settle()

    def press_button(self, identifier: str) -> None:
        self.page.locator(f"#{identifier}").click()
        self.settle()

    def choose(self, identifier: str, label: str) -> None:
        self.page.locator(f"#{identifier}").select_option(label=label)
        self.settle()

    def selected(self) -> str:
        return self.text("selected")

    def color(self, x: float, y: float) -> tuple[int, ...]:
        """Return red, green and blue that the page shows at a point of the drawing."""
        return self.colors([(x, y)])[0]

    def colors(self, points: list[tuple[float, float]]) -> list[tuple[int, ...]]:
        """Return red, green and blue that the page shows at points of the drawing."""
        self.settle()
        script = """(points) => {
            const art = document.getElementById("art"), { left, top } = art.getBoundingClientRect();
            const scratch = new OffscreenCanvas(art.width, art.height).getContext("2d", { willReadFrequently: true });
            scratch.drawImage(art, 0, 0);
            const at = ([x, y]) => scratch.getImageData(Math.floor(x - left), Math.floor(y - top), 1, 1).data;
            return points.map((point) => [...at(point).slice(0, 3)]);
        }"""
        return [tuple(color) for color in self.page.evaluate(script, self.all_at(points))]

    def saved(self) -> str:
        """Save with Ctrl+S and return the text of the file."""
        self.settle()
        with self.page.expect_download() as download:
            self.page.keyboard.press("Control+s")
        path = self.folder / download.value.suggested_filename
        download.value.save_as(path)
        return path.read_text(encoding="utf-8")

    def close(self) -> None:
        """Close the page, and assert that it reported no error and requested nothing from outside."""
        self.page.close()
        assert not self.complaints, self.complaints
