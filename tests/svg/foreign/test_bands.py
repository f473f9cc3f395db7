"""Gradients of any stops look as resvg draws them, by paths of up to eight stops each."""

from __future__ import annotations

import pytest
from svg_files import square_file

from warpvec.image.metrics import psnr
from warpvec.svg.foreign import fill
from warpvec.svg.measure import draw
from warpvec.svg.read import LoadedSvg, read_svg
from warpvec.svg.write import write_svg

TWO = '<stop stop-color="gold"/><stop offset="1" stop-color="navy"/>'
INNER = '<stop offset=".3" stop-color="gold"/><stop offset=".6" stop-color="navy"/>'
COLORS = ("red", "lime", "blue", "gold", "navy")
FIVE = "".join(f'<stop offset="{i / 4}" stop-color="{c}"/>' for i, c in enumerate(COLORS))
STEP = '<stop offset=".5" stop-color="red"/><stop offset=".5" stop-color="blue"/>'
GREY_DIGITS = ("777", "666", "999", "888", "aaa")
GREYS = "".join(f'<stop offset="{i / 4}" stop-color="#{c}"/>' for i, c in enumerate(GREY_DIGITS))
FACE = '<stop offset=".5" stop-color="#FDE030"/><stop offset=".92" stop-color="#F7C02B"/>'
FACE += '<stop offset="1" stop-color="#F4A223"/>'
SHEER = '<stop stop-color="red"/><stop offset=".4" stop-color="gold" stop-opacity=".3"/>'
SHEER += '<stop offset="1" stop-color="navy" stop-opacity=".8"/>'
FADING = '<stop stop-color="red"/><stop offset="1" stop-color="red" stop-opacity="0"/>'
SQUARE = '<rect x="8" y="8" width="48" height="48" fill="url(#g)"/>'
LEAF = '<path d="M4 32Q10 2 32 20T60 30Q50 70 30 50T4 32zM20 30h9v9z" fill="url(#g)"/>'
TURNED = f'<g transform="translate(32 -12)rotate(40)skewX(20)scale(.9,.7)">{SQUARE}</g>'


def linear(stops: str, attributes: str = "") -> str:
    return f'<linearGradient id="g" {attributes}>{stops}</linearGradient>'


def radial(stops: str, attributes: str = "") -> str:
    return f'<radialGradient id="g" {attributes}>{stops}</radialGradient>'


USER = 'gradientUnits="userSpaceOnUse"'

EXACT = {
    "in the box of a turned and skewed shape": linear(TWO, 'gradientTransform="rotate(30 .5 .5)"') + TURNED,
    "in user space of a turned and skewed shape": linear(TWO, f'{USER} x1="10" y1="9" x2="50" y2="30"') + TURNED,
    "other offsets": linear(INNER, 'y2="1"') + LEAF,
    "stops that lie outside of the shape": linear(FIVE, f'{USER} x1="-200" x2="400"') + SQUARE,
    "no length": linear(TWO, 'x2="0"') + SQUARE,
    "a stop for another that implies it": linear(
        '<stop stop-color="#000"/><stop offset=".5" stop-color="#808080"/><stop offset="1" stop-color="#fff"/>'
    ) + SQUARE,
    "stops of a template": f'<linearGradient id="a">{TWO}</linearGradient><linearGradient id="b" href="#a" x2="50%"/>'
    '<linearGradient id="g" xlink:href="#b" y2="100%"/>' + LEAF,
    "round": radial(TWO) + SQUARE,
    "round and moved": radial(TWO, f'{USER} cx="20" cy="30" r="25" gradientTransform="rotate(9)scale(1.2)"') + LEAF,
    "round with a first stop further out": radial(
        '<stop offset=".2" stop-color="#777"/><stop offset="1" stop-color="#ddd"/>', f'{USER} cx="80" cy="9" r="90"'
    ) + SQUARE,
    "reflected beyond the shape": linear(TWO, 'spreadMethod="reflect"') + SQUARE,
    "flat stroke": linear('<stop stop-color="red"/>') + '<path d="M9 9h40v40" stroke="url(#g)" fill="none"/>',
}  # fmt: skip

KEPT = {
    "five stops": (linear(FIVE) + SQUARE, 5),
    "five stops across a leaf with a hole": (linear(FIVE, 'x2=".8" y2=".4"') + LEAF, 5),
    "a step": (linear(STEP) + LEAF, 2),
    "a turned and skewed shape": (linear(FIVE, 'x1=".2" gradientTransform="rotate(30 .5 .5)"') + TURNED, 5),
    "repeated": (linear(TWO, 'x2=".5" spreadMethod="repeat"') + SQUARE, 4),
    "reflected": (linear(TWO, 'x2=".3" spreadMethod="reflect"') + LEAF, 5),
    "translucent": (linear(FIVE) + SQUARE.replace("fill", 'fill-opacity=".5" fill'), 5),
    "a face": (radial(FACE, f'{USER} cx="32" cy="32" r="28"') + '<circle cx="32" cy="32" r="29" fill="url(#g)"/>', 3),
    "round in a corner": (radial(GREYS, f'{USER} cx="10" cy="20" r="60"') + SQUARE, 5),
    "round and repeated": (radial(TWO, f'{USER} cx="32" cy="32" r="18" spreadMethod="repeat"') + SQUARE, 4),
    "an ellipse": (radial(FIVE, 'gradientTransform="rotate(20)scale(1,.6)"') + SQUARE, 5),
    "an ellipse of two stops": (radial(TWO) + '<rect width="60" height="20" fill="url(#g)"/>', 2),
    "an ellipse in a skewed group": (radial(FIVE) + TURNED, 5),
    "stops of several opacities": (linear(SHEER) + SQUARE, 3),
    "one colour that fades": (radial(FADING) + LEAF, 2),
    "an ellipse that fades": (radial(SHEER, 'gradientTransform="rotate(20)scale(1,.6)"') + SQUARE, 3),
}


def agreement(text: str) -> tuple[float, LoadedSvg]:
    drawing = read_svg(text)
    own = write_svg(drawing.scene.scaled(4.0, 4.0), 256, 256, precision=4)
    return psnr(draw(own), draw(text, 256, 256)), drawing


@pytest.mark.parametrize("name", EXACT)
def test_a_gradient_of_two_stops_is_read_as_one_path(name):
    decibels, drawing = agreement(square_file(EXACT[name]))
    assert decibels > 45
    assert len(drawing.scene) == 1 and drawing.omitted == []


@pytest.mark.parametrize("name", KEPT)
def test_the_stops_of_a_gradient_are_kept(name):
    content, count = KEPT[name]
    decibels, drawing = agreement(square_file(content))
    assert decibels > 45
    assert len(drawing.scene) == 1 and drawing.omitted == []
    assert drawing.scene.gradients.stops.count.tolist() == [count]


def test_a_gradient_of_more_stops_is_drawn_in_named_parts():
    many = "".join(f'<stop offset="{i / 9}" stop-color="#{c}"/>' for i, c in enumerate(2 * GREY_DIGITS))
    decibels, drawing = agreement(square_file(linear(many) + SQUARE))
    assert decibels > 45 and len(drawing.scene) == 9
    assert drawing.omitted == ["8 gradient parts: drawn apart, because a path has at most 8 stops"]


def test_more_stops_than_paths_are_worth_are_reduced_and_named():
    spectrum = "".join(f'<stop offset="{i / 40}" stop-color="hsl({i * 97 % 360},90%,50%)"/>' for i in range(41))
    drawing = read_svg(square_file(linear(spectrum) + SQUARE + LEAF))
    assert len(drawing.scene) == 2
    assert drawing.omitted == ["2 gradients of many stops: reduced to 8"]


def test_work_on_gradients_is_limited_for_the_whole_file(monkeypatch):
    monkeypatch.setattr(fill, "RAMP_EFFORT", 30)
    spectrum = "".join(f'<stop offset="{i / 19}" stop-color="hsl({i * 97 % 360},90%,50%)"/>' for i in range(20))
    drawing = read_svg(square_file(linear(spectrum) + SQUARE + linear(TWO).replace('"g"', '"p"') + SQUARE))
    assert sorted(drawing.omitted) == [
        "1 gradient beyond the limit of stops: given its mean colour",
        "1 gradient of many stops: reduced to 8",
    ]


def test_stops_count_each_time_that_they_are_repeated(monkeypatch):
    monkeypatch.setattr(fill, "RAMP_EFFORT", 100)
    drawing = read_svg(square_file(linear(FIVE, 'x2=".04" spreadMethod="reflect"') + 2 * SQUARE))
    assert drawing.omitted == ["2 gradients beyond the limit of stops: given their mean colour"]


@pytest.mark.parametrize("attributes", ['fx="0.2"', 'fr="20%"'])
def test_a_focus_is_named(attributes):
    assert read_svg(square_file(radial(TWO, attributes) + SQUARE)).omitted == ["1 gradient with a focus: centred"]


@pytest.mark.parametrize(
    "attributes", ['x2="1e-300"', f'{USER} x2="1e20"', 'gradientTransform="scale(1e200)"', 'x1="x"']
)
@pytest.mark.parametrize("spread", ["pad", "repeat", "reflect"])
@pytest.mark.parametrize("kind", [linear, radial])
def test_wild_gradients_have_finite_ends(kind, spread, attributes):
    text = square_file(kind(FIVE, f'{attributes} r="1e-4" spreadMethod="{spread}"') + SQUARE)
    gradients = read_svg(text).scene.gradients
    assert gradients is None or gradients.geometry.isfinite().all()
