"""Gradients of any stops look as resvg draws them, by paths of two stops each."""

from __future__ import annotations

import pytest
from svg_files import square_file

from warpvec.geometry.paints.registry import LINEAR
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
GREYS = "".join(
    f'<stop offset="{i / 4}" stop-color="#{c}"/>' for i, c in enumerate(("777", "666", "999", "888", "aaa"))
)
FACE = '<stop offset=".5" stop-color="#FDE030"/><stop offset=".92" stop-color="#F7C02B"/>'
FACE += '<stop offset="1" stop-color="#F4A223"/>'
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

PARTS = {
    "five stops": (linear(FIVE) + SQUARE, 4),
    "five stops across a leaf with a hole": (linear(FIVE, 'x2=".8" y2=".4"') + LEAF, 4),
    "a step": (linear(STEP) + LEAF, 2),
    "a turned and skewed shape": (linear(FIVE, 'x1=".2" gradientTransform="rotate(30 .5 .5)"') + TURNED, 4),
    "repeated": (linear(TWO, 'x2=".5" spreadMethod="repeat"') + SQUARE, 2),
    "reflected": (linear(TWO, 'x2=".3" spreadMethod="reflect"') + LEAF, 4),
    "translucent": (linear(FIVE) + SQUARE.replace("fill", 'fill-opacity=".5" fill'), 4),
    "a face": (radial(FACE, f'{USER} cx="32" cy="32" r="28"') + '<circle cx="32" cy="32" r="29" fill="url(#g)"/>', 7),
    "round in a corner": (radial(GREYS, f'{USER} cx="10" cy="20" r="60"') + SQUARE, 4),
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


@pytest.mark.parametrize("name", PARTS)
def test_a_gradient_of_more_stops_is_drawn_in_named_parts(name):
    pytest.importorskip("pathops")
    content, count = PARTS[name]
    decibels, drawing = agreement(square_file(content))
    assert decibels > 45
    assert len(drawing.scene) == count
    parts = "parts" if count > 2 else "part"
    assert drawing.omitted == [f"{count - 1} gradient {parts}: drawn apart, because a path has two stops"]


def test_a_round_gradient_too_steep_for_its_paths_is_named():
    pytest.importorskip("pathops")
    drawing = read_svg(square_file(radial(STEP.replace('offset=".5"', 'offset=".4"', 1)) + SQUARE))
    assert drawing.omitted[0] == "1 steep radial gradient: drawn in rings"


def test_a_gradient_of_nearly_two_stops_is_reduced_and_named():
    bent = '<stop stop-color="#000"/><stop offset=".5" stop-color="#818181"/><stop offset="1" stop-color="#fff"/>'
    decibels, drawing = agreement(square_file(linear(bent) + SQUARE))
    assert decibels > 45 and len(drawing.scene) == 1
    assert drawing.omitted == ["1 gradient of several stops: reduced to two"]


def test_more_stops_than_paths_are_worth_are_reduced_and_named():
    spectrum = "".join(f'<stop offset="{i / 40}" stop-color="hsl({i * 97 % 360},90%,50%)"/>' for i in range(41))
    drawing = read_svg(square_file(linear(spectrum) + SQUARE + LEAF))
    assert len(drawing.scene) == 2
    assert drawing.omitted == ["2 gradients of several stops: reduced to two"]


@pytest.mark.parametrize(
    ("effort", "remark"),
    [
        (5 + 70, "gradient of several stops: reduced to two"),  # five stops and their fits, no bands
        (5 + 2, "gradient of several stops: reduced to two"),  # one fit
        (4, "gradient beyond the limit of stops: given its mean colour"),
    ],
)
def test_work_on_gradients_is_limited_for_the_whole_file(effort, remark, monkeypatch):
    pytest.importorskip("pathops")
    plain = linear(TWO).replace('"g"', '"p"') + SQUARE.replace("#g", "#p")
    bands = 5 + 3 * 10 + 4 * 60
    monkeypatch.setattr(fill, "RAMP_EFFORT", bands + effort)
    drawing = read_svg(square_file(linear(FIVE) + 2 * SQUARE + plain))
    parts = "3 gradient parts: drawn apart, because a path has two stops"
    assert sorted(drawing.omitted) == sorted([parts, f"1 {remark}"])
    assert len(drawing.scene) == 4 + 1 + 1
    assert drawing.scene.gradients.kind[-1] == LINEAR  # two stops cost nothing


def test_stops_count_each_time_that_they_are_repeated(monkeypatch):
    monkeypatch.setattr(fill, "RAMP_EFFORT", 100)
    drawing = read_svg(square_file(linear(FIVE, 'x2=".04" spreadMethod="reflect"') + 2 * SQUARE))
    assert drawing.omitted == ["2 gradients beyond the limit of stops: given their mean colour"]


@pytest.mark.parametrize("attributes", ['fx="0.2"', 'fr="20%"'])
def test_a_focus_is_named(attributes):
    assert read_svg(square_file(radial(TWO, attributes) + SQUARE)).omitted == ["1 gradient with a focus: centred"]


def test_an_ellipse_is_named():
    wide = '<rect width="60" height="20" fill="url(#g)"/>'
    assert read_svg(square_file(radial(TWO) + wide)).omitted == ["1 elliptic gradient: made round"]


@pytest.mark.parametrize(
    "attributes", ['x2="1e-300"', f'{USER} x2="1e20"', 'gradientTransform="scale(1e200)"', 'x1="x"']
)
@pytest.mark.parametrize("spread", ["pad", "repeat", "reflect"])
@pytest.mark.parametrize("kind", [linear, radial])
def test_wild_gradients_have_finite_ends(kind, spread, attributes):
    text = square_file(kind(FIVE, f'{attributes} r="1e-4" spreadMethod="{spread}"') + SQUARE)
    gradients = read_svg(text).scene.gradients
    assert gradients is None or gradients.geometry.isfinite().all()
