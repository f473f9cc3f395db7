"""Files that could do harm are drawn in a child process with limits, and look the same there."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from PIL import Image
from svg_files import make_scene, mask_bomb, refusal, svg_file

from warpvec.errors import InputError
from warpvec.sandbox import run
from warpvec.svg import measure, resvg
from warpvec.svg.document import SVG_NAMESPACE as NAMESPACE
from warpvec.svg.document import parse_svg
from warpvec.svg.measure import draw
from warpvec.svg.write import write_svg


@pytest.mark.parametrize(
    "content",
    [
        '<path d="M0 0' + "z" * 100_000 + '"/>',
        '<path d="M0 0' + "z Z\n" * 100_000 + '"/>',
        # resvg panics while it unwinds, with a file that has only paths.
        '<path d="M4 5c1 .5 3-1e9 4 1-1 2-3 2-4-1z"/>',
        '<circle r="1e30" stroke="red" stroke-dasharray="1"/>',
        '<pattern id="p" width="1e6" height="1e6" patternUnits="userSpaceOnUse"><rect width="1" height="1"/></pattern>'
        '<rect width="8" height="4" fill="url(#p)"/>',
    ],
)
def test_files_that_end_the_process_of_resvg_are_refused(content):
    assert "one that resvg can draw" in refusal(draw, svg_file(content, 'width="32" height="24"'))


BAD_PATH = "M4 5c1 .5 3-1e9 4 1-1 2-3 2-4-1z"
"""A path that ends the process of resvg if it is drawn in it."""


@pytest.mark.parametrize(
    "namespace", [NAMESPACE, "http://www.w3.org/1999/xlink", "http://www.w3.org/XML/1998/namespace"]
)
def test_attributes_that_resvg_takes_for_those_without_a_namespace_are_drawn_in_the_child(namespace):
    prefix = "xml" if namespace.endswith("1998/namespace") else "n"
    svg = svg_file(f'<g xmlns:{prefix}="{namespace}"><path {prefix}:d="{BAD_PATH}"/></g>', 'width="32" height="24"')
    assert "one that resvg can draw" in refusal(draw, svg)
    other = svg_file(f'<path xmlns:n="{namespace}x" n:d="{BAD_PATH}"/>')
    assert parse_svg(other if prefix == "n" else svg_file()).plain


@pytest.mark.parametrize(
    "declaration", ['path fill CDATA "red"', 'svg viewBox CDATA "0 0 1e12 1e12"', "svg a CDATA #IMPLIED"]
)
def test_files_that_declare_attributes_are_drawn_in_the_child(declaration):
    svg = svg_file(f'<path d="{BAD_PATH}"/>', 'width="32" height="24"', f"<!DOCTYPE svg [<!ATTLIST {declaration}>]>")
    assert "one that resvg can draw" in refusal(draw, svg)


def test_a_declared_namespace_does_not_hide_an_attribute_or_an_element():
    for name in ("xmlns:n", "xmlns"):
        before = f'<!DOCTYPE svg [<!ATTLIST g {name} CDATA "http://x">]>'
        svg = svg_file('<g><image href="p.png"/></g>', f'xmlns:n="{NAMESPACE}" width="8" height="4"', before)
        assert "must not declare" in refusal(draw, svg)


def test_an_inner_svg_which_has_its_own_scale_is_drawn_in_the_child():
    inner = '<svg viewBox="0 0 1e-9 1e-9" width="8" height="4"><path d="M1 1c1 2 3 4 4 5z"/></svg>'
    assert parse_svg(svg_file()).plain and not parse_svg(svg_file(inner)).plain


STOPS = '<stop stop-color="#fff"/><stop offset="1" stop-color="#00f"/>'
ENDS = 'id="g1" gradientUnits="userSpaceOnUse" cx="1" cy="2" r="3"'


@pytest.mark.parametrize("matrix", ["", 'gradientTransform="matrix(3 1 -.5 1.5 2 3)"'])
@pytest.mark.parametrize("times", [1, 4])
def test_gradients_of_few_stops_are_drawn_here(times, matrix):
    gradient = f"<defs><radialGradient {ENDS} {matrix}>{times * STOPS}</radialGradient></defs>"
    assert parse_svg(svg_file(f'{gradient}<path fill="url(#g1)" d="M1 1c1 2 3 4 4 5z"/>')).plain


@pytest.mark.parametrize(
    "gradient",
    [
        f'<radialGradient {ENDS} href="#g2">{STOPS}</radialGradient>',
        f'<radialGradient {ENDS} n:href="#g2" xmlns:n="http://www.w3.org/1999/xlink">{STOPS}</radialGradient>',
        f'<radialGradient {ENDS} gradientTransform="scale(0)">{STOPS}</radialGradient>',
        f'<radialGradient {ENDS} spreadMethod="repeat">{STOPS}</radialGradient>',
        f'<radialGradient {ENDS} gradientTransform="matrix(1 0 0 1 0)">{STOPS}</radialGradient>',
        f"<radialGradient {ENDS}>{STOPS}{4 * STOPS}</radialGradient>",
        f'<radialGradient {ENDS}><linearGradient id="g2">{STOPS}</linearGradient>{STOPS}</radialGradient>',
        f'<pattern id="g1" width="1" height="1">{STOPS}</pattern>',
    ],
)
def test_gradients_that_could_cost_more_are_drawn_in_the_child(gradient):
    assert not parse_svg(svg_file(f"<defs>{gradient}</defs>")).plain


@pytest.mark.parametrize("number", ["1e-45", "1e39", "-3e38", "NaN", "inf", "", "50%", "1e38%", "9007199254740993"])
def test_hostile_gradients_are_drawn_without_an_error(number):
    for units in ("userSpaceOnUse", "objectBoundingBox"):
        ends = [f'<linearGradient id="g1" x1="{number}" x2="3"', f'<radialGradient id="g1" cx="{number}" r="{number}"']
        for end in ends:
            kind = end[1:].split()[0]
            svg = svg_file(f'{end} gradientUnits="{units}">{STOPS}</{kind}><path fill="url(#g1)" d="M0 0h8v4z"/>')
            assert parse_svg(svg).plain and draw(svg).shape == (4, 8, 3)


def test_points_that_scale_out_of_reach_are_drawn_in_the_child(monkeypatch):
    drawn = []
    monkeypatch.setattr(
        measure, "rasterize", lambda *_, sandboxed, **__: drawn.append(sandboxed) or np.zeros((4, 8, 3))
    )
    path = '<path d="M1 1c1 2 3 4 4 5z"/>'
    for box in ("0 0 8 4", "0 0 1e-6 1e-6", "1e9 0 8 4", "nonsense"):
        draw(svg_file(path, f'width="8" height="4" viewBox="{box}"'), 8, 4)
    draw(svg_file(path + '<rect width="1e9" height="1"/>'), 8, 4)
    assert drawn == [False, True, True, False, True]


def test_shapes_that_paint_the_canvas_many_times_are_drawn_in_the_child(monkeypatch):
    drawn = []
    monkeypatch.setattr(
        measure, "rasterize", lambda *_, sandboxed, **__: drawn.append(sandboxed) or np.zeros((512, 768, 3))
    )
    size = 'width="1024" height="1024"'
    loop = '<path d="M0 0c9 9 20 {0} {0} {0} 9-9-9-9-{0}-{0}z" fill-opacity=".5"/>'
    for content in (
        '<rect width="1024" height="1024" fill-opacity=".5"/>' * 2000,
        '<path d="M0 0H1024V1024H0z"/>' * 2000,
        '<path d="M0 0' + "V1024h.5V0h.5" * 2000 + 'z"/>',
        '<path d="M0 0c' + "0 0 0 1024 0 1024 0 0 0-1024 0-1024" * 5000 + 'z"/>',
        (loop.format(1024) + loop.format(9)) * 5000,
    ):
        draw(svg_file(content, size))
    assert drawn == [True] * 5
    draw(svg_file(loop.format(9) * 4096, size))
    draw(write_svg(make_scene(1000), 768, 512), 768, 512)
    assert drawn[5:] == [False] * 2


def test_files_that_take_too_long_are_refused(monkeypatch):
    monkeypatch.setattr(run, "MAX_SECONDS", 1.0)
    assert "not done in 1 s" in refusal(draw, mask_bomb())


def test_the_child_process_draws_the_same():
    path = '<path d="M1 1c1 2 3 1 4 2z" fill="#a23" fill-opacity=".7"/>'
    in_child = draw(svg_file(f"<desc/><switch/>{path}"))
    assert np.array_equal(in_child, draw(svg_file(path)))
    assert np.array_equal(draw(svg_file(path + "<switch/>"), transparent=True), draw(svg_file(path), transparent=True))


def test_the_same_text_is_drawn_in_one_child(monkeypatch):
    started = []
    monkeypatch.setattr(
        resvg, "run_in_sandbox", lambda *work, **_: started.append(work) or run.run_in_sandbox(*work, **_)
    )
    svg = svg_file("<switch/><!-- drawn again -->")
    first = draw(svg)
    first[:] = 0
    assert draw(svg).any()
    draw(svg, transparent=True)
    assert len(started) == 2


def test_the_child_process_opens_no_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    photo = tmp_path / "p.png"
    Image.new("RGB", (8, 4), "red").save(photo)
    for reference in ("p.png", photo, "./p.png"):  # `draw` refuses these before
        svg = svg_file(f'<image width="8" height="4" href="{reference}"/>')
        assert (resvg.rasterize(svg, sandboxed=False) == (255, 0, 0)).all()
        assert (resvg.rasterize(svg) == 255).all()


def test_drawing_in_the_child_makes_no_folder():
    made = []
    sys.addaudithook(lambda event, arguments: made.append(arguments) if event == "os.mkdir" else None)
    assert resvg.rasterize(svg_file()).shape == (4, 8, 3)
    assert not made


def test_files_with_an_image_are_drawn_in_the_child(monkeypatch):
    drawn = []
    monkeypatch.setattr(
        measure, "rasterize", lambda *_, sandboxed, **__: drawn.append(sandboxed) or np.zeros((4, 8, 3))
    )
    for name in ("image", "s:image"):
        content = f'<g xmlns:s="http://www.w3.org/2000/svg"><{name} href="data:,"/></g>'
        draw(svg_file(content), 8, 4)
        draw(svg_file(content))
    assert drawn == [True] * 4


def test_a_panic_of_resvg_in_this_process_is_an_input_error():
    svg = svg_file('<circle r="1e30" stroke="red" stroke-dasharray="1"/>')
    with pytest.raises(InputError, match="one that resvg can draw"):
        resvg.rasterize(svg, sandboxed=False)
