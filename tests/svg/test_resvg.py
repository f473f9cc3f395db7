"""Files that could do harm are drawn in a child process with limits, and look the same there."""

from __future__ import annotations

import tempfile

import numpy as np
import pytest
from PIL import Image
from svg_files import refusal, svg_file

from warpvec.errors import InputError
from warpvec.svg import measure, resvg
from warpvec.svg.document import SVG_NAMESPACE as NAMESPACE
from warpvec.svg.document import parse_svg
from warpvec.svg.measure import draw


@pytest.mark.parametrize(
    "content",
    [
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


def test_files_that_take_too_long_are_refused(monkeypatch):
    monkeypatch.setattr(resvg, "MAX_SECONDS", 1.0)
    masks = "".join(
        f'<mask id="m{k}">' + 2 * f'<rect width="8" height="4" fill="#fff" mask="url(#m{k + 1})"/>' + "</mask>"
        for k in range(30)
    )
    svg = svg_file(masks + '<rect width="8" height="4" mask="url(#m0)"/>')
    assert "not done in 1 s" in refusal(draw, svg)


def test_the_child_process_draws_the_same():
    path = '<path d="M1 1c1 2 3 1 4 2z" fill="#a23" fill-opacity=".7"/>'
    in_child = draw(svg_file(f"<desc/><switch/>{path}"))
    assert np.array_equal(in_child, draw(svg_file(path)))
    assert np.array_equal(draw(svg_file(path + "<switch/>"), transparent=True), draw(svg_file(path), transparent=True))


def test_the_child_process_opens_no_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    photo = tmp_path / "p.png"
    Image.new("RGB", (8, 4), "red").save(photo)
    for reference in ("p.png", photo, "./p.png"):  # `draw` refuses these before
        svg = svg_file(f'<image width="8" height="4" href="{reference}"/>')
        assert (resvg.rasterize(svg, sandboxed=False) == (255, 0, 0)).all()
        assert (resvg.rasterize(svg) == 255).all()


def test_the_child_process_leaves_no_folder(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    resvg.rasterize(svg_file())
    assert not list(tmp_path.iterdir())
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "missing"))
    assert resvg.rasterize(svg_file()).shape == (4, 8, 3)


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
