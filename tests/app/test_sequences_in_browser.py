"""Whatever order a user does things in: no edit is lost, no figure is stale, and the page reports no error."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import NEEDS_BROWSER, browser_fixture  # noqa: F401  (fixture)
from desk_browser import DeskPage, DeskServer
from desk_edits import reload
from quick_desk import QuickServer, logo_bytes, quick_server_fixture, write_logo  # noqa: F401  (fixture)

from warpvec.image.metrics import psnr
from warpvec.image.read import read_image
from warpvec.svg.measure import draw_like

pytestmark = NEEDS_BROWSER

STEPS = ("setting", "fit", "edit", "undo", "redo", "stop", "reload", "x", "save", "open", "restart")

ALL = bool(os.environ.get("WARPVEC_ALL_SEQUENCES"))
"""Whether all sequences are tried, with the real worker, which takes hours; else a share of them, with a quick one."""

SCRIPT = Path(__file__).with_name("sequences.js").read_text(encoding="utf-8")

BROWSER_GAP = 1.0 / 255.0
"""Largest difference of the root mean square errors of what the browser and resvg draw of the logo: a level."""

SAME_PSNR = 45.0
"""Closeness in dB from which on a saved file is what the page shows."""


class Sequences:
    """A tab, and what a user does on it.

    Args:
        browser: Playwright's.
        server: the server, which can be started again.
        folder: of files.
    """

    def __init__(self, browser: Any, server: Any, folder: Path) -> None:
        self.server, self.source = server, write_logo(folder / "logo.png")
        self.desk = DeskPage(browser, server, folder)
        self.target = read_image(logo_bytes())

    def check(self, steps: tuple[str, ...]) -> None:
        """Drop the logo on a new page, do ``steps`` with it, and undo them."""
        self.begin(self.source)
        first, model = self.text(), None
        for step in ("begin", *steps):
            first = self.act(step, first)
            if step == "open":
                opened = sorted({edit for each in model["done"] for edit in each.get("edit", "").split()})
                model = {**model, "done": [], "undone": [], "opened": sorted({*model["opened"], *opened})}
            model = self.desk.page.evaluate("([step, model]) => takeStep(step, model ?? undefined)", [step, model])
            assert not model["faults"], (steps, model["faults"])
        found = self.desk.page.evaluate("([model, first]) => undoAll(model, first)", [model, first])
        assert not found["faults"], (steps, found["faults"])
        measured = psnr(self.drawn(found["text"]), self.target)
        errors = [10.0 ** (-decibels / 20.0) for decibels in (measured, found["stated"])]
        assert abs(errors[0] - errors[1]) < BROWSER_GAP, (steps, measured, found["stated"])

    def begin(self, *files: Path) -> None:
        """Drop files on a page that knows nothing of what was done before."""
        page = self.desk.page
        page.wait_for_function("() => desk.isKept()")
        page.evaluate("() => sessionStorage.clear()")
        page.goto(self.server.url)
        self.prepare()
        self.desk.drop(*files)
        page.wait_for_function("() => warpvecView.state.paths && !warpvecView.state.live")
        self.desk.wait_for_status("done")

    def prepare(self) -> None:
        self.desk.page.wait_for_selector("body[data-desk]")
        self.desk.page.evaluate(SCRIPT + "null")

    def act(self, step: str, first: str) -> str:
        """Do what a script of the page cannot; return the drawing to which Undo leads back."""
        page = self.desk.page
        if step == "reload":
            reload(self.desk)
            self.prepare()
        elif step in ("save", "open"):
            saved = self.desk.save()
            assert psnr(self.drawn(saved.read_text()) / np.float32(255.0), self.drawn(self.text())) >= SAME_PSNR
            if step == "open":
                self.begin(saved, self.source)
                return self.text()
        elif step == "restart":
            self.server.restart()
            page.wait_for_function("(url) => location.href === url", arg=self.server.url)
            page.wait_for_selector("#lost", state="hidden")
        return first

    def text(self) -> str:
        return str(self.desk.page.evaluate("() => warpvecView.drawingText()"))

    def drawn(self, text: str) -> Any:
        return draw_like(text.encode(), self.target)

    def close(self) -> None:
        """Close the tab. Requests may have failed: there was no server, or it had no pictures yet."""
        self.desk.page.close()
        notes = ("ERR_", "reset", "RESET", "status of 404")
        faults = [text for text in self.desk.complaints if not any(note in text for note in notes)]
        assert not faults, faults


@pytest.fixture
def sequences(browser: Any, quick_server: QuickServer, tmp_path: Path) -> Iterator[Sequences]:
    server = DeskServer(tmp_path) if ALL else quick_server
    made = Sequences(browser, server, tmp_path)
    yield made
    made.close()
    if ALL:
        server.end()


@pytest.mark.parametrize("first", STEPS)
def test_no_two_steps_lose_an_edit(sequences: Sequences, first: str) -> None:
    for second in STEPS if ALL else STEPS[STEPS.index(first) % 4 :: 4]:
        sequences.check(("edit", first, second))


@pytest.mark.parametrize("number", range(30 if ALL else 2))
def test_no_eight_steps_lose_an_edit(sequences: Sequences, number: int) -> None:
    rng = np.random.default_rng(number)
    for _ in range(10 if ALL else 3):
        sequences.check(tuple(rng.choice(STEPS, 8).tolist()))


def test_no_three_steps_on_one_drawing_lose_an_edit(sequences: Sequences) -> None:
    own = STEPS[:6]
    for steps in list(itertools.product(own, repeat=3))[:: 1 if ALL else 12]:
        sequences.check(steps)
