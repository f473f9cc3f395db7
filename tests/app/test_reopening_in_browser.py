"""On the page of ``warpvec app`` saved drawings are opened again, and drawings are cut out as they are shown."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from browser import NEEDS_BROWSER, browser_fixture  # noqa: F401  (fixture)
from desk_browser import DeskPage
from desk_edits import GREEN, NOTE_HELLO, ORANGE, RECOLOUR, reload, text_of, wait_for_text
from quick_desk import QuickServer, quick_server_fixture, write_logo  # noqa: F401  (fixture)

from warpvec.image.metrics import psnr
from warpvec.svg.measure import draw

pytestmark = NEEDS_BROWSER

OTHER = """<svg xmlns="http://www.w3.org/2000/svg" width="120" height="80">
<style>.warm { fill: #2e9b4f }</style>
<g transform="translate(10 10) scale(2)"><path class="warm" d="M0 0h20v20h-20z"/></g>
<circle cx="90" cy="40" r="20" style="fill:#1c4fa0" onclick="alert(1)"/>
</svg>"""

DELETE = """(color) => {
    const { app } = warpvecView;
    app.select(app.drawing.layers.flatMap(({ items }) => items).filter(({ fill }) => fill === color));
    app.editor.remove();
}"""


def closeness(one: str, two: str) -> float:
    """Return the PSNR of two drawings of the logo over white, as resvg draws them."""
    drawn = [draw(text, 480, 320)[..., :3] / np.float32(255.0) for text in (one, two)]
    return psnr(drawn[0], drawn[1])


def wait_for_drawing(desk: DeskPage) -> None:
    desk.page.wait_for_function("() => warpvecView.state.paths && !warpvecView.state.live")
    desk.wait_for_status("done")


def test_a_saved_drawing_is_opened_with_its_picture_or_alone_and_goes_on(
    browser: Any, quick_server: QuickServer, tmp_path: Path
) -> None:
    desk = DeskPage(browser, quick_server, tmp_path)
    page, source = desk.page, tmp_path / "logo.png"
    saved = saved_with_an_edit(desk)
    page.locator("#pictures button:not(.open)").click()
    for files in ([saved, source], [saved]):
        desk.drop(*files)
        wait_for_drawing(desk)
        assert page.is_checked("#set-cutout") and page.evaluate("() => warpvecView.app.commands.done.length") == 0
        assert desk.save().read_bytes() == saved.read_bytes()
        page.evaluate(RECOLOUR, [ORANGE, "#112233"])
        changed = text_of(desk)
        reload(desk)
        wait_for_text(desk, changed)
        page.locator("#sides label:has([value=edit])").click()
        with desk.fitting():
            page.locator("#fit-again").click()
        assert "#123" in text_of(desk)
        page.locator("#undo").click()
        wait_for_text(desk, changed)
        page.locator("#undo").click()
        assert ORANGE in text_of(desk)
        page.locator("#sides label:has([value=make])").click()
        page.locator("#pictures button:not(.open)").click()
        if page.locator("#removal-yes").is_visible():
            page.locator("#removal-yes").click()
        page.wait_for_selector("#empty:not([hidden])")
        assert page.is_disabled("#save") and not page.is_visible("#size-width")
    desk.close()


def saved_with_an_edit(desk: DeskPage) -> Path:
    """Return the file of a drawing that is cut out, and then edited."""
    desk.drop(write_logo(desk.folder / "logo.png"))
    wait_for_drawing(desk)
    with desk.fitting():
        desk.page.locator("#set-cutout").click()
    desk.page.evaluate(RECOLOUR, [GREEN, ORANGE])
    return desk.save()


def test_drawings_that_come_before_the_server_says_hello_are_opened_once(
    browser: Any, quick_server: QuickServer, tmp_path: Path
) -> None:
    desk = DeskPage(browser, quick_server, tmp_path)
    page = desk.page
    saved = saved_with_an_edit(desk)
    second = saved.with_name("second.svg")
    second.write_bytes(saved.read_bytes())
    page.add_init_script(NOTE_HELLO)
    page.evaluate("() => sessionStorage.clear()")
    events, files, asked = list[Any](), list[Any](), list[str]()
    page.route("**/events?*", lambda route: events.append(route))
    page.route("**/open", lambda route: files.append(route))
    page.on("request", lambda request: asked.append(request.url.rsplit("/", 1)[-1]))
    page.goto(quick_server.url)
    page.wait_for_selector("body[data-desk]")
    desk.drop(saved, second)
    page.wait_for_function("() => document.querySelectorAll('#pictures li').length === 2")
    events.pop().continue_()
    page.wait_for_function("() => window.hasMet")
    page.unroute("**/open")
    for route in files:
        route.continue_()
    while not all(state.endswith("done") for state in desk.states()):
        page.wait_for_timeout(20)
    assert asked.count("open") == 2 and "fit" not in asked
    wait_for_drawing(desk)
    opened = text_of(desk)
    page.locator("#set-cutout").click()  # the picture is drawn again, without what was done before it was saved
    page.wait_for_selector("#proposal:not([hidden])")
    assert "edits in the opened file" in page.inner_text("#proposal-text")
    page.locator("#keep-mine").click()
    wait_for_text(desk, opened)
    assert page.is_checked("#set-cutout")
    page.locator("#set-cutout").click()
    page.locator("#take-new").click()
    assert ORANGE not in text_of(desk) and not page.is_checked("#set-cutout")
    page.locator("#undo").click()
    wait_for_text(desk, opened)
    desk.close()


def test_a_drawing_of_another_program_is_edited_and_a_wrong_picture_is_refused(
    browser: Any, quick_server: QuickServer, tmp_path: Path
) -> None:
    other = tmp_path / "other.svg"
    other.write_text(OTHER)
    desk = DeskPage(browser, quick_server, tmp_path)
    desk.drop(other)
    wait_for_drawing(desk)
    assert desk.save().read_text() == OTHER
    desk.page.evaluate(RECOLOUR, [GREEN, ORANGE])
    saved = desk.save().read_text()
    assert closeness(saved, OTHER.replace(GREEN, ORANGE)) > 45.0
    broken = tmp_path / "broken.svg"
    broken.write_text("<svg")
    (tmp_path / "wide.png").write_bytes(write_logo(tmp_path / "logo.png").read_bytes())
    square = tmp_path / "square.svg"
    square.write_text(OTHER.replace('width="120"', 'width="80"'))
    desk.drop(broken)
    desk.page.wait_for_function("() => document.getElementById('pictures').textContent.includes('brokenfailed')")
    desk.drop(square, tmp_path / "wide.png")
    desk.page.wait_for_function("() => document.getElementById('pictures').textContent.includes('squarefailed')")
    desk.page.locator("#pictures .open", has_text="square").click()
    desk.wait_for_status("proportions")
    desk.page.close()
    assert [text for text in desk.complaints if "422" not in text] == []  # of the broken file


def test_cut_out_cuts_the_drawing_with_its_edits(browser: Any, quick_server: QuickServer, tmp_path: Path) -> None:
    desk = DeskPage(browser, quick_server, tmp_path)
    page = desk.page
    desk.drop(write_logo(tmp_path / "logo.png"))
    wait_for_drawing(desk)
    page.evaluate(RECOLOUR, [GREEN, ORANGE])
    page.evaluate(DELETE, "#f2c230")
    edited = text_of(desk)
    with desk.fitting():
        page.locator("#set-cutout").click()
    cut = text_of(desk)
    assert closeness(edited, cut) > 45.0
    assert "Gradient" not in cut and 'id="background"' not in cut
    assert desk.save().read_text() == page.evaluate("() => warpvecView.facts.text")
    with desk.fitting():
        page.locator("#set-cutout").click()
    assert page.is_hidden("#proposal") and closeness(edited, text_of(desk)) > 45.0
    page.locator("#undo").click()
    page.locator("#undo").click()
    wait_for_text(desk, edited)
    assert not page.is_checked("#set-cutout")
    desk.close()
