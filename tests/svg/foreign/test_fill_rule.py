"""Paths under the even-odd rule become paths under the non-zero rule."""

from __future__ import annotations

import pytest
from svg_files import square_file

from warpvec.image.metrics import psnr
from warpvec.svg.foreign import skia
from warpvec.svg.measure import draw
from warpvec.svg.read import read_svg
from warpvec.svg.write import write_svg

STAR = '<path fill-rule="evenodd" fill="navy" d="M32 2L50 60 4 24H60L14 60z"/>'


def agreement(content: str) -> float:
    """Return the PSNR of a drawing written again against its original."""
    text = square_file(content)
    scene = read_svg(text).scene.scaled(4.0, 4.0)
    return psnr(draw(write_svg(scene, 256, 256, precision=4)), draw(text, 256, 256))


@pytest.mark.parametrize("rule", ["nonzero", "evenodd"])
@pytest.mark.parametrize(
    "data",
    [
        "M5 5H60V60H5zM20 20H40V40H20z",  # a hole by the even-odd rule alone
        "M5 5H60V60H5zM20 20V40H40V20z",
        "M2 2H62V62H2zM10 10H54V54H10zM20 20H44V44H20zM28 28V36H36V28z",  # four deep
        "M5 5H60V60H5zM10 10h9v9h-9zM30 30h9v9h-9z",
        "M5 32a27 27 0 1 0 54 0a27 27 0 1 0-54 0M15 32a17 17 0 1 0 34 0a17 17 0 1 0-34 0",
    ],
)
def test_loops_within_loops_look_the_same(data, rule):
    content = f'<path d="{data}" fill-rule="{rule}" fill="navy"/>'
    assert agreement(content) > 45
    assert read_svg(square_file(content)).omitted == []


def test_a_star_that_crosses_itself_is_taken_apart():
    pytest.importorskip("pathops")
    assert agreement(STAR) > 45
    assert read_svg(square_file(STAR)).omitted == []


def test_a_star_is_named_without_the_library(monkeypatch):
    monkeypatch.setattr(skia, "load_skia", lambda: None)
    remark = "1 self-crossing even-odd fill: filled by the non-zero rule"
    assert read_svg(square_file(STAR)).omitted == [remark]


def test_more_crossings_than_can_be_taken_apart_soon_are_named():
    places = "".join(f"L{i * 37 % 64} {i * 23 % 61}" for i in range(200))
    drawing = read_svg(square_file(f'<path fill-rule="evenodd" d="M0 0{places}z"/>'))
    assert drawing.omitted == ["1 self-crossing even-odd fill: filled by the non-zero rule"]


def test_examining_many_paths_ends(monkeypatch):
    pytest.importorskip("pathops")
    monkeypatch.setattr(skia, "MAX_EFFORT", 2**15)
    drawing = read_svg(square_file(STAR * 5))
    assert drawing.omitted == ["4 self-crossing even-odd fills: filled by the non-zero rule"]
