"""Strokes on the page in a real Chromium: clicked, counted, and their looks edited and saved."""

from __future__ import annotations

import pytest
from browser import NEEDS_BROWSER, Viewer, browser_fixture, open_page_fixture  # noqa: F401  (fixtures)

from warpvec.svg.measure import draw
from warpvec.svg.read import read_svg

pytestmark = NEEDS_BROWSER

STROKES = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 240 160" width="240" height="160">
<rect id="background" width="240" height="160" fill="#fff"/><g id="layer-1">
<path fill="none" stroke="#c22" stroke-width="8" stroke-linecap="round" stroke-linejoin="round" d="M20 20l80 60h-80"/>
<path fill="none" stroke="#27c" stroke-width="1" d="M140 20h80v60"/>
<circle fill="none" stroke="#182" stroke-width="6" cx="60" cy="120" r="25"/>
<path fill="#777" d="M150 100h50v50h-50z"/></g></svg>"""


@pytest.fixture
def viewer(open_page) -> Viewer:
    return open_page(STROKES)


def test_strokes_are_clicked_on_their_lines_and_counted(viewer: Viewer) -> None:
    assert viewer.text("shown-paths") == "1 circle, 2 strokes, 1 path"
    assert viewer.text("summary").startswith("1 circle, 2 strokes, 1 path")
    for place in [(60, 65), (60, 120), (200, 60)]:  # inside of their lines
        assert viewer.click(*place) == "Nothing selected"
    for place, kind in [
        ((60, 50), "Stroke"), ((180, 21), "Stroke"), ((85, 120), "Circle, stroked"), ((175, 125), "Path"),
    ]:  # fmt: skip
        viewer.click(*place)
        assert viewer.text("shape-kind") == kind


def test_width_ends_and_joins_are_changed_and_saved(viewer: Viewer) -> None:
    viewer.click(60, 50)
    viewer.slide("stroke-width", "12.5")
    viewer.choose("stroke-cap", "Square, half a width longer")
    viewer.choose("stroke-join", "Pointed")
    viewer.slide("stroke-limit", "2")
    saved = viewer.saved()
    look = 'stroke="#c22" stroke-width="12.5" stroke-linecap="square" stroke-miterlimit="2"'
    assert f'<path fill="none" {look} d="M20 20l80 60h-80"/>' in saved
    assert viewer.color(16, 80) == (204, 34, 34)  # the square end
    drawn = draw(saved)
    assert tuple(drawn[80, 16]) == (204, 34, 34) and tuple(drawn[80, 11]) == (255, 255, 255)
    for _ in range(4):
        viewer.press_button("undo")
    looks = [line for line in viewer.saved().splitlines() if "stroke=" in line]
    assert looks == [line for line in STROKES.splitlines() if "stroke=" in line]


def test_nodes_of_a_centre_line_move(viewer: Viewer) -> None:
    viewer.click(60, 50)
    viewer.press("n")
    viewer.drag((100, 80), (120, 90))
    saved = viewer.saved()
    assert 'stroke-width="8" stroke-linecap="round" stroke-linejoin="round" d="M20 20l100 70-100-10"/>' in saved
    strokes = read_svg(saved).scene.strokes
    assert strokes is not None and strokes.is_stroked.tolist() == [True, True, True, False]


def test_looks_of_several_strokes_change_together(viewer: Viewer) -> None:
    viewer.press("Control+a")
    viewer.slide("stroke-width", "3")
    saved = viewer.saved()
    assert saved.count('stroke-width="3"') == 3 and '<path fill="#777" d="M150 100h50v50h-50z"/>' in saved
