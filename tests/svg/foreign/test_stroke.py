"""Strokes of other programs: as strokes, or as outlines that resvg draws like its own strokes."""

from __future__ import annotations

import pytest
from svg_files import square_file

from warpvec.image.metrics import psnr
from warpvec.svg.foreign import skia
from warpvec.svg.measure import draw
from warpvec.svg.read import read_svg
from warpvec.svg.write import write_svg

pytest.importorskip("pathops")

BENT = '<path fill="none" d="M8 50L20 10 28 52Q60 64 56 20C50 2 36 20 44 36" stroke="navy" stroke-width="5"'

STROKES = {
    "butt caps and miters": f"{BENT}/>",
    "bevels": f'{BENT} stroke-linejoin="bevel"/>',
    "round joins and caps": f'{BENT} stroke-linejoin="round" stroke-linecap="round"/>',
    "square caps": f'{BENT} stroke-linecap="square"/>',
    "miter limit": f'{BENT} stroke-miterlimit="1.5"/>',
    "dashes": f'{BENT} stroke-dasharray="7 3 1" stroke-dashoffset="-2.5" stroke-linecap="round"/>',
    "dashes in percent": f'{BENT} stroke-dasharray="10%,5%"/>',
    "dashes of no length": f'{BENT} stroke-dasharray="0 0"/>',
    "dots": f'{BENT} stroke-dasharray="0 8" stroke-linecap="round"/>',
    "closed": '<path d="M10 50L32 10 54 50z" fill="gold" stroke="red" stroke-width="6"/>',
    "line after a close": '<path d="M9 9h20v20zl30 30h4" fill="none" stroke="#000" stroke-width="4"/>',
    "point with round caps": '<path d="M20 20h0" stroke="red" stroke-width="20" stroke-linecap="round"/>',
    "point with butt caps": '<path d="M20 20h0" stroke="red" stroke-width="20"/>',
    "basic shapes": '<g fill="none" stroke="teal" stroke-width="3"><line x1="5" y1="5" x2="60" y2="50%"/>'
    '<polyline points="5,20 20,50 30,20"/><polygon points="40,40 60,40 50,60"/><circle cx="15" cy="52" r="8"/>'
    '<rect x="30" y="4" width="20" height="12" rx="4"/></g>',
    "stretched": '<circle r="8" fill="none" stroke="#00f" stroke-width="4" transform="translate(32,32)scale(3,1)"/>',
    "skewed": '<g transform="skewX(30)"><path d="M5 5h20v40h-9" stroke="#080" stroke-width="20%" fill="none"/></g>',
    "below the fill": '<circle cx="32" cy="32" r="20" fill="red" stroke="#000" stroke-width="9" paint-order="stroke"/>',
    "translucent": '<circle cx="32" cy="32" r="20" fill="red" stroke="#000" stroke-width="9" stroke-opacity=".4"/>',
    "inherited by use": '<defs><path id="a" d="M5 32h50" fill="none"/></defs>'
    '<g stroke="red" stroke-width="3"><use href="#a"/><use href="#a" y="9" stroke="blue"/></g>',
    "gradient in the box of the shape":
    '<linearGradient id="g"><stop stop-color="red"/><stop offset="1" stop-color="#00f"/>'
    '</linearGradient><path d="M10 10L50 20 30 50" fill="none" stroke="url(#g)" stroke-width="12"/>',
    "small drawing":
    '<svg viewBox="0 0 .1 .1"><circle cx=".05" cy=".05" r=".03" stroke="red" stroke-width=".01"/></svg>',
    "width without a unit that counts": '<path d="M5 5h50" stroke="red" stroke-width="wide"/>',
}  # fmt: skip


OUTLINED = {
    "dashes": "dashed stroke", "dashes in percent": "dashed stroke", "dots": "dashed stroke",
    "stretched": "unevenly scaled stroke", "skewed": "unevenly scaled stroke",
    "gradient in the box of the shape": "stroke with a gradient",
}  # fmt: skip
"""The strokes that a scene cannot have, and what the remark calls them."""


@pytest.mark.parametrize("name", STROKES)
def test_strokes_look_as_resvg_draws_them(name):
    text = square_file(STROKES[name])
    drawing = read_svg(text)
    own = draw(write_svg(drawing.scene.scaled(4.0, 4.0), 256, 256, precision=4))
    # resvg approximates a stroke by the pixels that it draws at: the larger it draws, the closer it is.
    small, large = draw(text, 256, 256), draw(text, 1024, 1024)
    shrunk = large.reshape(256, 4, 256, 4, 3).mean((1, 3)) / 255.0
    assert psnr(own, small) > 35
    # Of a stroke that stays one, resvg draws the approximation again.
    is_kept = drawing.scene.strokes is not None
    assert psnr(own, shrunk) >= (41 if is_kept else max(43, psnr(small, shrunk) - 0.01))
    assert drawing.omitted == ([] if name not in OUTLINED else [f"1 {OUTLINED[name]}: drawn as its outline"])


def test_strokes_are_paths_above_their_fill():
    drawing = read_svg(square_file('<g id="a"><rect x="9" y="9" width="9" height="9" fill="red" stroke="blue"/></g>'))
    assert drawing.scene.color.tolist() == [[1, 0, 0], [0, 0, 1]]
    counts = drawing.scene.structure.loop_first_segment.diff().tolist()
    assert counts == [4, 4] and drawing.scene.strokes.width.tolist() == [0, 1]


def test_strokes_are_named_without_the_library(monkeypatch):
    monkeypatch.setattr(skia, "load_skia", lambda: None)
    content = '<path d="M0 0h9" stroke="red"/><rect width="9" height="9" style="stroke:#000;stroke-dasharray:1"/>'
    drawing = read_svg(square_file(content))
    assert drawing.omitted == ["1 stroke: left out"] and len(drawing.scene) == 2


def test_more_dashes_than_a_drawing_needs_are_left_out():
    line = '<path d="M0 5h60" stroke="red" stroke-dasharray="{}"/>'
    drawing = read_svg(square_file(line.format("1e-9") + line.format("4")))
    assert drawing.omitted == ["1 too finely dashed stroke: left out", "1 dashed stroke: drawn as its outline"]
    assert len(drawing.scene) == 1


@pytest.mark.parametrize(
    "attributes",
    [
        'stroke-width="1e300"', 'stroke-width="1e-300"', 'stroke-width="-1"', 'stroke-miterlimit="1e300"',
        'stroke-dasharray="1e300 1"', 'stroke-dasharray="-1 2"', 'stroke-dasharray="1" stroke-dashoffset="1e300"',
        'transform="scale(1e200)"', 'transform="scale(1e-200)"', 'stroke-dasharray="' + "1 " * 9999 + '"',
    ],
)  # fmt: skip
def test_wild_strokes_leave_finite_points_or_a_remark(attributes):
    drawing = read_svg(square_file(f'<path d="M5 5h9v1e9l3 1e-30" stroke="red" fill="none" {attributes}/>'))
    assert drawing.scene.segments.isfinite().all()
