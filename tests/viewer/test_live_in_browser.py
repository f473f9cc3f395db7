"""The page as scripts of other pages use it: live frames of a fit, other documents, and fitting again."""

from __future__ import annotations

from pathlib import Path

from browser import NEEDS_BROWSER, Viewer, browser_fixture, open_page_fixture  # noqa: F401  (fixtures)
from PIL import Image
from squares import HEIGHT, SQUARES, WIDTH, changed, drawing

pytestmark = NEEDS_BROWSER

FRAME = changed(red=(20, 20, 60, "#0cc", "1", 0))


def call(viewer: Viewer, method: str, *arguments: object) -> object:
    result = viewer.page.evaluate(
        "([method, given]) => window.warpvecView[method](...given)", [method, list(arguments)]
    )
    viewer.settle()
    return result


def test_frames_keep_view_and_selection_and_are_one_undo_step(open_page) -> None:
    viewer = open_page(drawing())
    viewer.press("+")
    viewer.click(130, 30)
    before = viewer.at(0, 0)
    call(viewer, "showDrawing", FRAME)
    assert viewer.color(30, 30) == (0, 0xCC, 0xCC)
    assert viewer.at(0, 0) == before
    assert viewer.selected() == "1 of 4 paths selected: Pass 1"
    # Nothing is edited while frames come.
    viewer.press("Delete", "ArrowLeft", "Control+z")
    assert "stop the fit" in viewer.text("message")
    assert call(viewer, "drawingText").count("<path") == 4
    call(viewer, "finishDrawing", {"svg": drawing({name: SQUARES[name] for name in ("red", "green")})})
    assert call(viewer, "drawingText").count("<path") == 2
    viewer.press("Control+z")
    assert viewer.text("message") == "Undone: Fit"
    assert call(viewer, "drawingText").count("<path") == 4
    assert viewer.color(30, 30) == (0xCC, 0, 0)
    assert viewer.page.locator("#undo").is_disabled()
    viewer.press("Control+Shift+z")
    assert call(viewer, "drawingText").count("<path") == 2


def test_frames_that_are_not_wanted_leave_no_trace(open_page) -> None:
    viewer = open_page(drawing())
    text = call(viewer, "drawingText")
    call(viewer, "showDrawing", FRAME)
    call(viewer, "endDrawing")
    assert call(viewer, "drawingText") == text
    assert viewer.page.locator("#undo").is_disabled()
    assert viewer.color(30, 30) == (0xCC, 0, 0)
    # The brush draws in the level of the drawing that is back.
    viewer.press("b")
    viewer.drag((20, 120), (100, 120))
    assert call(viewer, "drawingText").count("<path") == 5


def test_another_document_replaces_the_first(open_page) -> None:
    viewer = open_page(drawing())
    viewer.press("Control+a", "Delete")
    other = '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 30 20"><path fill="#00f" d="M0 0h30v20H0z"/></svg>'
    call(viewer, "open", {"svg": other, "name": "leaf"})
    assert viewer.page.inner_text("h1") == "leaf"
    assert viewer.color(15, 10) == (0, 0, 255)
    assert viewer.page.locator("#undo").is_disabled()
    assert viewer.page.locator("#layers tbody tr").count() == 1


def test_what_a_drawing_could_not_keep_is_listed_with_it(open_page) -> None:
    viewer = open_page(drawing(), not_kept=["noise", "3 words of letters too small to be read"])
    box = viewer.page.locator("#not-kept-box")
    assert box.locator("li").all_inner_texts() == ["noise", "3 words of letters too small to be read"]
    call(viewer, "showDrawing", FRAME)
    assert box.is_hidden()  # a frame has no facts yet
    call(viewer, "finishDrawing", {"svg": FRAME, "facts": {"figures": {}, "notKept": ["fine texture"]}})
    assert box.locator("li").all_inner_texts() == ["fine texture"]
    viewer.press("Control+z")
    assert box.locator("li").count() == 2
    call(viewer, "open", {"svg": drawing(), "name": "other"})
    assert box.is_hidden()


def test_a_page_without_a_shape_is_not_compared_with_the_picture(open_page, tmp_path: Path) -> None:
    photo = tmp_path / "photo.png"
    Image.new("RGB", (WIDTH, HEIGHT), "#888").save(photo)
    viewer = open_page(drawing({}), photo=photo)
    assert viewer.text("summary") == "0 paths"
    assert viewer.text("shown-psnr") == ""


def test_a_measurement_ends_with_the_drawing_that_it_measures(open_page, tmp_path: Path) -> None:
    photo = tmp_path / "photo.png"
    Image.new("RGB", (WIDTH, HEIGHT), "#888").save(photo)
    viewer = open_page(drawing(), photo=photo)
    # A frame with more levels comes while the levels of the drawing before are measured.
    script = """(text) => {
        const { app } = window.warpvecView;
        app.meter.measured.clear();
        const steps = app.panel.measuring(app.shownLayers);
        steps.next();
        window.warpvecView.showDrawing(text);
        for (let step = steps.next(); !step.done; step = steps.next());
    }"""
    frame = drawing({**SQUARES, "top": (10, 10, 9, "#fff", "1", 2)}, levels=3)
    viewer.page.evaluate(script, frame)
    call(viewer, "finishDrawing", {"svg": frame})
    assert viewer.page.locator("#layers tbody tr").count() == 3


LOOKS = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 240 160">
<linearGradient id="g" gradientUnits="userSpaceOnUse" x1="20" y1="0" x2="80" y2="0">
<stop stop-color="#f00"/><stop offset="1" stop-color="#00f"/></linearGradient>
<g id="level-0"><path d="M20 20H80V80H20Z" fill="url(#g)"/><path d="M120 20H180V80H120Z" fill="#0a0"/>
<path d="M20 120L90 120 120 140" fill="none" stroke="#555" stroke-width="4"/></g></svg>"""

EDIT_LOOKS = """() => {
    const { app } = window.warpvecView;
    const [graded, plain, line] = app.drawing.layers.flatMap(({ items }) => items);
    const change = (label, item, state) => app.commands.record(label, [item], [], () => Object.assign(item, state));
    change("Gradient", graded, { fill: { ...graded.fill, numbers: [20, 20, 20, 80], onCanvas: null } });
    change("Softness", plain, { softness: 3 });
    app.select([line]);
    app.editor.move(5, -10);
    app.endKeys();
    app.editor.restroke({ width: 9 });
}"""


def test_moved_gradients_softness_and_widths_of_moved_strokes_go_on_to_the_next_drawing(open_page) -> None:
    viewer = open_page(LOOKS)
    viewer.page.evaluate(EDIT_LOOKS)
    edited = call(viewer, "drawingText")
    assert all(part in edited for part in ('y2="80"', 'stdDeviation="3"', 'stroke-width="9"', "M25"))
    assert call(viewer, "finishDrawing", {"svg": LOOKS, "edits": "again"}) == ""
    assert call(viewer, "drawingText") == edited
