"""Tasks of a user on the page, each with the mouse alone and with the keyboard alone, up to the saved file."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from browser import NEEDS_BROWSER, Viewer, browser_fixture  # noqa: F401  (fixtures)
from squares import HEIGHT, WIDTH

from warpvec.svg.measure import draw

pytestmark = NEEDS_BROWSER

NS = 'xmlns="http://www.w3.org/2000/svg"'
MARK = "#c80028"


def marks(color: str) -> str:
    """Return a sheet with the same mark, of two shapes with a hole, at three places on two levels, and other shapes."""
    places = ((10, 10), (100, 40), (190, 100))
    outlines = [f"M{x} {y}h30v30h-30zm10 10v10h10v-10z" for x, y in places]
    paths = [f'<path fill="{color}" d="{outline}"/>' for outline in outlines]
    others = ['<path fill="#0a5" d="M60 100c0-20 40-20 40 0s-40 20-40 0z"/>', '<path fill="#234" d="M150 10h30v20z"/>']
    size = f'width="{WIDTH}" height="{HEIGHT}"'
    return (
        f'<svg {NS} {size}><rect id="background" {size} fill="#fff"/>'
        f'<g id="layer-1-generation-0">{paths[0]}{others[0]}</g>'
        f'<g id="layer-2-generation-1">{others[1]}{paths[1]}{paths[2]}</g></svg>'
    )


class MouseOnly:
    """A hand on the mouse: nothing here presses a key."""

    def __init__(self, viewer: Viewer) -> None:
        self.viewer = viewer
        self.mouse = viewer.page.mouse

    def press(self, identifier: str) -> None:
        self.viewer.page.locator(f"#{identifier}").click()

    def tool(self, label: str) -> None:
        self.viewer.page.locator("#tools label", has_text=label).click()

    def click(self, x: float, y: float) -> None:
        self.mouse.click(*self.viewer.at(x, y))

    def drag(self, *points: tuple[float, float]) -> None:
        self.viewer.drag(*points)

    def set_slider(self, identifier: str, share: float) -> None:
        """Drag the thumb of a slider to a share of its width."""
        slider = self.viewer.page.locator(f"#{identifier}")
        slider.scroll_into_view_if_needed()
        box = slider.bounding_box()
        y = box["y"] + box["height"] / 2
        self.mouse.move(box["x"] + box["width"] / 2, y)
        self.mouse.down()
        self.mouse.move(box["x"] + 8 + share * (box["width"] - 16), y, steps=5)
        self.mouse.up()

    def save(self) -> str:
        return saved(self.viewer, lambda: self.press("save"))


class KeysOnly:
    """Hands on the keyboard: nothing here moves or clicks a mouse."""

    def __init__(self, viewer: Viewer) -> None:
        self.viewer = viewer

    def press(self, *keys: str) -> None:
        for key in keys:
            self.viewer.page.keyboard.press(key)

    def go(self, x: float, y: float) -> None:
        """Move the cross, which must be on, to a point of the drawing."""
        place = self.viewer.page.locator("#surface").get_attribute("data-caret")
        at = [float(word) for word in place.split()]
        to = np.subtract(self.viewer.at(x, y), self.viewer.page.evaluate(CORNER))
        for (less, more), gap in zip((("Left", "Right"), ("Up", "Down")), to - at, strict=True):
            far, near = divmod(round(abs(gap)), 10)
            arrow = f"Arrow{more if gap > 0 else less}"
            self.press(*[arrow] * far, *[f"Control+{arrow}"] * near)

    def focus(self, identifier: str) -> None:
        """Press Tab until a control has the focus."""
        for _ in range(150):
            if self.viewer.page.evaluate("() => document.activeElement.id") == identifier:
                return
            self.press("Tab")
        raise AssertionError(f"Tab does not reach {identifier}")

    def write(self, text: str) -> None:
        self.press("Control+a")
        self.viewer.page.keyboard.type(text)
        self.press("Enter")

    def save(self) -> str:
        return saved(self.viewer, lambda: self.press("Control+s"))


CORNER = """() => {
    const { left, top } = document.getElementById("surface").getBoundingClientRect();
    return [left, top];
}"""


def saved(viewer: Viewer, save: Any) -> str:
    with viewer.page.expect_download() as download:
        save()
    path = viewer.folder / "saved.svg"
    download.value.save_as(path)
    return path.read_text(encoding="utf-8")


@pytest.fixture
def sheet(browser: Any, tmp_path: Path) -> Iterator[Viewer]:
    viewer = Viewer(browser, tmp_path, marks(MARK))
    yield viewer
    viewer.close()


def assert_draws_as(svg: str, expected: str, levels: int = 2) -> None:
    difference = np.abs(draw(svg).astype(int) - draw(expected))
    assert difference.max() <= levels, f"{(difference.max(2) > levels).sum()} pixels differ"


# Recolour a mark everywhere.


def test_a_mark_is_recoloured_everywhere_with_the_mouse(sheet: Viewer) -> None:
    hand = MouseOnly(sheet)
    hand.click(15, 15)
    hand.set_slider("hue", 0.5)
    hand.set_slider("lightness", 0.25)
    color = sheet.text("fill-text")
    red, green, blue = (int(color[i : i + 2], 16) for i in (1, 3, 5))
    assert red < 30 and min(green, blue) > 90
    assert_draws_as(hand.save(), marks(color))


def test_a_mark_is_recoloured_everywhere_with_keys(sheet: Viewer) -> None:
    hands = KeysOnly(sheet)
    hands.press("c")
    hands.go(105, 45)
    hands.press("Enter", "Escape")
    hands.focus("replace-hex")
    hands.write("#0a78ff")
    assert_draws_as(hands.save(), marks("#0a78ff"))


# Delete a selection by a rubber band: the mark at the top left, and nothing of it that it only touches.

REST = re.sub(r'(<g id="layer-1-generation-0">)<path.*?/>', r"\1", marks(MARK))
BAND = ((4, 4), (55, 60))


def test_a_selection_by_a_rubber_band_is_deleted_with_the_mouse(sheet: Viewer) -> None:
    hand = MouseOnly(sheet)
    hand.drag(*BAND)
    assert sheet.selected() == "1 of 5 paths selected: Pass 1"
    hand.press("delete")
    assert_draws_as(hand.save(), REST)


def test_a_selection_by_a_rubber_band_is_deleted_with_keys(sheet: Viewer) -> None:
    hands = KeysOnly(sheet)
    hands.press("c")
    hands.go(*BAND[0])
    hands.press(" ")
    hands.go(*BAND[1])
    hands.press(" ")
    assert sheet.selected() == "1 of 5 paths selected: Pass 1"
    hands.press("Delete")
    assert_draws_as(hands.save(), REST)


# Move a node of the small triangle, and make a curve of one side.

MOVED = marks(MARK).replace("M150 10h30v20z", "M150 10h30L165 60z")


def test_a_node_is_moved_with_the_mouse(sheet: Viewer) -> None:
    hand = MouseOnly(sheet)
    hand.click(172, 14)
    hand.tool("Nodes")
    hand.drag((180, 30), (165, 60))
    edited = hand.save()
    # A pixel of the screen is less than half a unit.
    assert (np.abs(draw(edited).astype(int) - draw(MOVED)).max(2) > 128).sum() == 0
    hand.press("node-smooth")
    assert "c" in re.findall(r'fill="#234"[^>]* d="([^"]*)"', hand.save())[0]
    hand.press("undo")
    hand.press("undo")
    assert_draws_as(hand.save(), marks(MARK), levels=0)


def test_a_node_is_moved_with_keys(sheet: Viewer) -> None:
    hands = KeysOnly(sheet)
    hands.press("]", "]", "]", "n", "]", "]", "]")
    assert sheet.text("node-text") == "Node 3 of 3, corner, at 180, 30"
    hands.press(*["ArrowLeft"] * 5, "Shift+ArrowLeft", *["Shift+ArrowDown"] * 3)
    assert_draws_as(hands.save(), MOVED)
    hands.press("s")
    assert "c" in re.findall(r'fill="#234"[^>]* d="([^"]*)"', hands.save())[0]
    hands.press("Control+z", "Control+z")
    assert_draws_as(hands.save(), marks(MARK), levels=0)
