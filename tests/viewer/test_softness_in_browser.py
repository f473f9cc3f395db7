"""Soft paths on the page: shown blurred, moved and saved as they are, in a real Chromium."""

from __future__ import annotations

import numpy as np
from browser import NEEDS_BROWSER, Viewer, browser_fixture, open_page_fixture  # noqa: F401  (fixtures)

from warpvec.svg.measure import draw
from warpvec.svg.read import read_svg

pytestmark = NEEDS_BROWSER

DRAWING = """<svg xmlns="http://www.w3.org/2000/svg" width="240" height="160" viewBox="0 0 240 160"><defs>
<filter id="b" x="-40%" y="-40%" width="180%" height="180%" color-interpolation-filters="sRGB">
<feGaussianBlur stdDeviation="6"/></filter>
<filter id="other"><feOffset dx="4"/><feGaussianBlur stdDeviation="2"/></filter></defs>
<g id="a"><path filter="url(#b)" fill="#000" fill-opacity=".5" d="M40 40h100v70h-100z"/>
<path fill="#27c" d="M30 30h100v70h-100z"/></g>
<path filter="url(#other)" fill="#c22" d="M190 20h30v30h-30z"/></svg>"""

PLACES = [(150.5, 80.5), (140.5, 60.5), (144.5, 114.5), (90.5, 112.5), (90.5, 106.5), (60.5, 60.5), (180.5, 120.5)]
"""In the shadow and at its edge, on the square that casts it, and off both."""


def assert_shows(viewer: Viewer, svg: str) -> None:
    image = draw(svg, 240, 160).astype(int)
    shown = np.array(viewer.colors(PLACES))
    assert np.abs(shown - [image[int(y), int(x)] for x, y in PLACES]).max() <= 6  # resvg blurs by three boxes


def test_a_shadow_is_shown_moved_and_saved(open_page) -> None:
    viewer = open_page(DRAWING)
    assert viewer.text("message").count("filter") == 1  # of the filter that does more than blur
    assert_shows(viewer, DRAWING)
    assert viewer.click(136, 104).startswith("1 of 3 paths selected")
    viewer.slide("softness", "3.5")
    softness = read_svg(viewer.saved()).scene.softness
    assert softness is not None and softness.sigma.tolist() == [3.5, 0.0, 0.0]
    viewer.press_button("undo")
    viewer.press("ArrowRight", "ArrowRight")
    saved = viewer.saved()
    softness = read_svg(saved).scene.softness
    assert softness is not None and softness.sigma.tolist() == [6.0, 0.0, 0.0]
    assert_shows(viewer, saved)
    viewer.press_button("undo")
    assert_shows(viewer, DRAWING)
