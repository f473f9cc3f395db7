"""The first hours of five people on the page of `warpvec app`, as what they click and type, in windows of three widths.

Each looks for something else: a newcomer, a cutter, a photographer and an archivist with keys alone, and a designer.
Light and dark colours take turns. A picture of the window is taken after each step, to be looked at. What a page must
not do is counted: text that its box cuts off, content wider than the window, errors, and requests to other hosts.

    python bench/first_hours.py LOGO PHOTO SCAN OUT [--user cutter] [--width 390]
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click
from PIL import Image

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))

from browser import CHROMIUM
from children import take_default_signals
from desk_browser import DeskPage, DeskServer
from desk_hands import Keys, Mouse, press

HEIGHTS = {1440: 900, 1024: 700, 390: 844}
"""Width of a window -> its height: a large screen, a small one, and a phone."""

PHOTO_SIDE = 256
"""Longest side of the photo, whose fit is to take seconds."""

_CUT_OFF = """() => {
    const found = [];
    const wide = document.documentElement.scrollWidth - innerWidth;
    if (wide > 1) found.push(`the page is ${wide} px wider than the window`);
    for (const each of document.querySelectorAll("button, label, h2, summary, p, th, td, select")) {
        const { clientWidth, scrollWidth, textContent } = each;
        const style = getComputedStyle(each);
        const isCut = style.overflow !== "visible" && style.textOverflow !== "ellipsis";
        if (clientWidth && scrollWidth > clientWidth + 1 && isCut) {
            found.push(`cut off: ${textContent.trim().slice(0, 40)}`);
        }
    }
    return found;
}"""


class Hour:
    """A tab of one person, who says each step.

    Args:
        desk: the tab.
        out: folder of the pictures.
        name: of the person and the window.
    """

    def __init__(self, desk: DeskPage, out: Path, name: str) -> None:
        self.desk, self.page, self.faults = desk, desk.page, list[str]()
        self.mouse, self.keys = Mouse(desk), Keys(desk)
        self._out, self._name, self._count = out, name, 0

    def step(self, words: str) -> None:
        """Take a picture of the window after a step, and look for what is cut off."""
        self.page.wait_for_timeout(400)
        self._count += 1
        name = f"{self._name}-{self._count}-{words.replace(' ', '-')}"
        self.page.screenshot(path=str(self._out / f"{name}.png"))
        self.faults += [f"{name}: {fault}" for fault in self.page.evaluate(_CUT_OFF)]


def newcomer(hour: Hour, logo: Path, photo: Path, scan: Path) -> None:
    """Look at the empty page, draw, compare with the picture, look for help, save."""
    hour.step("empty")
    hour.mouse.choose(logo)
    hour.step("drawing")
    hour.desk.wait_for_status("done")
    hour.step("done")
    hour.desk.slide("split", 50)
    hour.step("compared")
    hour.page.keyboard.press("?")
    hour.step("help")
    hour.page.keyboard.press("Escape")
    hour.mouse.save("svg")
    hour.step("saved")


def cutter(hour: Hour, logo: Path, photo: Path, scan: Path) -> None:
    """Draw for a laser, see what may go wrong, give the width in millimetres, save DXF."""
    hour.mouse.choose(logo)
    hour.desk.wait_for_status("done")
    with hour.desk.fitting():
        hour.page.locator("[data-machine=laser]").click()
    hour.mouse.click("make-check")
    hour.page.locator("#make-warnings li").first.wait_for()
    hour.step("warned")
    hour.page.locator("#size-unit").select_option("mm")
    hour.page.locator("#size-width").fill("90")
    hour.page.keyboard.press("Enter")
    hour.step("in millimetres")
    hour.mouse.save("dxf")
    hour.step("saved")


def photographer(hour: Hour, logo: Path, photo: Path, scan: Path) -> None:
    """With keys alone: choose a photo, ask for few bytes, save."""
    press(hour.desk, "set-mode", "ArrowRight")
    press(hour.desk, "set-max_bytes", *["ArrowRight"] * 3)
    hour.step("limit")
    hour.keys.choose(photo)
    hour.desk.wait_for_status("Drawing")
    hour.step("drawing")
    hour.desk.wait_for_status("done")
    hour.step("done")
    hour.keys.save("svg")
    hour.step("saved")


def designer(hour: Hour, logo: Path, photo: Path, scan: Path) -> None:
    """Choose a shape, give it a colour, show its nodes, move one, see the outlines, undo."""
    hour.mouse.choose(logo)
    hour.desk.wait_for_status("done")
    hour.mouse.turn_to("edit")
    hour.step("edit")
    with Image.open(logo) as image:
        hour.desk.click(0.5 * image.width, 0.6 * image.height)
    hour.step("chosen")
    hour.desk.drag_slider("hue", 30)
    hour.step("recoloured")
    hour.page.locator("#surface").press("n")
    hour.step("nodes")
    hour.page.locator("summary", has_text="Colours of a brand").click()
    hour.page.locator("#brand").fill("#111111 #ff8000 #ffffff")
    hour.mouse.click("brand-apply")
    hour.step("brand")
    hour.page.keyboard.press("Control+z")
    hour.step("undone")


def archivist(hour: Hour, logo: Path, photo: Path, scan: Path) -> None:
    """With keys alone: choose a scan, remove its paper, save PDF."""
    hour.keys.choose(scan)
    hour.desk.wait_for_status("done")
    hour.step("done")
    hour.keys.turn_to("edit")
    hour.keys.click("remove-background")
    hour.step("without paper")
    hour.keys.turn_to("make")
    hour.keys.save("pdf")
    hour.step("saved")


USERS: dict[str, Callable[[Hour, Path, Path, Path], None]] = {
    each.__name__: each for each in (newcomer, cutter, photographer, designer, archivist)
}


def live_through(
    user: str, browser: Any, server: DeskServer, window: tuple[int, str], sources: list[Path], out: Path
) -> list[str]:
    """Let a user have the first hour in a window of a width and a colour scheme; return the faults."""
    width, scheme = window
    options = {"viewport": {"width": width, "height": HEIGHTS[width]}, "color_scheme": scheme}
    desk = DeskPage(browser, server, out, **options)
    hour = Hour(desk, out, f"{user}-{width}-{scheme}")
    try:
        USERS[user](hour, *sources)
    except Exception as error:
        hour.step("failed")
        hour.faults.append(f"{user}-{width}-{scheme}: {str(error).splitlines()[0]}")
    desk.page.close()
    return hour.faults + desk.complaints


@click.command()
@click.argument("logo", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.argument("photo", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.argument("scan", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.argument("out", type=click.Path(file_okay=False, path_type=Path))
@click.option("--user", "users", type=click.Choice(list(USERS)), multiple=True, help="Only this person.")
@click.option("--width", "widths", type=click.Choice([str(width) for width in HEIGHTS]), multiple=True)
def main(logo: Path, photo: Path, scan: Path, out: Path, users: tuple[str, ...], widths: tuple[str, ...]) -> None:
    """Write pictures of all steps to the folder OUT, and print the faults."""
    from playwright.sync_api import sync_playwright

    take_default_signals()  # a background job of a script ignores SIGINT, and so would its server
    out.mkdir(parents=True, exist_ok=True)
    faults = []
    with tempfile.TemporaryDirectory() as runtime, sync_playwright() as driver:
        small = Path(runtime) / "photo.png"
        with Image.open(photo) as image:
            image.thumbnail((PHOTO_SIDE, PHOTO_SIDE))
            image.convert("RGB").save(small)
        server = DeskServer(Path(runtime))
        browser = driver.chromium.launch(executable_path=CHROMIUM)
        try:
            for number, user in enumerate(users or USERS):
                for place, width in enumerate(map(int, widths or HEIGHTS)):
                    scheme = ("light", "dark")[(number + place) % 2]
                    found = live_through(user, browser, server, (width, scheme), [logo, small, scan], out)
                    click.echo(f"{user}, {width} px, {scheme}: {len(found)} faults")
                    faults += found
        finally:
            server.end()
    click.echo("\n".join(faults))


if __name__ == "__main__":
    main()
