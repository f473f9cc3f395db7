"""A tab of the page of `warpvec app`, and whatever a user does on it: in any order, no edit may be lost."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from desk_browser import DeskPage
from desk_edits import reload
from quick_desk import logo_bytes, write_logo

from warpvec.image.metrics import psnr
from warpvec.image.read import read_image
from warpvec.svg.measure import draw_like

STEPS = ("setting", "fit", "edit", "undo", "redo", "stop", "reload", "x", "save", "open", "restart")

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
        """Close the tab, and assert that it reported no error."""
        self.desk.page.close()
        assert not self.complaints(), self.complaints()

    def complaints(self) -> list[str]:
        """Return the errors that the page has reported, but for requests that fail while there is no server."""
        notes = ("ERR_", "reset", "RESET", "status of 404")
        return [text for text in self.desk.complaints if not any(note in text for note in notes)]
