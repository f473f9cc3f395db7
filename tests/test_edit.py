"""Edits of drawings in Python do what they say, and leave the rest of the file as it was."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import torch

import warpvec
from warpvec.image.metrics import psnr
from warpvec.svg.measure import draw

BLUE, RED = (30, 90, 200), (200, 40, 40)


@pytest.fixture(name="result", scope="module")
def result_fixture() -> warpvec.Result:
    """Return the drawing of a blue disc below a red one, on white."""
    y, x = np.mgrid[:60, :90]
    pixels = np.full((60, 90, 3), 255, np.uint8)
    pixels[(x - 30) ** 2 + (y - 30) ** 2 < 400] = BLUE
    pixels[(x - 50) ** 2 + (y - 30) ** 2 < 200] = RED
    return warpvec.vectorize(pixels, mode="flat")


def drawn(text: str) -> np.ndarray:
    return draw(text, 90, 60)[..., :3] / np.float32(255.0)


def row_of(result: warpvec.Result, color: tuple[int, int, int]) -> int:
    return int((result.scene.color - torch.tensor(color) / 255.0).abs().sum(1).argmin())


def test_a_recoloured_drawing_has_the_new_colour_in_place_of_the_old_one(result: warpvec.Result) -> None:
    edited = warpvec.edit.recolour(result.drawing, "#1e5ac8", "orange")
    assert edited.text == result.drawing.text.replace("royalblue", "orange").replace("1e5ac8", "ffa500")
    with pytest.raises(warpvec.InputError, match="it has #"):
        warpvec.edit.recolour(result.drawing, "#123456", "orange")
    with pytest.raises(warpvec.InputError, match="must be a colour"):
        warpvec.edit.recolour(result.drawing, "#1e5ac8", "no colour")


def test_a_deleted_path_is_gone_and_a_moved_one_is_elsewhere(result: warpvec.Result) -> None:
    blue, red = row_of(result, BLUE), row_of(result, RED)
    image = drawn(warpvec.edit.delete(result.drawing, red).text)
    assert np.allclose(image[30, 55], 1.0) and np.allclose(image[30, 20], np.array(BLUE) / 255.0)
    moved = warpvec.edit.move(result.drawing, [blue, red], 20.0, 4.0)
    assert psnr(drawn(moved.text)[4:, 20:], drawn(result.svg())[:-4, :-20]) > 45.0
    for wrong in (2, -1, [0, 7], "red"):
        with pytest.raises(warpvec.InputError, match="paths"):
            warpvec.edit.delete(result.drawing, wrong)


def test_a_simplified_path_has_fewer_nodes_within_the_tolerance() -> None:
    rng = np.random.default_rng(0)
    angles = np.arange(48) / 48 * 2 * np.pi
    outline = 40.0 + (25.0 + rng.normal(0.0, 0.05, 48))[:, None] * np.stack([np.cos(angles), np.sin(angles)], 1)
    points = " ".join(f"L{x:.2f} {y:.2f}" for x, y in outline)
    text = f'<svg xmlns="http://www.w3.org/2000/svg" width="80" height="80"><path d="M{points[1:]}z"/></svg>'
    picture = draw(text, 80, 80)
    result = warpvec.refine(picture, text, iterations=0)
    scene = result.scene
    curves = replace(scene, structure=replace(scene.structure, is_line=None))
    drawing = result.with_drawing(replace(result.drawing, scene=curves)).drawing
    simple = warpvec.edit.simplify(drawing, 0, 0.5)
    assert simple.scene.structure.segment_count <= 12
    assert psnr(draw(simple.text, 80, 80) / np.float32(255.0), picture / np.float32(255.0)) > 30.0
    with pytest.raises(warpvec.InputError, match="tolerance"):
        warpvec.edit.simplify(drawing, 0, 0.0)


def test_a_drawing_that_is_cut_out_has_no_overlaps_and_looks_the_same(result: warpvec.Result) -> None:
    edited = warpvec.edit.recolour(result.drawing, "#1e5ac8", "orange")
    cut = warpvec.edit.cut_out(edited)
    assert psnr(drawn(cut.text), drawn(edited.text)) > 40.0
    lower = cut.scene.select((cut.scene.color[:, 2] == 0.0).nonzero().flatten())
    alone = drawn(replace(cut, scene=lower, given=None).text)
    assert np.allclose(alone[30, 52], 1.0)  # nothing of the orange disc lies below the red one
    assert cut.encoding.settings.cutout


def test_a_stroke_that_is_cut_out_is_its_outline() -> None:
    text = """<svg xmlns="http://www.w3.org/2000/svg" width="90" height="60"><path fill="#00f" d="M10 10h40v40h-40z"/>
<path fill="none" stroke="#f00" stroke-width="6" d="M5 30h80"/></svg>"""
    result = warpvec.refine(draw(text, 90, 60), text, iterations=0)
    assert psnr(drawn(warpvec.edit.cut_out(result.drawing).text), drawn(text)) > 40.0
