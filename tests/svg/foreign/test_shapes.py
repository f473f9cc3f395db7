"""Shapes of other programs with coordinates out of reach."""

from __future__ import annotations

import pytest
from svg_files import SQUARE, square_file

from warpvec.svg.read import read_svg


@pytest.mark.parametrize(
    "data", ["M5 5H60V60zA1e200 1e200 0 0 1 9 9", "M0 0A1e-300 1 0 0 1 1e300 9L9 9", "M1e999 0L1 2 3 9"]
)
def test_arcs_and_numbers_out_of_reach_are_named(data):
    drawing = read_svg(square_file(f'<path d="{data}"/>' + SQUARE))
    assert drawing.scene.segments.isfinite().all()
    assert drawing.omitted
