"""Strokes in files: written and read back exactly, drawn by resvg as by the renderer, and kept from other programs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch
from strokes import stroked_scene
from sweep import sweep

from warpvec.geometry.forms.form import FIRST
from warpvec.geometry.forms.registry import CIRCLE, ROUND_RECT
from warpvec.geometry.scene import Scene
from warpvec.geometry.strokes import CAPS, JOINS, Strokes
from warpvec.rendering.draw import draw_exactly
from warpvec.svg.measure import draw
from warpvec.svg.minify import write_minified
from warpvec.svg.quantize import quantize
from warpvec.svg.read import read_svg
from warpvec.svg.write import write_svg


def make_scene(seed: int) -> Scene:
    scene = stroked_scene(seed, 9, 90, 120, filled=2)
    return scene._mapped(lambda tensor: tensor.float() if tensor.is_floating_point() else tensor)


def assert_same_strokes(got: Scene, want: Scene) -> None:
    assert got.strokes is not None and want.strokes is not None
    for name in ("width", "cap", "join", "miter_limit"):
        is_seen = torch.ones(len(got), dtype=torch.bool) if name == "width" else want.strokes.is_stroked
        torch.testing.assert_close(getattr(got.strokes, name)[is_seen], getattr(want.strokes, name)[is_seen])


@sweep("seed", range(3))
@sweep("precision", [2, 3])
def test_a_file_is_read_as_it_was_written(seed: int, precision: int) -> None:
    scene = make_scene(seed)
    text = write_svg(scene, 120, 90, precision=precision)
    got, want = read_svg(text).scene, quantize(scene, precision)
    assert_same_strokes(got, want)
    assert got.structure.is_open is not None and torch.equal(got.structure.is_open, want.structure.is_open)
    torch.testing.assert_close(got.segments, want.segments, rtol=0, atol=1e-4)
    assert write_svg(got, 120, 90, precision=precision) == text


def test_a_minified_file_is_read_as_it_was_written() -> None:
    scene = make_scene(1).scaled(10.0)
    text = write_minified(scene, 1200, 900, ("120", "90"))
    loaded = read_svg(text)
    assert_same_strokes(loaded.scene, quantize(scene, 0))
    assert loaded.minified and write_minified(loaded.scene, 1200, 900, ("120", "90")) == text


def reduced(text: str, factor: int) -> np.ndarray:
    """Return the image [h, w, 3] of an SVG of 320 x 240 as resvg draws it ``factor`` times as large, by box means."""
    large = text.replace(' width="320" height="240"', f' width="{320 * factor}" height="{240 * factor}"', 1)
    image = draw(large, 320 * factor, 240 * factor).astype(np.float64) / 255.0
    return image.reshape(240, factor, 320, factor, 3).mean((1, 3))


def psnr(first: np.ndarray, second: np.ndarray) -> float:
    return float(-10.0 * np.log10(np.square(first - second).mean()))


@pytest.mark.parametrize("seed", range(2))
def test_resvg_draws_strokes_as_the_renderer_does(seed: int) -> None:
    # resvg approximates sides of strokes within a quarter of a pixel of its image, so its image at 8 times the size is
    # the judge. Its own image at this size agrees less with that one than ours does.
    scene = stroked_scene(seed, 40, 240, 320, (1.0, 25.0))
    scene = scene._mapped(lambda tensor: tensor.float() if tensor.is_floating_point() else tensor)
    scene = quantize(replace(scene, opacity=torch.ones_like(scene.opacity)), 2)
    text = write_svg(scene, 320, 240)
    ours, judge = draw_exactly(scene, 240, 320, 1), reduced(text, 8)
    assert psnr(ours, judge) > max(40.0, psnr(reduced(text, 1), judge) + 1.0)


def svg(body: str) -> str:
    return f'<svg xmlns="http://www.w3.org/2000/svg" width="40" height="30" viewBox="0 0 20 15">{body}</svg>'


KEPT = {
    "a line": ('<line x1="1" y1="2" x2="9" y2="5" stroke="#123" stroke-width="3"/>', 6.0, "butt", "miter", [True]),
    "a ring": ('<circle cx="9" cy="7" r="4" fill="none" stroke="#123"/>', 2.0, "butt", "miter", [False]),
    "an open and a closed line": (
        '<path d="M1 1h5v5M8 8h3v3z" fill="none" stroke="red" stroke-linecap="round" stroke-linejoin="bevel"/>',
        2.0, "round", "bevel", [True, False],
    ),
    "a turned group": (
        '<g transform="translate(5 1) rotate(30) scale(2)"><path d="M1 1h2" stroke="red" stroke-linecap="square"/></g>',
        4.0, "square", "miter", [True],
    ),
}  # fmt: skip


@sweep("name", KEPT)
def test_a_stroke_of_another_program_stays_a_stroke(name: str) -> None:
    body, width, cap, join, is_open = KEPT[name]
    loaded = read_svg(svg(body))
    scene = loaded.scene.scaled(1.0)
    strokes = scene.strokes
    assert len(scene) == 1 and isinstance(strokes, Strokes) and not loaded.omitted
    assert strokes.width.tolist() == pytest.approx([width])
    assert (CAPS[int(strokes.cap)], JOINS[int(strokes.join)]) == (cap, join)
    assert (scene.structure.is_open is None and not any(is_open)) or scene.structure.is_open.tolist() == is_open
    image = draw_exactly(scene, 30, 40, 1)
    want = draw(svg(body), 40, 30, transparent=True) / 255.0
    # resvg approximates curved sides within a quarter of a pixel.
    assert np.abs(image - want)[..., 3].max() < 0.25


def test_strokes_of_circles_and_rectangles_of_another_program_keep_their_form() -> None:
    group = '<g fill="none" stroke="red" transform="translate(5 1) rotate(30) scale(2)">'
    scene = read_svg(svg(f'{group}<circle cx="2" cy="2" r="1"/><rect width="2" height="1" rx=".2"/></g>')).scene
    assert scene.strokes is not None and scene.strokes.is_stroked.all() and scene.forms is not None
    assert scene.forms.kind.tolist() == [CIRCLE, ROUND_RECT]
    np.testing.assert_allclose(scene.forms.parameters[:, FIRST], [4.0, 8.0], rtol=1e-5)


OUTLINED = {
    "dashes": '<path d="M1 1h15" stroke="red" stroke-dasharray="2 1"/>',
    "an uneven scale": '<path transform="scale(1 2)" d="M1 1h15v3" fill="none" stroke="red"/>',
    "a stroke on a fill is two paths": '<path d="M1 1h15v9z" fill="blue" stroke="red"/>',
}


def test_other_strokes_become_outlines_and_are_named() -> None:
    dashed, uneven, both = (read_svg(svg(body)) for body in OUTLINED.values())
    assert dashed.scene.strokes is None and dashed.omitted == ["1 dashed stroke: drawn as its outline"]
    assert uneven.scene.strokes is None and len(uneven.omitted) == 1 and "outline" in uneven.omitted[0]
    assert both.scene.strokes is not None and both.scene.strokes.is_stroked.tolist() == [False, True]


@pytest.mark.parametrize(("precision", "dot"), [(0, "h.1"), (1, "h.01"), (2, "h.01"), (4, "h.01")])
def test_a_point_is_a_line_short_enough_to_be_one(precision: int, dot: str) -> None:
    own = '<svg xmlns="http://www.w3.org/2000/svg" width="40" height="30" viewBox="0 0 40 30"><g>{}</g></svg>'
    point = own.format('<path fill="none" stroke="#000" stroke-width="4" stroke-linecap="round" d="M9 8{}m9 1l3 4"/>')
    scene = read_svg(point.format("h0")).scene
    text = write_svg(scene, 40, 30, precision=precision)
    assert f'd="M9 8{dot}M18 9l3 4"' in text  # not relative: the pen is beside the point
    again = read_svg(text)
    assert again.precision == 0 and torch.equal(again.scene.segments, scene.segments)
    difference = draw(text, 40, 30).astype(float) - draw(point.format("h0"), 40, 30)
    assert np.sqrt(np.square(difference).mean()) < (0.8 if precision else 4.5)  # of 255; 50 and 35 dB
    line = read_svg(point.format("l.01 0")).scene
    assert 'd="M9 8l.01 0m9 1l3 4"' in write_svg(line, 40, 30) and line.segments[0, 1, 0] > 9.0
