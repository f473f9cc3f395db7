"""Reading warpvec's own SVGs exactly, and files that are refused."""

from __future__ import annotations

import re
import sys

import numpy as np
import pytest
import torch
from svg_files import make_scene, refusal, square_file

from warpvec.image.metrics import psnr
from warpvec.svg import read
from warpvec.svg.measure import draw
from warpvec.svg.quantize import quantize
from warpvec.svg.read import read_svg
from warpvec.svg.write import write_svg

FIELDS = ("points", "color", "opacity", "background", "generation")


def path_lines(svg: str) -> list[str]:
    return [line for line in svg.splitlines() if line.startswith("<path")]


@pytest.mark.parametrize("precision", [0, 1, 2, 3, 4])
@pytest.mark.parametrize("segment_count", [2, 4])
def test_our_files_are_read_to_the_last_digit(precision, segment_count):
    scene = make_scene(60, segment_count, seed=precision)
    drawing = read_svg(write_svg(scene, 768, 512, precision=precision).encode())
    expected = quantize(scene, precision)
    for name in FIELDS:
        assert torch.equal(getattr(drawing.scene, name), getattr(expected, name)), name
    assert (drawing.width, drawing.height, drawing.omitted) == (768, 512, [])
    assert drawing.precision == precision


def test_a_file_is_written_again_with_the_same_bytes():
    text = write_svg(make_scene(200), 768, 512, title="a photo", metadata={"curves": 200})
    drawing = read_svg(text)
    again = write_svg(drawing.scene, 768, 512, title="a photo", metadata={"curves": 200})
    assert again == text


def test_our_files_are_read_without_the_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "svgelements", None)
    text = write_svg(make_scene(9), 768, 512)
    assert len(read_svg(text).scene) == 9
    assert "pip install 'warpvec[refine]'" in refusal(read_svg, text.replace("<path ", '<path stroke="red" ', 1))


def test_a_transparent_file_of_ours_is_a_transparent_scene():
    text = write_svg(make_scene(9), 768, 512)
    scene = read_svg(re.sub("<rect.*\n", "", text)).scene
    assert scene.transparent and (scene.background == 0).all()
    assert not read_svg(text).scene.transparent


def test_layers_taken_out_by_hand_leave_the_others_as_they_were(monkeypatch):
    monkeypatch.setitem(sys.modules, "svgelements", None)
    text = write_svg(make_scene(30), 768, 512)
    shortened = re.sub('<g id="layer-2.*?</g>\n', "", text, flags=re.DOTALL).replace("\n", "\r\n  ")
    scene = read_svg(shortened).scene
    assert sorted(set(scene.generation.tolist())) == [0, 2]
    assert set(path_lines(write_svg(scene, 768, 512))) < set(path_lines(text))


@pytest.mark.parametrize("names", [{0: "teal #3e717a", 1: "a", 2: "lines of 21.26 px"}, {0: "b", 1: "7", 2: "2 c"}])
def test_a_name_of_a_layer_follows_its_number_and_comes_back(names):
    text = write_svg(make_scene(30), 768, 512, layer_names=names)
    labels = re.findall(r'inkscape:label="([^"]*)"', text)
    assert labels == [f"{number} {name}" for number, name in enumerate(names.values(), 1)]
    assert read_svg(text).layer_names == names
    old = text
    for label, name in zip(labels, names.values(), strict=True):
        old = old.replace(f'label="{label}"', f'label="{name}"')
    assert read_svg(old).layer_names == names


def test_paths_keep_their_own_numbers_of_cubics():
    two, three = "M1 2c1 0 3 1 4 1-1 2-3 2-4-1z", "M0 0c1 0 3 1 4 1-1 2-3 2-4 1 0 1 0-2 0-2z"
    content = f'<g id="a"><path fill="#123" d="{two}"/><path fill="#45f" d="{three}"/></g>'
    text = square_file(content, 'width="8" height="8" viewBox="0 0 8 8"')
    scene = read_svg(text).scene
    assert scene.structure.loop_first_segment.diff().tolist() == [2, 3]
    assert f'd="{two}"' in write_svg(scene, 8, 8)


def test_a_file_too_large_to_read_is_refused(monkeypatch):
    monkeypatch.setattr(read, "MAX_CHARACTERS", 10)
    assert "at most 10 characters" in refusal(read_svg, square_file(""))


@pytest.mark.parametrize(
    "svg",
    [
        "",
        "nonsense",
        "<svg",
        b"\xff",
        "<a/>",
        '<svg xmlns="http://x"/>',
        square_file("", ""),
        square_file("", 'width="1e9" height="1e9"'),
    ],
)
def test_unreadable_files_are_refused_in_one_line(svg):
    assert refusal(read_svg, svg).startswith("SVG must ")


def test_coordinates_that_are_not_ours_go_to_the_parser_of_others():
    # Counted in whole ticks the first overflows, and commas are not ours, so svgelements reads them.
    for data in ("M999999999999999.5 0c1 0 3 1 4 1z", "M0,0c1,0 3,1 4,1-1,2-3,2-4-1z"):
        text = square_file(f'<g><path fill="#123" d="{data}"/></g>', 'width="8" height="8" viewBox="0 0 8 8"')
        drawing = read_svg(text)
        assert drawing.precision is None
        assert np.isfinite(drawing.scene.segments.numpy()).all()


@pytest.mark.parametrize("attributes", ['height="50"', 'height="50" preserveAspectRatio="xMidYMid slice"'])
def test_a_file_of_ours_in_another_shape_is_placed_as_programs_do(attributes):
    box = '<rect width="100" height="100" fill="#eef"/><circle cx="50" cy="50" r="20" fill="#d44"/>'
    text = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100" width="100" {attributes}>{box}</svg>'
    drawing = read_svg(text)
    assert (drawing.width, drawing.height) == (100, 50)
    assert psnr(draw(write_svg(drawing.scene, 100, 50, precision=4)), draw(text)) > 40
