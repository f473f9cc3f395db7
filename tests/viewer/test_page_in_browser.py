"""The page of ``warpvec view`` in a real Chromium: all actions of a user, and the saved file."""

from __future__ import annotations

import re
from collections.abc import Iterator
from io import BytesIO
from xml.etree import ElementTree

import numpy as np
import pytest
from browser import NEEDS_BROWSER, Viewer, browser_fixture, open_page_fixture  # noqa: F401  (fixtures)
from PIL import Image
from squares import HEIGHT, INKSCAPE, SQUARES, WIDTH, changed, drawing, square

from warpvec.image.metrics import psnr
from warpvec.svg.measure import draw, file_facts

pytestmark = NEEDS_BROWSER


def png(image: np.ndarray) -> bytes:
    stream = BytesIO()
    Image.fromarray(image).save(stream, "PNG")
    return stream.getvalue()


def assert_draws_as(svg: str, expected: str, levels: int = 2) -> None:
    """Assert that resvg draws ``svg`` like ``expected``, except for the rounding of blends."""
    difference = np.abs(draw(svg).astype(int) - draw(expected))
    assert difference.max() <= levels, f"{(difference.max(2) > levels).sum()} pixels differ"


def assert_shows(viewer: Viewer, expected: str) -> None:
    """Assert that the page shows what resvg draws for ``expected``, at points away from edges."""
    points = [(x, y) for x in range(5, WIDTH, 10) for y in range(5, HEIGHT, 10)]
    image = draw(expected).astype(int)
    assert np.abs(viewer.colors(points) - image[[y for _, y in points], [x for x, _ in points]]).max() <= 2


def groups_of(svg: str) -> list[tuple[str, int]]:
    """Return id and path count of each group, in a file that has only a background and layers of paths."""
    root = ElementTree.fromstring(svg)
    groups = [child for child in root if child.tag.endswith("}g")]
    assert all(group.get(f"{{{INKSCAPE}}}groupmode") == "layer" for group in groups)
    assert all(path.tag.endswith("}path") for group in groups for path in group)
    return [(group.get("id", ""), len(group)) for group in groups]


PHOTO = draw(changed(white=None))
HISTORY = [{"iteration": i, "curves": 4, "psnr": 10.0 + i, "seconds": i / 4} for i in range(20)]


def test_it_shows_levels_photo_generations_and_residual(open_page) -> None:
    viewer = open_page(drawing(), photo=png(PHOTO), history=HISTORY)
    page = viewer.page
    assert page.inner_text("h1") == "Squares"
    for level, paths in ((1, 2), (2, 4)):
        viewer.slide("shown-count", str(level))
        expected = psnr(draw(drawing(levels=level)), PHOTO)
        # No number while the page says "measuring".
        shown = "parseFloat(document.getElementById('shown-psnr').textContent)"
        page.wait_for_function(f"expected => Math.abs({shown} - expected) < 0.02", arg=expected)
        assert viewer.text("shown-paths") == f"{paths} paths"
    # Left of the split is the photo, which lacks the white square.
    assert viewer.color(210, 130) == (255, 255, 255)
    viewer.slide("split", "100")
    assert viewer.color(210, 130) == (0x88, 0x88, 0x88)
    page.locator("#split-line span").hover()
    page.mouse.down()
    page.mouse.move(*viewer.at(WIDTH / 4, 80), steps=4)
    page.mouse.up()
    assert abs(float(page.locator("#split").input_value()) - 25) <= 1
    assert viewer.color(210, 130) == (255, 255, 255)
    page.get_by_role("radio", name="Layers").check()
    assert viewer.color(130, 30) == (68, 1, 84)
    assert viewer.color(210, 130) == (253, 231, 37)
    page.get_by_role("radio", name="Differences").check()
    assert max(viewer.color(230, 80)) <= 4
    assert min(viewer.color(210, 130)[:2]) > 240
    page.locator("#layers [aria-label^=Show]").last.uncheck()
    assert viewer.text("shown-paths") == "2 paths"


def test_it_plots_the_fit_and_lists_figures_and_settings(open_page) -> None:
    viewer = open_page(drawing(), photo=png(PHOTO), history=HISTORY)
    viewer.page.get_by_text("Details").first.click()
    line = viewer.page.locator("#plot .line")
    by_iteration = line.get_attribute("d")
    assert by_iteration.count("L") == len(HISTORY) - 1
    viewer.page.get_by_role("radio", name="seconds").check()
    assert viewer.page.locator("#plot text").all_text_contents()[-1] == "seconds"
    figures = viewer.text("figures")
    assert f"{file_facts(drawing())['bytes']:,} bytes" in figures
    assert f"{psnr(draw(drawing()), PHOTO):.2f} dB" in figures
    viewer.page.get_by_text("Settings of the fit").click()
    assert re.search(r"seed\s+7", viewer.text("settings"))


def test_paths_are_selected_by_click_band_level_and_key(open_page) -> None:
    viewer = open_page(drawing())
    assert viewer.click(70, 70) == "1 of 4 paths selected: Pass 2"
    assert viewer.click(70, 70, "Alt") == "1 of 4 paths selected: Pass 1"
    assert viewer.click(130, 30, "Shift") == "2 of 4 paths selected"
    assert viewer.click(130, 30, "Shift") == "1 of 4 paths selected: Pass 1"
    assert viewer.click(5, 5) == "Nothing selected"
    viewer.drag((110, 10), (230, 150))
    assert viewer.selected() == "2 of 4 paths selected"
    # A band that only touches takes nothing, but with Alt.
    viewer.drag((5, 150), (70, 70))
    assert viewer.selected() == "Nothing selected"
    viewer.page.keyboard.down("Alt")
    viewer.drag((5, 150), (70, 70))
    viewer.page.keyboard.up("Alt")
    assert viewer.selected() == "2 of 4 paths selected"
    viewer.press("Escape")
    viewer.choose("filter", "Pass 2")
    viewer.drag((110, 10), (230, 150))
    assert viewer.selected() == "1 of 4 paths selected: Pass 2"
    assert viewer.click(130, 30) == "Nothing selected"
    viewer.choose("filter", "All shown")
    viewer.press("Control+a")
    assert viewer.selected() == "4 of 4 paths selected"
    viewer.press("Escape", "]", "]", "[")
    assert viewer.selected() == "1 of 4 paths selected: Pass 1"
    # Hidden paths cannot be selected.
    viewer.slide("shown-count", "1")
    viewer.page.locator("#surface").focus()
    viewer.press("Control+a")
    assert viewer.selected() == "2 of 4 paths selected"


def _move(viewer: Viewer) -> None:
    viewer.click(210, 130)
    viewer.drag((210, 130), (190, 100))


def _nudge(viewer: Viewer) -> None:
    viewer.click(210, 130)
    viewer.press("Shift+ArrowLeft", *["ArrowUp"] * 3)


def _scale_by_handle(viewer: Viewer) -> None:
    viewer.click(210, 130)
    viewer.drag((200, 120), (180, 100))


def _scale_by_number(viewer: Viewer) -> None:
    viewer.click(210, 130)
    viewer.slide("scale", "200")
    viewer.press_button("scale-apply")


def _recolor(viewer: Viewer) -> None:
    viewer.click(130, 30)
    viewer.slide("fill", "#ffcc00")


def _pick_color(viewer: Viewer) -> None:
    viewer.click(130, 30)
    viewer.press("i")
    viewer.click(30, 30)
    viewer.press("v")


def _fade(viewer: Viewer) -> None:
    viewer.click(130, 30)
    viewer.slide("opacity", "0.25")


def _delete(viewer: Viewer) -> None:
    viewer.drag((110, 10), (230, 150))
    viewer.press_button("delete")


def _reorder(viewer: Viewer) -> None:
    viewer.click(30, 30)
    viewer.choose("to-layer", "Pass 2")
    viewer.press_button("back")
    viewer.press_button("raise")


def _brush(viewer: Viewer) -> None:
    viewer.slide("width", "10")
    viewer.slide("fill", "#ffff00")
    viewer.press("b")
    viewer.drag((20, 120), (100, 120), (180, 120))
    viewer.press("v")


# Name -> action, a file that the saved one must draw like, its path counts by level.
EDITS = {
    "move": (_move, changed(white=(180, 90, 20, "#fff", "1", 1)), [2, 2]),
    "nudge": (_nudge, changed(white=(190, 117, 20, "#fff", "1", 1)), [2, 2]),
    "scale by a handle": (_scale_by_handle, changed(white=(180, 100, 40, "#fff", "1", 1)), [2, 2]),
    "scale by a number": (_scale_by_number, changed(white=(190, 110, 40, "#fff", "1", 1)), [2, 2]),
    "recolour": (_recolor, changed(green=(120, 20, 60, "#fc0", "1", 0)), [2, 2]),
    "pick a colour": (_pick_color, changed(green=(120, 20, 60, "#c00", "1", 0)), [2, 2]),
    "opacity": (_fade, changed(green=(120, 20, 60, "#0a0", ".25", 0)), [2, 2]),
    "delete": (_delete, changed(green=None, white=None), [1, 1]),
    # Red above the blue square, in its level.
    "reorder": (_reorder, drawing({k: (*SQUARES[k][:5], 0) for k in ("green", "blue", "red", "white")}), [1, 3]),
}


@pytest.fixture(scope="module")
def editor(browser: object, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Viewer]:
    """Open one page for all edits; each of them is undone at its end."""
    viewer = Viewer(browser, tmp_path_factory.mktemp("editor"), drawing())
    yield viewer
    viewer.close()


@pytest.mark.parametrize("name", EDITS)
def test_an_edit_is_saved_undone_and_redone(editor: Viewer, name: str) -> None:
    act, expected, paths = EDITS[name]
    act(editor)
    assert_shows(editor, expected)
    edited = editor.saved()
    assert_draws_as(edited, expected)
    assert [count for _, count in groups_of(edited)] == paths
    assert file_facts(edited)["paths"] == sum(paths)
    count = _press_until_disabled(editor, "undo")
    assert_shows(editor, drawing())
    assert_draws_as(editor.saved(), drawing(), levels=0)
    assert _press_until_disabled(editor, "redo") == count > 0
    assert editor.saved() == edited
    _press_until_disabled(editor, "undo")
    editor.press("Escape")


def _press_until_disabled(viewer: Viewer, button: str) -> int:
    """Press a button until it is disabled; return how often."""
    count = 0
    while viewer.page.locator(f"#{button}").is_enabled():
        viewer.press_button(button)
        count += 1
    return count


def test_a_brush_stroke_is_a_closed_path_of_its_level(open_page) -> None:
    viewer = open_page(drawing())
    viewer.choose("brush-layer", "Pass 1")
    _brush(viewer)
    saved = viewer.saved()
    assert groups_of(saved) == [("layer-1-generation-0", 3), ("layer-2-generation-1", 2)]
    (path,) = re.findall(r'<path fill="#ff0" d="(M[^"]*)"/>', saved)
    assert re.fullmatch(r"M[-\d. ]+c[-\d. ]+z", path)
    assert not re.search(r"\.\d{3}", path)
    difference = (draw(saved) != draw(drawing())).any(2)
    # The stroke is 10 wide and 160 long with round ends, and hides nothing else.
    assert abs(difference.sum() - (1600 + 25 * np.pi)) < 40
    assert (draw(saved)[118:122, 20:180] == (255, 255, 0)).all()
    viewer.press("Control+z")
    assert_draws_as(viewer.saved(), drawing(), levels=0)


def test_saving_keeps_everything_that_was_not_edited(open_page) -> None:
    viewer = open_page(drawing())
    _nudge(viewer)
    saved = viewer.saved()
    assert [path for path in re.findall(r"<path[^>]*>", drawing()) if path in saved] == [
        square(*SQUARES[name]) for name in ("red", "green", "blue")
    ]
    root = ElementTree.fromstring(saved)
    assert {name: root.get(name) for name in ("width", "height", "viewBox")} == {
        "width": "240", "height": "160", "viewBox": "0 0 240 160",
    }  # fmt: skip
    assert [child.text for child in root[:2]] == ["Squares", '{"generator":"warpvec","seed":7,"edited":true}']
    assert root[2].attrib == {"id": "background", "width": "240", "height": "160", "fill": "#888"}
    assert root[3].get(f"{{{INKSCAPE}}}label") == "Layer 1: generation 0, 2 paths"
