"""Take pictures of the page of `warpvec app` in a headless Chromium, and compose a sheet of them for the README.

The app runs as its users start it, and the page is driven with mouse and keys: a photo while it is drawn, a finished
logo, the nodes of one of its paths, a window of a phone, and the dark colours. The first four need no more of the
machine than their fits; a slow one only takes longer.

    python bench/screens.py PHOTO LOGO OUT [--node-at 0.5 0.5]
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import click
from PIL import Image

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "support"))

from browser import CHROMIUM
from children import take_default_signals
from desk_browser import DeskPage, DeskServer

WINDOW = {"width": 1200, "height": 800}
PHONE = {"width": 390, "height": 844}

DRAWN_SHARE = 0.4
"""Share of the iterations after which the photo is taken: its forms are there, and the bar is not near an end."""

ZOOMS = 2
"""Steps by which the nodes are shown larger than the whole drawing."""

MARGIN = 12
SHEET_COLORS = 256
GROUND = (214, 214, 209)


class Photographer:
    """Opens the page in windows of several kinds, and keeps a picture of each.

    Args:
        browser: Playwright's.
        server: the app.
        out: folder of the pictures.
    """

    def __init__(self, browser: Any, server: DeskServer, out: Path) -> None:
        self._browser, self._server, self.out = browser, server, out

    def open(self, window: dict[str, int], scheme: str = "light") -> DeskPage:
        """Open the page in a new window, in "light" or "dark" colours."""
        return DeskPage(self._browser, self._server, self.out, viewport=window, color_scheme=scheme)

    def take(self, desk: DeskPage, name: str) -> None:
        """Write what the window shows as a PNG."""
        desk.page.wait_for_timeout(500)
        desk.page.screenshot(path=str(self.out / f"{name}.png"))


def finish(desk: DeskPage, picture: Path) -> None:
    """Draw a picture to its end."""
    desk.drop(picture)
    desk.wait_for_status("done")


def draw_photo(photographer: Photographer, photo: Path) -> None:
    """Take a photo while it is drawn."""
    desk = photographer.open(WINDOW)
    desk.drop(photo)
    share = "(share) => document.getElementById('fit-progress').value >= share"
    desk.page.wait_for_function(share, arg=DRAWN_SHARE)
    photographer.take(desk, "photo")
    desk.page.locator("#stop").click()
    desk.wait_for_status("Stopped")
    desk.close()


def draw_logo(photographer: Photographer, logo: Path, node_at: tuple[float, float]) -> None:
    """Take a finished logo, and the nodes of its path at a place that is given in shares of width and height."""
    desk = photographer.open(WINDOW)
    finish(desk, logo)
    photographer.take(desk, "logo")
    page = desk.page
    page.locator("#sides label").nth(1).click()
    with Image.open(logo) as image:
        desk.click(node_at[0] * image.width, node_at[1] * image.height)
    if not page.evaluate("() => window.warpvecView.state.selected"):
        page.keyboard.press("]")  # there is no path at that place: the lowest one
    page.keyboard.press("n")
    page.wait_for_selector("#surface[data-points*=node]")
    for key in "+" * ZOOMS + "]":
        page.keyboard.press(key)
    photographer.take(desk, "nodes")
    desk.close()


def draw_on_phone(photographer: Photographer, logo: Path) -> None:
    """Take the finished logo in the window of a phone."""
    desk = photographer.open(PHONE)
    finish(desk, logo)
    photographer.take(desk, "phone")
    desk.close()


def draw_in_the_dark(photographer: Photographer, photo: Path) -> None:
    """Take the photo beside its drawing in dark colours."""
    desk = photographer.open(WINDOW, "dark")
    desk.slide("set-detail", 16)
    finish(desk, photo)
    desk.slide("split", 50)
    photographer.take(desk, "dark")
    desk.close()


def compose(large: Image.Image, tall: Image.Image, small: Iterable[Image.Image]) -> Image.Image:
    """Return a sheet: ``large`` and ``tall`` beside each other at equal heights, a row of ``small`` ones below."""
    beside = tall.resize((round(tall.width * large.height / tall.height), large.height), Image.Resampling.LANCZOS)
    row = list(small)
    width = large.width + MARGIN + beside.width
    inner = (width - MARGIN * (len(row) - 1)) / len(row)
    shrunk = [
        cell.resize((round(inner), round(inner * cell.height / cell.width)), Image.Resampling.LANCZOS) for cell in row
    ]
    height = large.height + MARGIN + max(cell.height for cell in shrunk)
    sheet = Image.new("RGB", (width + 2 * MARGIN, height + 2 * MARGIN), GROUND)
    sheet.paste(large, (MARGIN, MARGIN))
    sheet.paste(beside, (MARGIN + large.width + MARGIN, MARGIN))
    for index, cell in enumerate(shrunk):
        sheet.paste(cell, (MARGIN + round(index * (inner + MARGIN)), 2 * MARGIN + large.height))
    return sheet


def write_sheet(sheet: Image.Image, path: Path) -> None:
    """Write the sheet with a palette, without dithering, which would make a large file."""
    sheet.quantize(SHEET_COLORS, Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE).save(path, optimize=True)


@click.command()
@click.argument("photo", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.argument("logo", type=click.Path(exists=True, dir_okay=False, path_type=Path))
@click.argument("out", type=click.Path(file_okay=False, path_type=Path))
@click.option(
    "--node-at",
    type=(float, float),
    default=(0.5, 0.5),
    show_default=True,
    help="Place of the path whose nodes are shown, in shares of width and height.",
)
def main(photo: Path, logo: Path, out: Path, node_at: tuple[float, float]) -> None:
    """Write photo.png, logo.png, nodes.png, phone.png, dark.png and desk.png, a sheet of them, to the folder OUT."""
    from playwright.sync_api import sync_playwright

    take_default_signals()  # a background job of a script ignores SIGINT, and so would its server
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as runtime, sync_playwright() as driver:
        server = DeskServer(Path(runtime))
        try:
            photographer = Photographer(driver.chromium.launch(executable_path=CHROMIUM), server, out)
            draw_photo(photographer, photo)
            draw_logo(photographer, logo, node_at)
            draw_on_phone(photographer, logo)
            draw_in_the_dark(photographer, photo)
        finally:
            server.end()
    large, tall, *small = (
        Image.open(out / f"{name}.png").convert("RGB") for name in ("photo", "phone", "logo", "nodes", "dark")
    )
    write_sheet(compose(large, tall, small), out / "desk.png")
    click.echo(f"{out / 'desk.png'}: {(out / 'desk.png').stat().st_size:,} bytes")


if __name__ == "__main__":
    main()
