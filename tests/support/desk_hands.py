"""Hands of users of the page of ``warpvec app``: one has a mouse alone, the other keys alone."""

from __future__ import annotations

from pathlib import Path

from desk_browser import DeskPage

TABS_MAX = 150
"""Controls of the page: after so many steps of Tab all have had the focus."""


def focus(desk: DeskPage, name: str) -> None:
    """Press Tab until a control, by its identifier, format, group of choices, label or text, has the focus."""
    script = """() => {
        const { id, dataset, name, ariaLabel, textContent } = document.activeElement;
        return id || dataset.format || name || ariaLabel || textContent.trim();
    }"""
    for _ in range(TABS_MAX):
        if desk.page.evaluate(script) == name:
            return
        desk.page.keyboard.press("Tab")
    raise AssertionError(f"{name} cannot be reached")


def press(desk: DeskPage, name: str, *keys: str) -> None:
    """Press keys in a control."""
    focus(desk, name)
    for key in keys:
        desk.page.keyboard.press(key)


class Mouse:
    """A user without keys."""

    def __init__(self, desk: DeskPage) -> None:
        self.desk, self.page = desk, desk.page

    def choose(self, source: Path) -> None:
        """Choose a picture file with the button."""
        with self.page.expect_file_chooser() as chooser:
            self.page.locator("#choose").click()
        chooser.value.set_files(source)

    def turn_to(self, side: str) -> None:
        """Show the panel "make" or "edit"."""
        self.page.locator(f"#sides label:has([value={side}])").click()

    def click(self, name: str) -> None:
        """Click on a button or a box."""
        self.page.locator(f"#{name}").click()

    def save(self, kind: str) -> Path:
        """Save with the button of a format."""
        return self.desk.save(kind)


class Keys:
    """A user without a mouse."""

    def __init__(self, desk: DeskPage) -> None:
        self.desk, self.page = desk, desk.page

    def choose(self, source: Path) -> None:
        """Choose a picture file with the button."""
        with self.page.expect_file_chooser() as chooser:
            press(self.desk, "choose", "Enter")
        chooser.value.set_files(source)

    def turn_to(self, side: str) -> None:
        """Show the panel "make" or "edit"."""
        press(self.desk, "side", "ArrowRight" if side == "edit" else "ArrowLeft")

    def click(self, name: str) -> None:
        """Press a button or tick a box."""
        press(self.desk, name, "Space")

    def save(self, kind: str) -> Path:
        """Save with the button of a format."""
        with self.page.expect_download() as download:
            press(self.desk, kind, "Enter")
        path = self.desk.folder / f"keys-{download.value.suggested_filename}"
        download.value.save_as(path)
        return path


HANDS = {"mouse": Mouse, "keys": Keys}
