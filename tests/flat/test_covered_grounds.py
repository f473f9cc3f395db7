"""Shadows whose shapes are known by what the ground does not reach, and grounds that are shaded nearly everywhere."""

from __future__ import annotations

import numpy as np
import pytest

from warpvec.flat.regions.regions import find_regions
from warpvec.flat.softness import copies
from warpvec.flat.softness.shadows import Shadow
from warpvec.rendering.draw import draw_8_bits
from warpvec.svg.read import read_svg

HEAD = """<svg xmlns="http://www.w3.org/2000/svg" width="120" height="96"><defs>
<filter id="b" filterUnits="userSpaceOnUse" x="-60" y="-60" width="240" height="240" color-interpolation-filters="sRGB">
<feGaussianBlur stdDeviation="{}"/></filter>{}</defs>"""

PAGE = '<rect width="120" height="96" fill="{}"/>'

CAST = '<path filter="url(#b)" fill="{}" fill-opacity="{}" transform="translate({} {})" d="{}"/>'

SHAPE = "M34 24h42v24h-18v21h-24z"

BALL = """<radialGradient id="g" cx=".3" cy=".3" r=".8"><stop stop-color="#06c"/><stop offset=".5" stop-color="#9cf"/>
<stop offset="1" stop-color="#014"/></radialGradient>"""

RAMP = """<linearGradient id="g" x2="0" y2="1"><stop stop-color="#f6f7fb"/><stop offset="1" stop-color="#d9deee"/>
</linearGradient>"""


def picture(sigma: float, *elements: str, defs: str = "", channels: int = 3) -> np.ndarray:
    text = HEAD.format(sigma, defs) + "".join(elements) + "</svg>"
    return draw_8_bits(read_svg(text).scene, 96, 120, 1)[..., :channels].astype(np.float32) / 255.0


def find_shadows(image: np.ndarray) -> list[Shadow]:
    return copies.find_shadows(image, find_regions(image), lambda: False)


def find_shadow(image: np.ndarray) -> Shadow | None:
    found = find_shadows(image)
    return found[0] if found else None


def filled(color: str, data: str = SHAPE) -> str:
    return f'<path fill="{color}" d="{data}"/>'


@pytest.mark.parametrize(("page", "channels"), [(PAGE.format("#fff"), 3), ("", 4)])
def test_a_figure_of_many_gradients_casts_its_shadow(page: str, channels: int) -> None:
    pytest.importorskip("svgelements")
    cast = CAST.format("#000", 0.6, 4, 6, SHAPE)
    found = find_shadow(picture(4, page, cast, filled("url(#g)"), defs=BALL, channels=channels))
    assert found is not None and found.spot is None and found.look.sigma == pytest.approx(4.0, rel=0.05)
    assert found.look.offset == pytest.approx((4.0, 6.0), abs=0.2)


def test_a_white_card_on_a_white_page_casts_its_shadow_and_hides_it() -> None:
    pytest.importorskip("svgelements")
    found = find_shadow(picture(4, PAGE.format("#fff"), CAST.format("#000", 0.6, 0, 2, SHAPE), filled("#fff")))
    assert found is not None and found.spot is None and found.look.sigma == pytest.approx(4.0, rel=0.1)
    assert found.mark is not None  # it is drawn, and then painted like the page


def test_glows_of_two_colours_that_meet_are_two() -> None:
    pytest.importorskip("svgelements")
    left, right = "M18 36h32v24h-32z", "M72 36h32v24h-32z"
    glows = [CAST.format(*each) for each in (("#6d5cff", 1, 0, 0, left), ("#2de", 1, 0, 0, right))]
    image = picture(5, PAGE.format("#1e2235"), *glows, filled("#6d5cff", left), filled("#2de", right))
    assert [round(shadow.look.sigma) for shadow in find_shadows(image)] == [5, 5]


def test_a_gradient_that_is_shaded_everywhere_is_a_ground() -> None:
    pytest.importorskip("svgelements")
    card = "M16 14h88v64h-88z"
    found = find_shadow(
        picture(8, PAGE.format("url(#g)"), CAST.format("#141e50", 0.3, 0, 6, card), filled("#fff", card), defs=RAMP)
    )
    assert found is not None and not found.ground.is_flat and found.look.sigma == pytest.approx(8.0, rel=0.15)
    assert found.look.offset == pytest.approx((0.0, 6.0), abs=0.5)


def test_what_is_written_on_a_card_stays_as_it_is_without_its_shadow() -> None:
    pytest.importorskip("svgelements")
    word = '<path fill="none" stroke="#777" stroke-width="1" d="M40 28l3 9l3 -9M49 28v9M53 28l4 9M57 28l-4 9"/>'
    cast = CAST.format("#000", 0.6, 4, 6, SHAPE)
    image = picture(3, PAGE.format("#ccd6ea"), cast, filled("#fff"), word)
    found = find_shadow(image)
    assert found is not None
    assert np.abs(found.clean - image)[27:38, 39:59].max() < 2.0 / 255.0
