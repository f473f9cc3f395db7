"""Pictures with hostile names and titles on the page of ``warpvec app``: shown as they are, and never run."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from browser import NEEDS_BROWSER, browser_fixture  # noqa: F401  (fixture)
from children import wait_for
from desk_browser import DeskPage, DeskServer
from PIL import Image
from PIL.PngImagePlugin import PngInfo

pytestmark = NEEDS_BROWSER

NAMES = (
    "<img src=x onerror=alert(1)>", "\"><svg onload=alert(2)>", "'-alert(3)-'", "${alert(4)}", "javascript:alert(5)",
    "a#b?c&d=e%2e%2e%2f", "&lt;script&gt;", "__proto__", "\u202egnp.a", "a\nb\tc", "]]><x", "--> <x", "é" * 60,
)  # fmt: skip
"""Names without their suffix. The first ones run a script where a page takes them for markup."""


@pytest.fixture
def server(tmp_path: Path) -> Iterator[DeskServer]:
    """Serve a folder of small pictures with hostile names and titles."""
    folder = tmp_path / "pictures"
    folder.mkdir()
    title = PngInfo()
    title.add_text("Title", "</title><script>alert(6)</script>")
    for index, name in enumerate(NAMES):
        picture = Image.new("RGB", (16, 12), (200, 10 * index, 30))
        picture.paste((255, 255, 255), (4, 3, 10, 9))
        picture.save(folder / f"{name}.png", pnginfo=title)
    (tmp_path / "runtime").mkdir()
    server = DeskServer(tmp_path / "runtime", folder)
    yield server
    assert server.end() == 130


@pytest.mark.slow
def test_hostile_names_are_text(browser: Any, server: DeskServer, tmp_path: Path) -> None:
    desk, folder = DeskPage(browser, server, tmp_path), tmp_path / "pictures"
    desk.page.wait_for_function("(count) => document.querySelectorAll('#folder option').length > count", arg=len(NAMES))
    for count, name in enumerate(NAMES, 1):
        desk.page.locator("#folder").select_option(f"{name}.png")
        states = "[...document.querySelectorAll('#pictures .state')]"
        script = f"(count) => {states}.filter(({{ textContent }}) => textContent === 'done').length === count"
        desk.page.wait_for_function(script, arg=count)
        desk.page.locator("[data-format=svg]").click()
        saved = wait_for(lambda count=count: _written(folder, count))
        text = ElementTree.parse(max(saved, key=lambda path: path.stat().st_mtime_ns)).getroot()
        assert not list(text.iter("{http://www.w3.org/2000/svg}script"))
    shown = "\n".join(desk.page.locator("#pictures li").all_inner_texts())
    assert all(name.split()[0] in shown for name in NAMES)
    assert sorted(path.suffix for path in tmp_path.rglob("*") if path.is_file()).count(".svg") == len(NAMES)
    assert not desk.dialogs
    desk.close()


def _written(folder: Path, count: int) -> list[Path] | None:
    """Return the drawings in ``folder`` if ``count`` are whole."""
    found = [path for path in folder.glob("*.svg") if path.stat().st_size > 0]
    return found if len(found) == count else None
