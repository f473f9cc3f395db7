"""Sizes that files state, and sizes that are refused."""

from __future__ import annotations

import pytest
from svg_files import refusal, svg_file

from warpvec.svg.measure import draw


@pytest.mark.parametrize(
    ("attributes", "shape"),
    [
        ('viewBox="0 0 30 20"', (20, 30)), ('width="60" viewBox="0 0 30 20"', (40, 60)),
        ('width="10mm" height="1in"', (96, 38)), ('width="10px" height="6pt"', (8, 10)),
        ('width="1e1" height="1em"', (16, 10)), ('width="200%" height="50%" viewBox="0,0,30,20"', (10, 60)),
    ],
)  # fmt: skip
def test_draw_at_the_size_that_the_file_states(attributes, shape):
    assert draw(svg_file(attributes=attributes)).shape[:2] == shape


@pytest.mark.parametrize(
    "attributes",
    [
        'width="1000000" height="1000000"',
        'width="1e9mm" height="1"',
        'width="8" viewBox="0 0 1 1e9"',
        'viewBox="0 0 1e6 1e6"',
        'width="1e6%" height="1e6%" viewBox="0 0 10 10"',
        'width="1e999" height="1"',
    ],
)
def test_a_huge_canvas_is_refused_before_it_is_allocated(attributes):
    svg = svg_file(attributes=attributes)
    assert "pixels" in refusal(draw, svg)
    assert "pixels" in refusal(draw, svg, 10**6, 10**6)


@pytest.mark.parametrize("attributes", ["", 'width="8"', 'width="100%" height="50%"', 'width="a" height="b"'])
def test_a_canvas_of_no_stated_size_is_refused(attributes):
    assert "state its size" in refusal(draw, svg_file('<rect width="1e9" height="1e9"/>', attributes))


@pytest.mark.parametrize("size", [(0, 4), (8, -4)])
def test_a_size_of_nothing_is_refused(size):
    assert "pixels" in refusal(draw, svg_file(), *size)
