"""Circles, ellipses and rectangles on the page in a real Chromium: kept byte by byte, moved, turned, and edited."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from browser import NEEDS_BROWSER, Viewer, browser_fixture, open_page_fixture  # noqa: F401  (fixtures)

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
<rect fill="#b3b" x="20" y="90" width="60.01" height="50" rx="12.5" transform="rotate(-10 50.005 115)"/>
<path fill="#777" d="M110 90h80v50z"/></g></svg>"""


def kinds(svg: str) -> list[int]:
    forms = read_svg(svg).scene.forms
    return [] if forms is None else forms.kind.tolist()


@pytest.fixture
def viewer(open_page) -> Viewer:
    return open_page(FORMS)


def test_forms_are_saved_as_they_were_and_read_as_our_own(viewer: Viewer) -> None:
    saved = viewer.saved()
    shapes = [line for line in saved.splitlines() if line.startswith(("<circle", "<ellipse", "<rect fill"))]
    assert shapes == [line for line in FORMS.splitlines() if line.startswith(("<circle", "<ellipse", "<rect fill"))]
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


def test_an_edited_node_makes_a_path(viewer: Viewer) -> None:
    viewer.click(40, 40)
    viewer.press("n")
    viewer.drag((64.5, 40.25), (72, 40.25))
    saved = viewer.saved()
    assert kinds(saved)[:2] == [OUTLINE, ELLIPSE]
    viewer.press("Control+z")
    assert kinds(viewer.saved())[0] == CIRCLE
    difference = np.abs(draw(viewer.saved()).astype(int) - draw(FORMS))
    assert difference.max() <= 2
