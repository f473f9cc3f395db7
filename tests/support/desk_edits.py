"""Edits of the drawing on the page of ``warpvec app``, and loading that page again."""

from __future__ import annotations

from typing import Any

from desk_browser import DeskPage

GREEN, ORANGE = "#2e9b4f", "#ff8000"

RECOLOUR = """([from, to]) => {
    const { app } = warpvecView;
    app.select(app.drawing.layers.flatMap(({ items }) => items).filter(({ fill }) => fill === from));
    const fill = document.getElementById("fill");
    fill.value = to;
    for (const type of ["input", "change"]) fill.dispatchEvent(new Event(type, { bubbles: true }));
}"""

NOTE_HELLO = """
const add = EventSource.prototype.addEventListener;
EventSource.prototype.addEventListener = function (kind, act) {
    add.call(this, kind, (event) => (act(event), kind === "hello" && (window.hasMet = true)));
};
"""
"""Notes that the server has said hello, and that the page has heard it."""


def reload(desk: DeskPage) -> None:
    """Load the page again as soon as it has kept what it has."""
    desk.page.wait_for_function("() => desk.isKept()")
    desk.page.reload()
    desk.page.wait_for_selector("body[data-desk]")


def text_of(desk: DeskPage) -> Any:
    return desk.page.evaluate("() => warpvecView.drawingText()")


def wait_for_text(desk: DeskPage, text: str) -> None:
    desk.page.wait_for_function("(text) => warpvecView.drawingText() === text", arg=text)
