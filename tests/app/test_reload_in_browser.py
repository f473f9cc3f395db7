"""A page of ``warpvec app`` that is loaded again, also after its server was started again, has all that it had."""

from __future__ import annotations

import asyncio
import signal
import threading
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import pytest
from browser import NEEDS_BROWSER, browser_fixture  # noqa: F401  (fixture)
from children import limit
from desk_browser import DeskPage, DeskServer
from desk_edits import GREEN, NOTE_HELLO, ORANGE, RECOLOUR, reload, text_of, wait_for_text
from quick_desk import QuickServer, quick_server_fixture, write_logo  # noqa: F401  (fixture)

from warpvec.app import routes
from warpvec.app.streams import Stream

pytestmark = NEEDS_BROWSER


def drawn_logo(browser: Any, server: QuickServer, folder: Path) -> DeskPage:
    """Return a page that has drawn the logo."""
    desk = DeskPage(browser, server, folder)
    desk.drop(write_logo(folder / "logo.png"))
    desk.wait_for_status("done")
    return desk


def recoloured_logo(browser: Any, server: QuickServer, folder: Path) -> tuple[DeskPage, str]:
    """Return a page that has drawn the logo, of which one colour was changed then, and the text of that drawing."""
    desk = drawn_logo(browser, server, folder)
    desk.page.evaluate(RECOLOUR, [GREEN, ORANGE])
    return desk, text_of(desk)


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
    desk, recoloured = recoloured_logo(browser, quick_server, tmp_path)
    page = desk.page
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


def test_a_duplicated_tab_has_a_page_of_its_own_that_begins_with_what_the_other_has(
    browser: Any, quick_server: QuickServer, tmp_path: Path
) -> None:
    desk, recoloured = recoloured_logo(browser, quick_server, tmp_path)
    page = desk.page
    page.wait_for_function("() => desk.isKept()")
    with page.expect_popup() as opened:
        page.evaluate("() => void open(location.href)")  # it gets the storage of the tab, as a duplicated one does
    other = DeskPage.of(opened.value, desk)
    wait_for_text(other, recoloured)
    other.page.evaluate(RECOLOUR, [ORANGE, "#101010"])
    with other.fitting():
        other.page.locator("#set-cutout").click()  # the server gets the picture for this page, too
    changed = text_of(other)
    reload(desk)
    wait_for_text(desk, recoloured)
    reload(other)
    wait_for_text(other, changed)
    other.page.locator("#pictures button:not(.open)").click()
    other.page.locator("#removal-yes").click()
    other.page.wait_for_selector("#empty:not([hidden])")
    with desk.fitting():
        page.locator("#set-cutout").click()
    other.close()
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


class Held:
    """Holds the messages of the server about pictures until a test lets them go."""

    def __init__(self, patch: pytest.MonkeyPatch) -> None:
        self.patch = patch

    def streams(self) -> tuple[threading.Event, threading.Event]:
        """Return what is set when a page begins to listen, and what lets it hear."""
        begins, may_tell = threading.Event(), threading.Event()
        texts = Stream.texts

        async def late(stream: Stream) -> AsyncIterator[bytes]:
            begins.set()
            while not may_tell.is_set():
                await asyncio.sleep(0.01)
            async for text in texts(stream):
                yield text

        self.patch.setattr(Stream, "texts", late)
        return begins, may_tell

    def uploads(self) -> tuple[threading.Event, threading.Event]:
        """Return what is set when a picture has come, and what lets the server answer."""
        comes, may_answer = threading.Event(), threading.Event()
        size_of = routes._size_of

        def late(data: bytes) -> tuple[int, int]:
            comes.set()
            may_answer.wait(limit(60))
            return size_of(data)

        self.patch.setattr(routes, "_size_of", late)
        return comes, may_answer


@pytest.fixture
def held(monkeypatch: pytest.MonkeyPatch) -> Held:
    return Held(monkeypatch)


def test_a_picture_that_crosses_the_list_of_the_server_on_its_way_is_listed_once(
    browser: Any, quick_server: QuickServer, tmp_path: Path, held: Held
) -> None:
    begins, may_tell = held.streams()
    desk = DeskPage(browser, quick_server, tmp_path)
    assert begins.wait(limit(60))
    with desk.page.expect_response(lambda response: response.url.endswith("/fit")):
        desk.drop(write_logo(tmp_path / "logo.png"))
    may_tell.set()
    desk.wait_for_status("done")
    reload(desk)
    desk.wait_for_status("done")
    assert desk.states() == ["logo done"]
    desk.close()


def test_a_picture_that_is_being_sent_when_the_page_is_loaded_again_is_listed_once(
    browser: Any, quick_server: QuickServer, tmp_path: Path, held: Held
) -> None:
    comes, may_answer = held.uploads()
    desk = DeskPage(browser, quick_server, tmp_path)
    desk.drop(write_logo(tmp_path / "logo.png"))
    assert comes.wait(limit(60))
    reload(desk)
    may_answer.set()
    for _ in range(2):
        desk.wait_for_status("done")
        assert desk.states() == ["logo done"]
        reload(desk)
    desk.close()


def test_a_fit_that_is_asked_of_a_new_server_before_it_lists_its_pictures_is_asked_once(
    browser: Any, quick_server: QuickServer, tmp_path: Path, held: Held
) -> None:
    desk = drawn_logo(browser, quick_server, tmp_path)
    (begins, may_tell), (comes, may_answer) = held.streams(), held.uploads()
    desk.page.evaluate(f"() => {{{NOTE_HELLO}}}")
    quick_server.restart()
    assert begins.wait(limit(60))
    desk.page.wait_for_selector("#lost", state="hidden")
    asked: list[int] = []
    desk.page.on("response", lambda response: response.url.endswith("/fit") and asked.append(response.status))
    with desk.fitting():
        desk.page.locator("#set-cutout").click()
        assert comes.wait(limit(60))
        may_tell.set()
        desk.page.wait_for_function("() => window.hasMet")
        may_answer.set()
    assert asked == [404, 202]
    desk.page.locator("#undo").click()
    desk.page.wait_for_selector("#undo:disabled")  # there is one step
    desk.page.close()


def test_a_fit_that_a_reload_has_kept_from_being_asked_is_asked_after_it(
    browser: Any, quick_server: QuickServer, tmp_path: Path
) -> None:
    desk = drawn_logo(browser, quick_server, tmp_path)
    desk.page.route("**/fit", lambda route: None, times=1)  # it never arrives
    with desk.page.expect_request(lambda request: request.url.endswith("/fit")):
        desk.page.locator("#set-cutout").click()
    reload(desk)
    desk.page.wait_for_function("() => warpvecView.app.drawing.settings?.cutout && !warpvecView.state.live")
    assert desk.page.is_checked("#set-cutout")
    desk.page.close()


def test_a_removal_that_the_server_has_not_heard_is_not_undone_by_a_reload(
    browser: Any, quick_server: QuickServer, tmp_path: Path
) -> None:
    desk = drawn_logo(browser, quick_server, tmp_path)
    desk.save()
    desk.page.route("**/pictures/*", lambda route: route.abort())
    desk.page.locator("#pictures button:not(.open)").click()
    desk.page.unroute("**/pictures/*")
    with desk.page.expect_request(lambda request: request.method == "DELETE"):
        reload(desk)
    assert desk.states() == []
    assert all("ERR_FAILED" in text for text in desk.complaints), desk.complaints
    desk.page.close()
