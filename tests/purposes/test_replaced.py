"""Files for a purpose: they have only what they may use, and look like the drawing."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np
import pytest

from warpvec.purposes.levels import opacities
from warpvec.purposes.table import ANDROID, PURPOSES
from warpvec.purposes.texts import text_for
from warpvec.purposes.vector_drawable import vector_drawable
from warpvec.svg.measure import draw

SIDE = 128
DRAWING = f"""<svg xmlns="http://www.w3.org/2000/svg" width="{SIDE}" height="{SIDE}" viewBox="0 0 {SIDE} {SIDE}"><defs>
<linearGradient id="a" gradientUnits="userSpaceOnUse" x1="10" y1="10" x2="60" y2="30">
<stop offset="0" stop-color="#c22"/>
<stop offset=".3" stop-color="#fc0"/><stop offset="1" stop-color="#06c"/></linearGradient>
<radialGradient id="c" gradientUnits="userSpaceOnUse" cx="0" cy="0" r="1"
gradientTransform="matrix(30 15 -10 20 35 95)">
<stop offset="0" stop-color="#0a6" stop-opacity=".8"/><stop offset="1" stop-color="#0a6" stop-opacity="0"/>
</radialGradient>
<filter id="b1" x="-60%" y="-60%" width="220%" height="220%" color-interpolation-filters="sRGB">
<feGaussianBlur stdDeviation="4"/></filter></defs><rect width="{SIDE}" height="{SIDE}" fill="#eee"/>
<g><path fill="url(#a)" d="M5 5h60v30l-25 20h-35z"/><ellipse fill="url(#c)" cx="35" cy="95" rx="30" ry="25"/>
<path fill="#000" fill-opacity=".5" filter="url(#b1)" d="M80 20h35v60h-35z"/>
<rect fill="#fff" x="80" y="90" width="30" height="20" rx="5" transform="rotate(20 95 100)"/>
<path fill="none" stroke="#036" stroke-width="4" d="M70 120h50"/></g></svg>"""


def error_db(one: str, two: str, side: int = SIDE) -> float:
    difference = draw(one, side, side).astype(float) - draw(two, side, side)
    return float(-10.0 * np.log10(np.square(difference / 255.0).mean() + 1e-12))


REFUSED = {
    "plain": "filter|Gradient|transform|<use|<circle|<ellipse",
    "print": "filter",
    "android": "filter|gradientTransform|transform|<ellipse",
    "tiny": "filter|gradientTransform|[a-z0-9]a[0-9.]+ ",
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_file_has_only_what_its_purpose_allows_and_looks_the_same(name: str) -> None:
    pytest.importorskip("pathops")
    fitted = text_for(DRAWING, PURPOSES[name])
    assert not re.search(REFUSED[name], fitted.text)
    assert error_db(fitted.text, DRAWING) > 38.0
    assert any("soft path as" in words and "rings" in words for words in fitted.words)
    assert text_for(fitted.text, PURPOSES[name]).words == []


@pytest.mark.parametrize(("sides", "box"), [("240", "0 0 240 240"), ("90mm", "0 0 24 24")])
def test_plain_files_have_pixels_for_units_and_opaque_strokes(sides: str, box: str) -> None:
    pytest.importorskip("pathops")
    drawing = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{sides}" height="{sides}" viewBox="0 0 24 24"><g>'
        '<path fill="none" stroke="#c22" stroke-width="2" d="M3.125 5h12v12"/>'
        '<path fill="none" stroke="#06c" stroke-width="2" stroke-opacity=".5" d="M3 20h12v-8"/></g></svg>'
    )
    text = text_for(drawing, PURPOSES["plain"]).text
    assert f'viewBox="{box}"' in text and f'width="{sides}"' in text
    assert "stroke-opacity" not in text and text.count("stroke=") == 1
    assert error_db(text, drawing, 240) > 50.0


@pytest.mark.parametrize(("path", "side"), [("M50 60h120v80z", 24), ("M51 62h127v83l-9 2z", 240)])
def test_short_plain_files_have_the_units_of_the_shorter_text(path: str, side: int) -> None:
    drawing = (
        '<svg xmlns="http://www.w3.org/2000/svg" width="24" height="24" viewBox="0 0 240 240">'
        f'<path fill="#c22" d="{path}"/></svg>'
    )
    text = text_for(drawing, PURPOSES["plain"]).text
    assert f'viewBox="0 0 {side} {side}"' in text
    assert error_db(text, drawing) > 90.0


@pytest.mark.parametrize("side", [16, 128])
def test_rounds_of_many_colours_stay_in_their_places_at_any_size(side: int) -> None:
    pytest.importorskip("pathops")
    colors = ("#c22", "#e71", "#fc0", "#8b2", "#0a6", "#0bb", "#06c", "#639")
    stops = "".join(f'<stop offset="{number / 7:.2f}" stop-color="{each}"/>' for number, each in enumerate(colors))
    half = side // 2
    drawing = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{side}" height="{side}" viewBox="0 0 {side} {side}"><defs>'
        f'<radialGradient id="a" gradientUnits="userSpaceOnUse" cx="{half}" cy="{half}" r="{half}">{stops}'
        f'</radialGradient></defs><g><path fill="url(#a)" d="M0 0h{side}v{side}h-{side}z"/></g></svg>'
    )
    fitted = text_for(drawing, PURPOSES["plain"]).text
    assert error_db(fitted, drawing, 512) > 40.0  # two cubics for each circle: 36


def test_print_has_finer_rings_than_screens() -> None:
    pytest.importorskip("pathops")
    counts = [text_for(DRAWING, PURPOSES[name]).text.count('fill="#000"') for name in ("plain", "print")]
    assert counts[0] < counts[1]


def test_paler_paths_have_fewer_rings_and_all_rings_err_alike() -> None:
    head = f'<svg xmlns="http://www.w3.org/2000/svg" width="{SIDE}" height="{SIDE}" viewBox="0 0 {SIDE} {SIDE}"><defs>'
    blur = '<filter id="b" x="-1" y="-1" width="3" height="3" color-interpolation-filters="sRGB">'
    shape = '<g><path fill="{}" filter="url(#b)" d="M44 44h40v40h-40z"/></g></svg>'
    counts = []
    for color in ("#000", "#888"):
        drawing = f'{head}{blur}<feGaussianBlur stdDeviation="12"/></filter></defs>{shape.format(color)}'
        text = text_for(drawing, PURPOSES["plain"]).text
        counts.append(text.count("<path"))
        assert error_db(text, drawing) > 39.0
    assert counts[1] < 0.6 * counts[0]
    assert counts[0] < 20  # in even steps: 21


def test_machines_get_one_colour_for_each_path_and_no_ground() -> None:
    for name in ("pen", "cricut"):
        fitted = text_for(DRAWING, PURPOSES[name])
        assert not re.search("filter|Gradient|<rect width", fitted.text)
        assert fitted.text.count("fill=") == 5
        assert fitted.text.count('fill="none" stroke="#') == (5 if name == "pen" else 1)


def test_a_font_gets_one_black_shape_with_what_is_light_taken_away() -> None:
    pytest.importorskip("pathops")
    head = '<svg xmlns="http://www.w3.org/2000/svg" width="40" height="40" viewBox="0 0 40 40"><g>'
    drawing = head + '<path fill="#024" d="M5 5h30v30h-30z"/><path fill="#ff0" d="M15 15h10v10h-10z"/></g></svg>'
    text = text_for(drawing, PURPOSES["font"]).text
    image = draw(text, 40, 40)
    assert text.count("<path") == 1 and image[10, 10].max() == 0 and image[20, 20].min() == image[2, 2].min() == 255


def test_paths_on_each_other_have_the_opacity_that_is_wanted() -> None:
    wanted = np.linspace(0.03, 1.0, 25).tolist()
    shown = 1.0 - np.cumprod([1.0 - each for each in opacities(wanted)])
    np.testing.assert_allclose(shown, wanted, atol=0.006)


def test_a_vector_drawable_states_every_path_with_its_paint() -> None:
    pytest.importorskip("pathops")
    root = ElementTree.fromstring(vector_drawable(DRAWING))
    android = "{http://schemas.android.com/apk/res/android}"
    paths = list(root.iter("path"))
    fitted = text_for(DRAWING, ANDROID).text
    assert root.get(android + "width") == f"{SIDE}dp" and root.get(android + "viewportWidth") == str(SIDE)
    assert [path.get(android + "pathData") for path in paths][1:] == re.findall(r' d="([^"]*)"', fitted)
    assert len(list(root.iter("gradient"))) == fitted.count("Gradient id")
    assert all(path.text and path[0].text for path in paths if len(path))  # Android Studio shows no gradient else
    assert paths[-1].get(android + "strokeWidth") == "4" and paths[-1].get(android + "fillColor") is None
