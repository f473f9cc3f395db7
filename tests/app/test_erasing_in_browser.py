"""The lasso cuts shapes, also those of the next drawing; what a drawing has no place for is left to the user."""

from __future__ import annotations

from pathlib import Path

import pytest
from browser import NEEDS_BROWSER, browser_fixture  # noqa: F401  (fixture)
from desk_browser import DeskPage
from quick_desk import QuickServer, quick_server_fixture, write_logo  # noqa: F401  (fixture)

pytestmark = NEEDS_BROWSER

WHITE, GREEN, YELLOW = (255, 255, 255), (0x2E, 0x9B, 0x4F), (0xF2, 0xC2, 0x30)


def test_what_the_lasso_cuts_is_cut_from_the_next_drawing_too(
    browser, quick_server: QuickServer, tmp_path: Path
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
    for is_cut in (True, False):
        page.locator("#set-cutout").set_checked(is_cut)
        page.wait_for_function(
            "(isCut) => warpvecView.facts.positions.cutout == isCut && !warpvecView.state.live", arg=is_cut
        )
        assert page.locator("#proposal").is_hidden()
        assert [desk.color(x, 70) for x in (40, 66, 76, 90)] == [WHITE, WHITE, YELLOW, GREEN]
    desk.close()


@pytest.mark.parametrize("choice", ["keep-mine", "take-new"])
def test_the_user_decides_about_edits_that_a_new_drawing_has_no_place_for(
    browser, quick_server: QuickServer, tmp_path: Path, choice: str
) -> None:
    desk = DeskPage(browser, quick_server, tmp_path)
    page = desk.page
    desk.drop(write_logo(tmp_path / "logo.png"))
    desk.wait_for_status("done")
    with desk.fitting():
        page.locator("#set-cutout").check()
    desk.click(40, 70)
    page.keyboard.press("Control+g")
    page.keyboard.press("Delete")
    page.locator("#set-cutout").uncheck()
    page.locator("#proposal").wait_for()
    assert "arrangement of layers" in page.inner_text("#proposal-text")
    assert (desk.color(40, 70), page.is_checked("#set-cutout")) == (WHITE, True)
    page.locator(f"#{choice}").click()
    assert page.locator("#proposal").is_hidden()
    assert (desk.color(40, 70), page.is_checked("#set-cutout")) == (WHITE, choice == "keep-mine")
    page.keyboard.press("Control+z")
    assert page.is_checked("#set-cutout") is True
    desk.close()
