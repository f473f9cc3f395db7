"""A page of ``warpvec app`` that is loaded again, also after its server was started again, has all that it had."""

from __future__ import annotations

import signal
from pathlib import Path
from typing import Any

from browser import NEEDS_BROWSER, browser_fixture  # noqa: F401  (fixture)
from desk_browser import DeskPage, DeskServer
from desk_edits import GREEN, ORANGE, RECOLOUR, reload, text_of, wait_for_text
from quick_desk import QuickServer, quick_server_fixture, write_logo  # noqa: F401  (fixture)

pytestmark = NEEDS_BROWSER


def drawn_logo(browser: Any, server: QuickServer, folder: Path) -> DeskPage:
    """Return a page that has drawn the logo."""
    desk = DeskPage(browser, server, folder)
    desk.drop(write_logo(folder / "logo.png"))
    desk.wait_for_status("done")
    return desk


def test_edits_the_undo_list_and_settings_are_there_after_a_reload(
    browser: Any, quick_server: QuickServer, tmp_path: Path
) -> None:
    desk = drawn_logo(browser, quick_server, tmp_path)
    page = desk.page
    first = text_of(desk)
    page.evaluate(RECOLOUR, [GREEN, ORANGE])
    recoloured = text_of(desk)
    with desk.fitting():
        page.locator("#set-cutout").click()
    cut = text_of(desk)
    page.locator("#undo").click()
    page.locator("#keep-edited").evaluate("(box) => box.click()")
    reload(desk)
    wait_for_text(desk, recoloured)
    assert not page.is_checked("#set-cutout") and not page.locator("#keep-edited").is_checked()
    assert desk.states() == ["logo done"]
    page.locator("#redo").click()
    wait_for_text(desk, cut)
    assert page.is_checked("#set-cutout")
    page.locator("#undo").click()
    page.locator("#undo").click()
    wait_for_text(desk, first)
    page.wait_for_selector("#undo:disabled")  # the panel follows in the next frame
    assert desk.save().read_text() == page.evaluate("() => warpvecView.facts.text")  # the file of the fit itself
    desk.close()


def test_a_removed_picture_comes_back_by_undo_with_its_edits_also_after_a_reload(
    browser: Any, quick_server: QuickServer, tmp_path: Path
) -> None:
    desk = drawn_logo(browser, quick_server, tmp_path)
    page = desk.page
    page.evaluate(RECOLOUR, [GREEN, ORANGE])
    recoloured = text_of(desk)
    page.locator("#pictures button:not(.open)").click()
    page.locator("#removal button[value=keep]").click()
    assert desk.states() == ["logo done"] and text_of(desk) == recoloured
    page.locator("#pictures button:not(.open)").click()
    page.locator("#removal-yes").click()
    page.wait_for_selector("#empty:not([hidden])")
    reload(desk)
    page.keyboard.press("Control+z")
    wait_for_text(desk, recoloured)
    page.locator("#undo").click()
    assert GREEN in text_of(desk)
    with desk.fitting():
        page.locator("#set-cutout").click()  # the server has the picture again
    desk.save()
    page.locator("#pictures button:not(.open)").click()  # nothing is unsaved now
    page.wait_for_selector("#empty:not([hidden])")
    desk.close()


def test_a_page_goes_on_after_a_reload_and_a_new_start_of_the_server(browser: Any, tmp_path: Path) -> None:
    server = DeskServer(tmp_path)
    desk = DeskPage(browser, server, tmp_path)
    desk.drop(write_logo(tmp_path / "logo.png"))
    desk.wait_for_status("done")
    desk.page.evaluate(RECOLOUR, [GREEN, ORANGE])
    recoloured = text_of(desk)
    desk.page.wait_for_function("() => desk.isKept()")
    server.end(signal.SIGKILL)
    desk.page.wait_for_selector("#lost:not([hidden])")
    server.start()
    desk.page.wait_for_selector("#lost", state="hidden")
    reload(desk)
    wait_for_text(desk, recoloured)
    desk.page.locator("#sides label:has([value=edit])").click()
    with desk.fitting():
        desk.page.locator("#fit-again").click()
    assert ORANGE in text_of(desk)
    assert all("ERR_" in text or "reset" in text.lower() for text in desk.complaints)  # the browser's notes
    desk.page.close()
    assert server.end() == 130
