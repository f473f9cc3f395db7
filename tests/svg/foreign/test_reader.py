"""SVGs of other programs: read as resvg draws them, with a remark for everything left out."""

from __future__ import annotations

import pytest
from svg_files import SQUARE, refusal, square_file

from warpvec.geometry import loops
from warpvec.image.metrics import psnr
from warpvec.svg.foreign import clip, fill, reader
from warpvec.svg.measure import draw
from warpvec.svg.read import read_svg
from warpvec.svg.write import write_svg

FOREIGN = {
    "relative path": '<path d="m10 10h40v40h-40z" fill="red"/>',
    "arcs with packed flags": '<path d="M10 30a20 15 30 1130 10a5 5 0 01-10-2z" fill="#00f"/>',
    "arc of no radius": '<path d="M5 5A0 9 0 0 1 40 40L5 40z"/>',
    "numbers with a bare point": '<path d="M1.e1,+10.L5e1 10. 50,50" fill="#00f"/>',
    "smooth curves": '<path d="M10 30C10 10 30 10 30 30S50 50 50 30L50 60 10 60z"/>'
    '<path d="M2 2q10 0 10 10t10 10L2 22z"/>',
    "smooth curves of another degree":
    '<path d="M5 40q5-40 20-20s30 10 30 30z"/><path d="M5 50c5-40 20 0 20 9t30-30z"/>',
    "round rectangle": '<rect x="5" y="5" width="40" height="30" rx="8" fill="green"/>'
    '<rect y="40" width="9" height="20" rx="30"/>',
    "percentages": '<rect width="50%" height="25%"/><circle cx="50%" cy="60%" r="10%"/>',
    "units": '<rect width="5mm" height="20px"/><rect x="2em" width="1pc" height="9pt"/>',
    "round shapes": '<circle cx="20" cy="20" r="15" fill="tomato"/><ellipse cx="45" cy="45" rx="10" ry="15"/>',
    "polygons": '<polygon points="10,10 50,12 30,50" fill="teal"/><polyline points="1,60 60,60 60,50"/>',
    "transforms": f'<g transform="translate(32 32) rotate(30) scale(.5,1)"><g transform="skewX(20)">{SQUARE}</g></g>',
    "style attribute": '<rect width="50" height="25" style="fill:#f0f;fill-opacity:50%;opacity:.5"/>',
    "style sheet": "<style>/* } */ rect.b,.a{fill:#f0f} #c{fill:lime}rect{fill:blue}</style>"
    '<rect class="x a" width="20" height="25"/><rect class="b" fill="black" x="30" width="20" height="25"/>'
    '<rect id="c" class="a" y="30" width="20" height="25"/><rect x="30" y="30" width="9" height="9"/>',
    "inheritance": f'<g fill="blue" fill-opacity=".5" color="red"><rect width="9" height="9"/>{SQUARE}'
    '<g fill="currentColor"><rect x="30" width="9" height="9"/></g></g>',
    "colours": '<rect width="9" height="9" fill="rgb(10,200,30)"/>'
    '<rect x="9" width="9" height="9" fill="hsl(120,50%,50%)"/>'
    '<rect x="18" width="9" height="9" fill="rgb(10%,20%,30%)"/>'
    '<rect x="27" width="9" height="9" fill="rgba(9,9,9,.5)"/><rect y="9" width="9" height="9" fill="rgb(9 99 9)"/>',
    "opacity of groups": f'<g opacity=".5"><g opacity="50%">{SQUARE}</g></g>',
    "use": f'<defs><g id="r">{SQUARE}</g></defs>'
    '<use xlink:href="#r" x="10" y="10"/><use href="#r" transform="translate(40 40)"/>',
    "symbol": f'<symbol id="r" viewBox="0 0 40 40">{SQUARE}</symbol><use href="#r" width="30" height="30" x="10"/>',
    "nested svg": f'<svg x="50%" y="10" width="20" height="10" viewBox="0 0 40 40">'
    f'{SQUARE}<circle cx="50%" cy="50%" r="10%"/></svg>',
    "hidden": f'<g display="none">{SQUARE}</g><g visibility="hidden">{SQUARE}</g>'
    f'<defs>{SQUARE}</defs><rect fill="none" width="9" height="9"/>',
    "links and switches": f'<a href="#x">{SQUARE}</a>'
    f'<switch><g transform="translate(30)">{SQUARE}</g><circle r="30"/></switch>',
    "a switch of languages": '<switch><rect systemLanguage="xx" width="40" height="30" fill="#3a5"/>'
    '<rect systemLanguage="de, en-GB" width="40" height="30" fill="#a35"/><circle r="60"/></switch>'
    '<switch><rect requiredExtensions="x" y="40" width="40" height="9"/><rect y="50" width="9" height="9"/></switch>'
    '<rect systemLanguage="xx" x="50" width="9" height="9"/><circle systemLanguage="en" cx="50" cy="50" r="9"/>',
    "compound path with a hole": '<path d="M5 5H60V60H5zM20 20V40H40V20zm9 40h5v-5z" fill="navy"/>',
    "line after a close": '<path d="M5 5h20v20zl30 5v40z" fill="navy"/>',
    "broken path": '<path d="M5 5h20v20h-20z L 50 x 60" fill="navy"/>',
    "open path": '<path d="M10 10L50 10 50 50"/>',
    "editors' data": f'<x:view xmlns:x="http://x"><x:rect width="9"/></x:view>'
    f'<g xmlns:x="http://x" x:label="a">{SQUARE}</g>',
    "canvas": '<rect width="100%" height="100%" fill="#abc"/><circle r="30"/>',
}  # fmt: skip


@pytest.mark.parametrize("name", FOREIGN)
def test_files_of_other_programs_look_the_same(name):
    text = square_file(FOREIGN[name])
    drawing = read_svg(text)
    # 40 dB: resvg's anti-aliasing differs between two notations of one outline.
    assert psnr(draw(write_svg(drawing.scene, 64, 64, precision=4)), draw(text)) > 40
    assert drawing.precision is None


@pytest.mark.parametrize(
    ("attributes", "size"),
    [
        ('width="64" height="32" viewBox="0 0 50 50"', (64, 32)),
        ('width="64" height="64" viewBox="-25 -25 100 100"', (64, 64)),
        ('width="64" height="32" viewBox="0 0 50 50" preserveAspectRatio="none"', (64, 32)),
        ('width="64" height="32" viewBox="0 0 50 50" preserveAspectRatio="xMinYMax slice"', (64, 32)),
        ('width="60pt" height="30pt" viewBox="0 0 50 25"', (80, 40)),
        ('viewBox="0 0 50 25"', (50, 25)),
    ],
)
def test_view_boxes_are_scaled_to_the_stated_pixels(attributes, size):
    text = square_file('<path d="M5 5L40 10 20 45z"/>', attributes)
    drawing = read_svg(text)
    assert (drawing.width, drawing.height) == pytest.approx(size)
    assert psnr(draw(write_svg(drawing.scene, *size, precision=4)), draw(text)) > 40


def test_groups_at_the_top_are_generations():
    group = f"<g>{SQUARE}<g>{SQUARE}</g></g>"
    text = square_file(f'{SQUARE}{group}<g id="layer-5-generation-7">{SQUARE}</g>{SQUARE}{group}')
    assert read_svg(text).scene.generation.tolist() == [0, 0, 0, 7, 7, 2, 2]


def test_a_rectangle_that_covers_the_canvas_is_its_colour():
    covered = read_svg(square_file('<g><rect x="-1" width="200" height="64" fill="#336699"/></g>' + SQUARE)).scene
    assert len(covered) == 1 and not covered.transparent
    assert (covered.background * 255).tolist() == pytest.approx([0x33, 0x66, 0x99])
    for rectangle in ('<rect width="64" height="63"/>', '<rect width="64" height="64" opacity=".9"/>'):
        scene = read_svg(square_file(rectangle + SQUARE)).scene
        assert len(scene) == 2 and scene.transparent


OMITTED = {
    '<path d="M0 0h9v9z" stroke="red" stroke-width="0"/>': "",
    '<path d="M0 0h9v9z" stroke="red" vector-effect="non-scaling-stroke"/>':
    "1 non-scaling stroke: scaled with the drawing",
    '<path d="M0 0h9v9z" fill="none" stroke="red" stroke-dasharray="1" pathLength="5"/>':
    "1 stated length of a path: ignored, 1 dashed stroke: drawn as its outline",
    '<path d="M0 0h9v9z" stroke="red" transform="scale(1,0)"/>': "1 stroke out of reach: left out",
    '<path d="M0 0h6v6z" opacity=".5" stroke="red"/>':
    "1 group opacity: given to each of its paths, which shows where they overlap",
    '<text x="9">a</text><text>b</text>': "2 texts: left out",
    '<image width="9" height="9" href="data:image/png;base64,"/>': "1 image: left out",
    f'<mask id="m"/><g mask="url(#m)">{SQUARE}</g>': "1 mask: left out",
    f'<clipPath id="m"/><g clip-path="url(#m)">{SQUARE}</g>': "1 clip path: left out",
    f'<clipPath id="m"><rect x="1" width="40" height="40"/></clipPath><g clip-path="url(#m)">{SQUARE}</g>':
    "1 clip path: left out",
    f'<clipPath id="m"><circle r="29"/></clipPath><g clip-path="url(#m)">{SQUARE}</g>': "",
    f'<clipPath id="m"><path d="M-9-9H30V30H-9zM5 5h9v9h-9z"/></clipPath><g clip-path="url(#m)">{SQUARE}</g>':
    "1 clip path: left out",
    '<clipPath id="m"><rect transform="scale(2)" width="32" height="32"/></clipPath>'
    '<g clip-path="url(#m)"><circle r="90"/></g>': "",
    '<rect style="filter:url(#f)" width="9" height="9"/>': "1 filter: left out",
    '<rect style="mix-blend-mode:multiply" width="9" height="9"/>': "1 blend mode: left out",
    '<path marker-end="url(#m)" d="M0 0h9v9z"/>': "1 marker: left out",
    '<linearGradient id="g"><stop stop-color="red"/></linearGradient>'
    + 2 * '<rect width="9" height="9" fill="url(#g)"/>': "",
    '<linearGradient id="g"><stop stop-color="red" stop-opacity="0"/><stop offset="1" stop-color="red"/>'
    '</linearGradient><rect width="9" height="9" fill="url(#g)"/>': "",
    '<linearGradient id="g"><stop stop-color="red"/><stop offset="1" stop-color="blue"/></linearGradient>'
    '<path d="M5 5h20" stroke="url(#g)"/>': "1 gradient on a box without area: left out",
    '<linearGradient id="g" x2="1e30"><stop stop-color="red"/><stop offset="1" stop-color="blue"/></linearGradient>'
    '<rect width="9" height="9" fill="url(#g)"/>': "1 gradient out of reach: its last colour was taken",
    '<pattern id="g"/><rect width="9" height="9" fill="url(#g) red"/>': "1 pattern fill: left out",
    '<rect width="9" height="9" fill="url(#g)"/>': "1 reference to nothing: left out",
    '<use href="#g"/>': "1 reference to nothing: left out",
    '<g id="g"><use href="#g"/></g>': "1 reference to nothing: left out",
    f'<g opacity=".5">{SQUARE}{SQUARE}</g>':
    "1 group opacity: given to each of its paths, which shows where they overlap",
    '<path d="M5 5H60V60z x"/>': "1 broken path: kept as far as it can be read",
    '<path d="M5 5H60V60z" transform="scale(1e30)"/>': "1 path beyond 16777216 pixels: left out",
    '<style>g > rect{fill:red}</style><rect width="9" height="9"/>': "1 style rule: left out",
    '<rect width="9" height="9" fill="nonsense"/>': "1 fill of unknown colour: left out",
    '<svg x="9" y="9" width="20" height="20" viewBox="0 0 9 9"><circle r="9"/></svg>':
    "1 nested drawing: not cut off at its edges",
    '<symbol id="m"><circle r="9"/></symbol><use href="#m" width="8" height="9"/>':
    "1 nested drawing: not cut off at its edges",
    '<svg width="20" height="20" style="overflow:visible"><circle r="29"/></svg><svg><circle r="99"/></svg>'
    '<svg width="20" height="20"><circle cx="9" cy="9" r="9"/></svg>': "",
    '<svg width="20" height="64"><rect width="64" height="64"/></svg>': "1 nested drawing: not cut off at its edges",
    "<foreignObject/><animate/>": "1 foreign object: left out, 1 animation: left out",
}  # fmt: skip


@pytest.mark.parametrize("content", OMITTED)
def test_omissions_are_named_and_counted(content):
    assert ", ".join(read_svg(square_file(content)).omitted) == OMITTED[content]


@pytest.mark.parametrize(
    ("frame", "allowed"),
    [
        ("M-9-9H90V90H-9z", 3),  # a shape of one loop of four curves
        ("M-9-9H90" + "v1" * 96 + "H-9z", 2),  # longer
        ("M-9-9H90V90H-9z" + "M99 99h9v9z" * 4, 1),  # several loops
    ],
)
def test_clip_paths_are_compared_with_limited_effort(frame, allowed, monkeypatch):
    content = f'<clipPath id="m"><path d="{frame}"/></clipPath>' + f'<g clip-path="url(#m)">{SQUARE}</g>' * 4
    assert read_svg(square_file(content)).omitted == []
    monkeypatch.setattr(clip, "CLIP_EFFORT", 3 * (80 + 32 + 4 + 8) + 100)
    left_out = 4 - allowed
    assert read_svg(square_file(content)).omitted == [f"{left_out} clip path{'s' * (left_out > 1)}: left out"]


def test_outlines_in_many_nested_clip_paths_are_measured_with_limited_effort(monkeypatch):
    nested = '<g clip-path="url(#m)">' * 5 + 20 * SQUARE + "</g>" * 5
    monkeypatch.setattr(clip, "CLIP_EFFORT", 3 * (80 + 32 + 4 + 8 * 20) + 100)
    content = '<clipPath id="m"><path d="M-9-9H90V90H-9z"/></clipPath>' + nested
    assert read_svg(square_file(content)).omitted == ["2 clip paths: left out"]


LEVELS = "".join(f'<g id="a{i + 1}">' + f'<use href="#a{i}"/>' * 10 + "</g>" for i in range(9))
BOMB = f'<defs><path id="a0" d="M0 0h9v9z"/>{LEVELS}</defs><use href="#a9"/>'
"""Draws a billion paths."""


@pytest.mark.parametrize("content", [BOMB, BOMB + "<style>g{fill:red}</style>"])
def test_more_use_than_a_drawing_needs_is_refused(content, monkeypatch):
    monkeypatch.setattr(reader, "MAX_ELEMENTS", 1000)
    assert "at most 1000 elements, " in refusal(read_svg, square_file(content))


def test_more_use_than_a_drawing_needs_is_refused_before_it_is_drawn(monkeypatch):
    monkeypatch.delattr(reader.Painter, "draw")
    assert "at most 32768 elements, " in refusal(read_svg, square_file(BOMB))


@pytest.mark.parametrize("attribute", ['display="none"', 'style="display:none"'])
def test_hidden_use_counts_as_nothing(attribute):
    assert len(read_svg(square_file(BOMB.replace('<use href="#a9"/>', f'<use href="#a9" {attribute}/>'))).scene) == 0


def test_more_elements_than_can_be_read_soon_are_refused(monkeypatch):
    monkeypatch.setattr(reader, "MAX_ELEMENTS", 10)
    assert len(read_svg(square_file('<path d="M0 0h9v9z"/>' * 10)).scene) == 10
    assert "at most 10 elements" in refusal(read_svg, square_file('<path d="M0 0h9v9z"/>' * 11))


@pytest.mark.parametrize(
    "content",
    [
        '<path d="' + "M1 1h2v2z" * 20 + '"/>',
        '<path d="M1 1' + "z" * 40 + '"/>',
        '<polygon points="' + "1,2 " * 20 + '"/>',
        '<path d="M0 0h9v9z"/>' * 10,
        '<defs><path id="a" d="' + "M1 1h2v2z" * 3 + '"/></defs>' + '<use href="#a"/>' * 8,
        f'<g transform="{"scale(1)" * 1000}"/>',
    ],
)
def test_more_numbers_and_text_than_can_be_read_soon_are_refused(content, monkeypatch):
    read_svg(square_file(content))
    monkeypatch.setattr(reader, "MAX_NUMBERS", 30)
    assert "at most 30 numbers" in refusal(read_svg, square_file(content))


def test_a_gradient_of_many_stops_is_read_once(monkeypatch):
    colors = []
    monkeypatch.setattr(fill, "read_color", lambda text: colors.append(text) or fill.Fill((0.0, 0.0, 0.0), 1.0))
    stops = '<stop offset="0" stop-color="red"/>' * 10
    gradients = "".join(f'<linearGradient id="b{k}" href="#a"/>' for k in range(5))
    paths = "".join(f'<path fill="url(#b{k})" d="M0 0h9v9z"/>' * 5 for k in range(5))
    read_svg(square_file(f'<linearGradient id="a">{stops}</linearGradient>{gradients}{paths}'))
    assert colors == ["red"] * 10


def test_use_of_use_is_followed_only_so_deep():
    chain = "".join(f'<g id="a{i + 1}"><use href="#a{i}"/></g>' for i in range(500))
    assert "150 deep" in refusal(read_svg, square_file(f'<defs><path id="a0"/>{chain}</defs><use href="#a500"/>'))


def test_more_curves_than_a_scene_holds_are_refused_while_they_are_read(monkeypatch):
    monkeypatch.setattr(loops, "MAX_CUBICS", 100)
    wave = "M0 0" + "l1 2 1-2" * 30 + "z"
    assert len(read_svg(square_file(f'<path d="{wave}"/>')).scene) == 1
    assert "at most 100 curves" in refusal(read_svg, square_file(f'<path d="{wave}"/>' * 2))
    line = "M0 0" + "h1" * 150
    assert "at most 100 curves" in refusal(read_svg, square_file(f'<path d="{line}"/>' * 2))


def test_elements_of_any_other_namespace_are_ignored():
    # ElementTree marks namespaces with braces.
    for namespace in ("}", "{http://www.w3.org/2000/svg}", "http://www.w3.org/2000/svg}g"):
        assert len(read_svg(square_file(f'<a xmlns="{namespace}"><rect width="9" height="9"/></a>{SQUARE}')).scene) == 1
