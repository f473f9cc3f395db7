"""The page between two states: a picture that is being opened, a stream that breaks off, a server that forgets."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from browser import NEEDS_BROWSER, browser_fixture  # noqa: F401  (fixture)
from desk_browser import DeskPage, DeskServer, desk_fixture, desk_server_fixture  # noqa: F401  (fixtures)
from PIL import Image, ImageDraw

pytestmark = NEEDS_BROWSER

HIDE = """(isHidden) => {
    Object.defineProperty(document, "hidden", { configurable: true, get: () => isHidden });
    document.dispatchEvent(new Event("visibilitychange"));
}"""
"""Lets the page believe that its tab has been hidden or shown: tabs without a window are always shown."""


def write_disc(path: Path, color: str) -> Path:
    """Write a picture of a disc and a bar on white, for a drawing of three paths."""
    image = Image.new("RGB", (96, 64), "white")
    pen = ImageDraw.Draw(image)
    pen.ellipse((10, 10, 50, 50), fill=color)
    pen.rectangle((60, 10, 85, 50), fill="#234567")
    image.save(path)
    return path


def write_noise(path: Path, size: tuple[int, int]) -> Path:
    """Write a picture of smooth colours with noise: a photo, for the page."""
    rng = np.random.default_rng(0)
    coarse = Image.fromarray(rng.integers(0, 255, (12, 16, 3), np.uint8)).resize(size, Image.Resampling.BICUBIC)
    noisy = np.asarray(coarse) + rng.normal(0, 8, (size[1], size[0], 3))
    Image.fromarray(noisy.clip(0, 255).astype(np.uint8)).save(path)
    return path


def draw(desk: DeskPage, *sources: Path) -> None:
    """Drop pictures and wait until all are drawn."""
    count = desk.page.locator("#pictures li").count() + len(sources)
    desk.drop(*sources)
    script = """(count) => {
        const states = [...document.querySelectorAll("#pictures .state")].map(({ textContent }) => textContent);
        return states.length === count && states.every((state) => state === "done");
    }"""
    desk.page.wait_for_function(script, arg=count)
    desk.wait_for_status("done")


def delete_first_path(desk: DeskPage) -> str:
    """Delete a path and return the drawing."""
    desk.page.locator("#surface").focus()
    desk.page.keyboard.press("]")
    desk.page.keyboard.press("Delete")
    return drawing(desk)


def drawing(desk: DeskPage) -> str:
    return str(desk.page.evaluate("() => window.warpvecView.drawingText()"))


def test_what_is_called_done_is_in_place(desk: DeskPage, tmp_path: Path) -> None:
    note = """() => new MutationObserver(() => {
        const isDone = document.getElementById("fit-status").textContent.includes("done");
        if (isDone) window.atDone ??= window.warpvecView.drawingText();
    }).observe(document.getElementById("fit-status"), { childList: true })"""
    desk.page.evaluate(note)
    desk.page.locator("#set-mode label").nth(1).click()
    desk.slide("set-max_bytes", 1)  # 2 KB: a short file has user units of its own
    draw(desk, write_noise(tmp_path / "photo.png", (96, 64)))
    desk.page.wait_for_timeout(500)
    assert desk.page.evaluate("() => window.atDone") == drawing(desk)
    assert "0 0 96 64" not in re.findall('viewBox="([^"]*)"', drawing(desk))


def test_a_picture_that_is_being_opened_is_not_mixed_with_the_one_before(desk: DeskPage, tmp_path: Path) -> None:
    draw(desk, write_disc(tmp_path / "red.png", "#d02010"), write_disc(tmp_path / "green.png", "#10a020"))
    page = desk.page
    names = page.locator("#pictures .open")
    shown, other = ("red", "green") if "#d0" in drawing(desk) else ("green", "red")
    edited = delete_first_path(desk)
    # Without a pause the other one is opened, and saved.
    with page.expect_download() as download:
        page.evaluate(
            """(name) => {
            [...document.querySelectorAll("#pictures .open")].find(({ title }) => title === name).click();
            document.querySelector("[data-format=svg]").click();
        }""",
            other,
        )
    assert download.value.suggested_filename == f"{other}.svg"
    saved = download.value.path().read_text()
    assert saved.count("<path") == edited.count("<path") + 1
    names.get_by_text(shown).click()
    page.wait_for_function("(text) => window.warpvecView.drawingText() === text", arg=edited)


def hide_and_show(desk: DeskPage) -> None:
    """Hide the page until it gives its stream up, and let it listen again."""
    page = desk.page
    with page.expect_event("requestfailed", lambda request: "/events?" in request.url):
        page.evaluate(HIDE, True)
    with page.expect_response(lambda response: "/events?" in response.url):
        page.evaluate(HIDE, False)
    page.wait_for_timeout(300)  # what is known is told again


def test_a_hidden_page_gives_up_its_connection_and_loses_nothing(desk: DeskPage, tmp_path: Path) -> None:
    draw(desk, write_disc(tmp_path / "disc.png", "#d02010"))
    edited = delete_first_path(desk)
    hide_and_show(desk)
    assert drawing(desk) == edited
    assert desk.states() == ["disc done"]
    # What happened in between is told.
    desk.page.evaluate(HIDE, True)
    with desk.page.expect_event("requestfailed", lambda request: "/events?" in request.url):
        pass
    desk.page.locator("#restart").click()
    desk.page.wait_for_timeout(1000)
    assert desk.states() == ["disc waiting"]
    desk.page.evaluate(HIDE, False)
    desk.wait_for_status("done")
    assert drawing(desk).count("<path") == edited.count("<path") + 1


def test_more_pages_open_than_a_browser_has_connections(browser, desk_server: DeskServer) -> None:
    context = browser.new_context()
    for _ in range(8):
        page = context.new_page()
        page.goto(desk_server.url, timeout=60_000)
        page.wait_for_selector("body[data-desk]")
        page.evaluate(HIDE, True)
    context.close()


def test_a_stop_before_the_next_fit_begins_leaves_a_drawing_to_edit(desk: DeskPage, tmp_path: Path) -> None:
    page = desk.page
    page.locator("#set-mode label").nth(1).click()
    desk.slide("set-detail", 24)
    desk.drop(write_noise(tmp_path / "photo.png", (400, 300)))
    desk.wait_for_frame()
    page.evaluate("""() => new MutationObserver((_, observer) => {
        if (!document.getElementById("fit-status").textContent.startsWith("Starting")) return;
        observer.disconnect();
        setTimeout(() => document.getElementById("stop").click());
    }).observe(document.getElementById("fit-status"), { childList: true })""")
    desk.slide("set-detail", 20)
    desk.wait_for_status("Stopped")
    page.wait_for_function("() => !window.warpvecView.state.live")
    assert drawing(desk).count("<path") > 0


def test_a_picture_that_the_server_has_forgotten_is_sent_again(desk: DeskPage, tmp_path: Path) -> None:
    draw(desk, write_disc(tmp_path / "disc.png", "#d02010"))
    page = desk.page
    with page.expect_request(lambda request: request.url.endswith("/fit")) as asked, desk.fitting():
        page.locator("#restart").click()
    identifier = asked.value.url.split("/")[-2]
    page.evaluate("(id) => fetch(`pictures/${id}`, { method: 'DELETE' })", identifier)
    with desk.fitting():
        page.locator("#restart").click()
    assert drawing(desk).count("<path") > 0
    desk.complaints.remove(next(text for text in desk.complaints if "404" in text))  # the browser's note


def test_a_picture_is_pasted(browser, desk_server: DeskServer, tmp_path: Path) -> None:
    rights = ["clipboard-read", "clipboard-write"]
    desk = DeskPage(browser, desk_server, tmp_path, permissions=rights)
    source = write_disc(tmp_path / "disc.png", "#d02010")
    desk.page.evaluate(
        """async (bytes) => {
            const blob = new Blob([new Uint8Array(bytes)], { type: "image/png" });
            await navigator.clipboard.write([new ClipboardItem({ "image/png": blob })]);
        }""",
        list(source.read_bytes()),
    )
    desk.page.keyboard.press("Control+v")
    desk.wait_for_status("done")
    assert drawing(desk).count("<path") > 0
    desk.close()


def test_what_is_no_picture_is_named(desk: DeskPage, tmp_path: Path) -> None:
    desk.page.evaluate("""() => {
        const transfer = new DataTransfer();
        transfer.items.add(new File(["words"], "words.txt", { type: "text/plain" }));
        document.body.dispatchEvent(new DragEvent("drop", { dataTransfer: transfer, bubbles: true, cancelable: true }));
    }""")
    assert "This is neither a picture nor an SVG" in desk.page.inner_text("#message")
    desk.page.evaluate("""() => {
        const item = { webkitGetAsEntry: () => ({ isDirectory: true }) };
        const drop = new Event("drop", { bubbles: true, cancelable: true });
        Object.defineProperty(drop, "dataTransfer", { value: { files: [new File([], "photos")], items: [item] } });
        document.body.dispatchEvent(drop);
    }""")
    assert "A folder cannot be dropped" in desk.page.inner_text("#message")
    assert desk.states() == []


@pytest.mark.parametrize("is_saved", [False, True])
def test_a_drawing_that_is_not_saved_is_not_closed_without_a_word(
    browser, desk_server: DeskServer, tmp_path: Path, is_saved: bool
) -> None:
    desk = DeskPage(browser, desk_server, tmp_path)
    draw(desk, write_disc(tmp_path / "disc.png", "#d02010"))
    desk.page.locator("#zoom-fit").click()  # pages that nobody has touched may not ask
    if is_saved:
        desk.save()
        desk.page.wait_for_function("() => desk.isKept()")  # a page that still keeps what it has asks too
    desk.page.reload()  # a page without a window is closed without a question
    assert desk.dialogs == ([] if is_saved else ["beforeunload"])
    desk.close()
