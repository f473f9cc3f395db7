"""Circles, ellipses and rectangles on the page in a real Chromium: kept byte by byte, moved, turned, and edited."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from browser import NEEDS_BROWSER, Viewer, browser_fixture, open_page_fixture  # noqa: F401  (fixtures)
from numpy.typing import NDArray

from warpvec.geometry.forms.registry import CIRCLE, ELLIPSE, OUTLINE, RECT, ROUND_RECT
from warpvec.svg.measure import draw
from warpvec.svg.read import read_svg
from warpvec.svg.write import write_svg

pytestmark = NEEDS_BROWSER

FORMS = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 240 160" width="240" height="160">
<rect id="background" width="240" height="160" fill="#fff"/><g id="layer-1">
<circle fill="#c22" cx="40" cy="40.25" r="24.5"/>
<ellipse fill="#27c" cx="120" cy="40" rx="30" ry="18.75" transform="rotate(30 120 40)"/>
<rect fill="#182" fill-opacity=".5" x="170" y="20" width="50" height="40"/>
<rect fill="#b3b" x="20" y="90" width="60.01" height="50" rx="12.5" ry="12.5" transform="rotate(-10 50.005 115)"/>
<path fill="#777" d="M110 90h80v50z"/></g></svg>"""


def shapes(svg: str) -> list[str]:
    return [line for line in svg.splitlines() if line.startswith(("<circle", "<ellipse", "<rect fill"))]


def kinds(svg: str) -> list[int]:
    forms = read_svg(svg).scene.forms
    return [] if forms is None else forms.kind.tolist()


@pytest.fixture
def viewer(open_page) -> Viewer:
    return open_page(FORMS)


def test_forms_are_saved_as_they_were_and_read_as_our_own(viewer: Viewer) -> None:
    saved = viewer.saved()
    assert shapes(saved) == shapes(FORMS)
    loaded = read_svg(saved)
    assert loaded.precision is not None
    assert write_svg(loaded.scene, 240, 160).splitlines()[4:9] == saved.splitlines()[4:9]
    for x, y, color in [(40, 40, (204, 34, 34)), (120, 40, (34, 119, 204)), (50, 115, (187, 51, 187))]:
        assert viewer.color(x, y) == color


def test_moved_and_turned_forms_stay_forms(viewer: Viewer) -> None:
    viewer.press("Control+a", "ArrowRight", "Shift+ArrowDown")
    moved = viewer.saved()
    assert kinds(moved) == [CIRCLE, ELLIPSE, RECT, ROUND_RECT, OUTLINE]
    before, after = (read_svg(text).scene.forms.parameters for text in (FORMS, moved))
    step = (after - before)[0, :2]
    assert step.abs().min() > 0
    torch.testing.assert_close(after[:4, :2] - before[:4, :2], step.expand(4, 2), atol=0.02, rtol=0.0)
    torch.testing.assert_close(after[:4, 2:], before[:4, 2:], atol=0.02, rtol=0.0)


def test_a_form_made_a_path_has_nodes(viewer: Viewer) -> None:
    viewer.click(40, 40)
    viewer.press_button("to-path")
    viewer.press("n")
    viewer.drag((64.5, 40.25), (72, 40.25))
    saved = viewer.saved()
    assert kinds(saved)[:2] == [OUTLINE, ELLIPSE]
    assert viewer.color(70, 40.25) == (204, 34, 34) and viewer.color(10, 40.25) == (255, 255, 255)
    viewer.press("Control+z", "Control+z")
    assert kinds(viewer.saved())[0] == CIRCLE
    difference = np.abs(draw(viewer.saved()).astype(int) - draw(FORMS))
    assert difference.max() <= 2


def test_a_dragged_rim_changes_the_radius_of_a_circle(viewer: Viewer) -> None:
    viewer.click(40, 40)
    viewer.press("n")
    viewer.drag((64.5, 40.25), (72, 40.25))
    assert '<circle fill="#c22" cx="40" cy="40.25" r="32"/>' in viewer.saved()
    viewer.drag((40, 40.25), (45, 44.25))  # its centre
    assert '<circle fill="#c22" cx="45" cy="44.25" r="32"/>' in viewer.saved()
    viewer.page.mouse.dblclick(*viewer.at(77, 44.25))
    assert "A circle has no nodes" in viewer.text("message")
    viewer.press("Control+z", "Control+z")
    assert shapes(viewer.saved()) == shapes(FORMS)


def test_handles_of_turned_rectangles_keep_what_they_do_not_move(viewer: Viewer) -> None:
    viewer.click(50, 115)
    viewer.press("n")
    before = form(viewer.saved(), 3)
    center, angle = before[:2], before[4]
    along, down = unit(angle), unit(angle + np.pi / 2)
    corner = center + before[2] / 2 * along + before[3] / 2 * down
    viewer.drag(tuple(corner), tuple(corner + 8 * along + 6 * down))
    after = form(viewer.saved(), 3)
    assert after[2:4] == pytest.approx([before[2] + 8, before[3] + 6], abs=0.05)
    assert after[4:] == pytest.approx(before[4:], abs=0.02)
    opposite = [f[:2] - f[2] / 2 * along - f[3] / 2 * down for f in (before, after)]
    assert opposite[1] == pytest.approx(opposite[0], abs=0.05)


def test_numbers_of_forms_are_fields(viewer: Viewer) -> None:
    assert viewer.text("shown-paths") == "1 circle, 1 ellipse, 2 rectangles, 1 path"
    viewer.click(40, 40)
    viewer.slide("form-first", "30.5")
    viewer.click(195, 40)
    viewer.slide("form-corner", "7")
    viewer.slide("form-angle", "20")
    viewer.click(120, 40)
    viewer.slide("form-second", "12")
    saved = viewer.saved()
    assert '<circle fill="#c22" cx="40" cy="40.25" r="30.5"/>' in saved
    assert 'width="50" height="40" rx="7" ry="7" transform="rotate(20 195 40)"' in saved
    assert 'rx="30" ry="12" transform="rotate(30 120 40)"' in saved
    for _ in range(4):
        viewer.press_button("undo")
    assert shapes(viewer.saved()) == shapes(FORMS)


def form(svg: str, path: int) -> NDArray[np.float64]:
    found: NDArray[np.float64] = read_svg(svg).scene.forms.parameters[path].double().numpy()
    return found


def unit(angle: float) -> NDArray[np.float64]:
    return np.array([np.cos(angle), np.sin(angle)])
