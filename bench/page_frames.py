"""Measure the frame rate of the page of `warpvec view` while a drawing is edited, in a headless Chromium.

A drag moves in every frame and a held key repeats in every second one, as from a mouse of 60 Hz and a keyboard of
30 Hz; the page itself makes these events, since a driver's would be too few on a busy machine. A row gives the time
between frames, and the script and task time of the page's main thread per frame, which a busy machine changes less.

    python bench/page_frames.py DRAWING.svg [--image PHOTO] [--width 1200] [--height 800] [--ratio 1]
"""

from __future__ import annotations

import os
import shutil
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import click
import numpy as np
from harness import machine_facts, machine_line, markdown_table

from warpvec.viewer.page import write_page

NAMES = ("chromium", "chromium-browser", "google-chrome")

RECORD = """() => {
    window.frameTimes = [];
    const note = (now) => {
        window.frameTimes.push(now);
        if (window.frameTimes) requestAnimationFrame(note);
    };
    requestAnimationFrame(note);
}"""
DRAG = """async ([x, y, moves]) => {
    const surface = document.getElementById("surface");
    for (let i = 0; i < moves; i++) {
        await new Promise(requestAnimationFrame);
        const place = { clientX: x + 60 * Math.sin(i / 9), clientY: y + 40 * Math.sin(i / 7) };
        surface.dispatchEvent(new PointerEvent("pointermove", { ...place, pointerId: 1, pointerType: "mouse" }));
    }
}"""
HOLD = """async ([key, times, frames]) => {
    for (let i = 0; i < times * frames; i++) {
        await new Promise(requestAnimationFrame);
        if (i % frames) continue;
        document.activeElement.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true }));
    }
}"""
TAKE = "() => { const times = window.frameTimes; window.frameTimes = null; return times; }"
SIZE = """(text) => {
    const { documentElement } = new DOMParser().parseFromString(text, "image/svg+xml");
    return documentElement.getAttribute("viewBox");
}"""
LIVE = """(text) => {
    const before = performance.now();
    window.warpvecView.showDrawing(text);
    return performance.now() - before;
}"""


class Row(NamedTuple):
    """What was measured while an action ran: times in milliseconds; ``script`` and ``task`` are per frame."""

    action: str
    frames: int
    median: float
    p95: float
    longest: float
    script: float
    task: float


class Hand:
    """A user of the page, who drags and holds keys."""

    def __init__(self, page: Any) -> None:
        self.page = page

    def at(self, x: float, y: float) -> tuple[float, float]:
        """Return the window position of a point of the drawing."""
        left, top = self.page.evaluate(
            "() => { const r = document.getElementById('surface').getBoundingClientRect(); return [r.left, r.top]; }"
        )
        view = self.page.locator("#surface").get_attribute("data-view").split()
        scale, dx, dy = map(float, view)
        return left + dx + scale * x, top + dy + scale * y

    def drag(self, x: float, y: float, moves: int = 120) -> None:
        """Drag from a point of the window along a curve, a step in each frame, and release it."""
        mouse = self.page.mouse
        mouse.move(x, y)
        mouse.down()
        self.page.evaluate(DRAG, [x, y, moves])
        mouse.up()

    def hold(self, key: str, times: int = 60, frames: int = 2) -> None:
        """Press a key as often as it repeats while it is held, once in so many frames."""
        self.page.evaluate(HOLD, [key, times, frames])

    def press(self, *keys: str) -> None:
        """Press ``keys`` one after another."""
        for key in keys:
            self.page.keyboard.press(key)

    def point(self) -> tuple[float, float]:
        """Return the window position of the first node that the node tool shows."""
        points = self.page.locator("#surface").get_attribute("data-points").split(",")
        words = next(point.split() for point in points if point.startswith("node"))
        return self.at(float(words[2]), float(words[3]))

    def set(self, identifier: str, value: str) -> None:
        """Enter ``value`` into the field ``identifier``."""
        self.page.locator(f"#{identifier}").fill(value)
        self.page.locator(f"#{identifier}").dispatch_event("change")
        time.sleep(0.1)


class Stopwatch:
    """Measures actions on a page."""

    def __init__(self, page: Any) -> None:
        self.page = page
        self.protocol = page.context.new_cdp_session(page)
        self.protocol.send("Performance.enable")
        self.rows: list[Row] = []

    def _durations(self) -> tuple[float, float]:
        metrics = {entry["name"]: entry["value"] for entry in self.protocol.send("Performance.getMetrics")["metrics"]}
        return 1000 * metrics["ScriptDuration"], 1000 * metrics["TaskDuration"]

    def measure(self, name: str, action: Callable[[], object]) -> None:
        """Note the frames of the page during ``action`` as ``name``."""
        self.page.wait_for_timeout(600)
        before = self._durations()
        self.page.evaluate(RECORD)
        action()
        gaps = np.diff(self.page.evaluate(TAKE))
        script, task = (after - start for after, start in zip(self._durations(), before, strict=True))
        count = len(gaps)
        times = (float(np.median(gaps)), float(np.percentile(gaps, 95)), float(gaps.max()))
        self.rows.append(Row(name, count, *times, script / count, task / count))


def recolour_and_delete(hand: Hand) -> None:
    """Change the colour of the chosen paths, delete them, and take all of it back."""
    hand.set("fill", "#00aaff")
    hand.press("Delete")
    for _ in range(3):
        hand.press("Control+z")
        time.sleep(0.2)


def zoom(hand: Hand) -> None:
    """Zoom in and out, and rest after each, so that the picture is drawn anew."""
    for key in "+-":
        hand.hold(key, 10, 5)
        time.sleep(0.5)


def measure_editing(page: Any, box: tuple[float, float]) -> list[Row]:
    """Measure all actions on a drawing of the size ``box`` in user units."""
    hand, watch = Hand(page), Stopwatch(page)
    middle = box[0] / 2, box[1] / 2
    if page.locator("#split").is_visible():
        hand.press("p")  # the line between photo and drawing lies on the middle
    watch.measure("nothing", lambda: time.sleep(1.5))
    for name, level in (("top", "All shown"), ("bottom", page.locator("#filter option").nth(1).inner_text())):
        page.locator("#filter").select_option(label=level)
        page.mouse.click(*hand.at(*middle))
        page.locator("#filter").select_option(label="All shown")
        watch.measure(f"drag a path at the {name}", lambda: hand.drag(*hand.at(*middle)))
        hand.press("Control+z")
        watch.measure(f"hold an arrow key, path at the {name}", lambda: hand.hold("ArrowRight"))
        hand.press("Control+z")
    watch.measure("hold a key to turn", lambda: hand.hold(")"))
    watch.measure("recolour, delete, undo", lambda: recolour_and_delete(hand))
    hand.press("n")
    page.mouse.click(*hand.at(*middle))
    page.wait_for_selector("#surface[data-points*=node]")
    watch.measure("drag a node", lambda: hand.drag(*hand.point()))
    hand.press("]")
    watch.measure("hold an arrow key, node", lambda: hand.hold("ArrowDown"))
    hand.press("v", "Escape")
    watch.measure("hold a key to select the next path", lambda: hand.hold("]"))
    hand.press("Escape", "Control+a")
    watch.measure("drag all paths", lambda: hand.drag(*hand.at(*middle)))
    watch.measure("hold an arrow key, all paths", lambda: hand.hold("ArrowRight"))
    hand.press("Control+z", "Control+z", "Escape")
    watch.measure("zoom by keys", lambda: zoom(hand))
    hand.press("0", "b")
    watch.measure("paint with the brush", lambda: hand.drag(*hand.at(*middle)))
    return watch.rows


@click.command()
@click.argument("drawing", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.option("--image", type=click.Path(exists=True, dir_okay=False, path_type=Path), help="Photo to compare with.")
@click.option("--width", default=1200, show_default=True, help="Width of the window in CSS pixels.")
@click.option("--height", default=800, show_default=True, help="Height of the window in CSS pixels.")
@click.option("--ratio", default=1.0, show_default=True, help="Pixels of the screen per CSS pixel.")
def main(drawing: Path, image: Path | None, width: int, height: int, ratio: float) -> None:
    """Measure frames while DRAWING is edited."""
    from playwright.sync_api import sync_playwright

    chromium = os.environ.get("WARPVEC_CHROMIUM") or next(filter(None, map(shutil.which, NAMES)), None)
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as driver:
        html = Path(folder) / "page.html"
        write_page(html, drawing.read_bytes(), photo=None if image is None else str(image))
        browser = driver.chromium.launch(executable_path=chromium)
        page = browser.new_page(viewport={"width": width, "height": height}, device_scale_factor=ratio)
        page.goto(html.as_uri())
        page.wait_for_selector("body[data-ready]")
        page.wait_for_timeout(1000)
        text = page.evaluate("() => window.warpvecView.drawingText()")
        size = page.evaluate(SIZE, text)
        rows = measure_editing(page, tuple(map(float, size.split()[2:])))  # type: ignore[arg-type]
        live = [page.evaluate(LIVE, text) for _ in range(5)]
        browser.close()
    click.echo(machine_line(machine_facts()))
    click.echo(f"window {width} x {height}, {ratio:g} pixels per CSS pixel, {text.count('<path'):,} paths")
    lines = [[row.action, str(row.frames), *(f"{value:.1f}" for value in row[2:])] for row in rows]
    click.echo(markdown_table(["action", "frames", "median ms", "p95 ms", "longest ms", "script ms", "task ms"], lines))
    click.echo(f"a frame of a fit is read in {np.median(live):.0f} ms (median of {len(live)})")


if __name__ == "__main__":
    main()
