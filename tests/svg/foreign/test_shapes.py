"""Shapes of other programs with coordinates out of reach."""

from __future__ import annotations

import numpy as np
import pytest
import svgelements
from svg_files import SQUARE, square_file

from warpvec.svg.foreign import shapes
from warpvec.svg.foreign.forms import shape_form
from warpvec.svg.read import read_svg


@pytest.mark.parametrize(
    "data", ["M5 5H60V60zA1e200 1e200 0 0 1 9 9", "M0 0A1e-300 1 0 0 1 1e300 9L9 9", "M1e999 0L1 2 3 9"]
)
def test_arcs_and_numbers_out_of_reach_are_named(data):
    drawing = read_svg(square_file(f'<path d="{data}"/>' + SQUARE))
    assert drawing.scene.segments.isfinite().all()
    assert drawing.omitted


def test_a_path_is_not_searched_for_its_start_at_every_end_of_a_subpath(monkeypatch):
    text = square_file('<path d="M3 4h9v9zl5 5h5zzm9 9h5v5Zh1M30 30h9v9z"/>')
    with monkeypatch.context() as patch:
        patch.setattr(shapes, "_path_class", lambda: svgelements.Path)
        expected = read_svg(text).scene.segments
    # Both search back to the last move, so that thousands of subpaths would take minutes.
    monkeypatch.setattr(svgelements.Path, "z_point", property(lambda path: 1 / 0))
    monkeypatch.setattr(svgelements.Path, "_validate_close", lambda path, index: 1 / 0)
    assert read_svg(text).scene.segments.equal(expected)


def test_closes_that_only_draw_the_same_point_again_make_no_subpaths():
    for data in ("M3 4h9v9", "M3 4"):
        few, complete = shapes.read_subpaths(data + "zz")
        for more in ("zzz", "zZ\nz z" * 1000):
            found = shapes.read_subpaths(data + more)
            assert found[1] == complete
            assert [subpath.points.tolist() for subpath in found[0]] == [subpath.points.tolist() for subpath in few]


@pytest.mark.filterwarnings("error")
def test_a_circle_out_of_reach_is_no_form() -> None:
    huge = np.array([[1e200, 0.0, 0.0], [0.0, 1e200, 0.0]])
    assert shape_form("circle", {"cx": "1", "cy": "1", "r": "1e200"}, (9.0, 9.0), huge) is None
