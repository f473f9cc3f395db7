"""The lasso cuts shapes, and a drawing with edits that a new one has no place for stays until the user decides."""

from __future__ import annotations

from pathlib import Path

import pytest
from browser import NEEDS_BROWSER, browser_fixture  # noqa: F401  (fixture)
from desk_browser import DeskPage
from quick_desk import QuickServer, quick_server_fixture, write_logo  # noqa: F401  (fixture)

pytestmark = NEEDS_BROWSER

WHITE, GREEN, YELLOW = (255, 255, 255), (0x2E, 0x9B, 0x4F), (0xF2, 0xC2, 0x30)


@pytest.mark.parametrize("choice", ["keep-mine", "take-new"])
def test_the_lasso_cuts_shapes_and_the_user_decides_what_stays(
    browser, quick_server: QuickServer, tmp_path: Path, choice: str
) -> None:
    desk = DeskPage(browser, quick_server, tmp_path)
    page = desk.page
    desk.drop(write_logo(tmp_path / "logo.png"))
    desk.wait_for_status("done")
    page.keyboard.press("o")
    desk.drag((10, 10), (70, 10), (70, 130), (10, 130), (10, 10))
    page.wait_for_function("() => document.getElementById('message').textContent.startsWith('Erased')")
    assert page.inner_text("#message") == "Erased from 2 paths"
    assert [desk.color(x, 70) for x in (40, 66, 76, 90)] == [WHITE, WHITE, YELLOW, GREEN]
    page.keyboard.press("Control+z")
    assert desk.color(40, 70) == GREEN
    page.keyboard.press("Control+Shift+z")
    page.locator("#set-cutout").check()
    page.locator("#proposal").wait_for()
    assert "1 erased part" in page.inner_text("#proposal-text")
    assert (desk.color(40, 70), page.is_checked("#set-cutout")) == (WHITE, False)
    page.locator(f"#{choice}").click()
    assert page.locator("#proposal").is_hidden()
    is_new = choice == "take-new"
    assert (desk.color(40, 70), page.is_checked("#set-cutout")) == ((GREEN, True) if is_new else (WHITE, False))
    page.keyboard.press("Control+z")
    assert (desk.color(40, 70), page.is_checked("#set-cutout")) == ((WHITE, False) if is_new else (GREEN, False))
    desk.close()
