"""Centre lines of strokes that meet, short ones and slanted ones, and of handles of no length."""

from __future__ import annotations

import numpy as np
import pytest
from shapely import LineString, unary_union

from warpvec.flat.strokes.center_lines import _miter_tips, center_lines
from warpvec.flat.strokes.inner_disks import Boundary, boundary_of, inner_disks, stroke_width
from warpvec.flat.strokes.line_fitting import Rows


def test_a_corner_between_handles_of_no_length_has_no_tip() -> None:
    anchors = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]])
    control = np.stack([anchors, anchors, np.roll(anchors, -1, 0)], 1)
    assert _miter_tips(Rows(control, np.zeros(3, bool), is_open=True), 2.0) == []


def boundary_of_strokes(*lines: tuple[tuple[float, float], tuple[float, float]]) -> Boundary:
    """Return the outline of round strokes of 20 pixels."""
    shape = unary_union([LineString(each).buffer(10.0, quad_segs=64) for each in lines])
    assert not shape.interiors
    start = np.array(shape.exterior.coords)[:-1]
    way = np.roll(start, -1, 0) - start
    area = shape.area if shape.exterior.is_ccw else -shape.area
    return boundary_of(start[:, None] + way[:, None] * np.linspace(0.0, 1.0, 4)[:, None], area)


def lines_of(*lines: tuple[tuple[float, float], tuple[float, float]]) -> list[np.ndarray]:
    boundary = boundary_of_strokes(*lines)
    disks = inner_disks(boundary)
    width, has_width = stroke_width(boundary, disks)
    found = center_lines(boundary, disks, has_width, width)
    assert found is not None
    return [line.points for line in found.lines]


def ends_of(lines: list[np.ndarray]) -> np.ndarray:
    return np.concatenate([line[[0, -1]] for line in lines])


@pytest.mark.parametrize("length", [12.0, 15.0, 40.0])
def test_a_stub_with_a_whole_cap_is_a_line(length: float) -> None:
    lines = lines_of(((30, 60), (170, 60)), ((100, 60), (100, 60 - length)))
    assert len(lines) == 2
    assert np.linalg.norm(ends_of(lines) - [100, 60 - length], axis=1).min() < 1.0


def test_a_sharp_corner_is_no_line() -> None:
    lines = lines_of(((60, 140), (100, 40)), ((100, 40), (140, 140)))
    assert sum(np.linalg.norm(np.diff(line, axis=0), axis=1).sum() > 12.0 for line in lines) == 1


def test_slanted_lines_keep_their_ends() -> None:
    """Thinning by Zhang and Suen eats lines of two cells from their ends."""
    lines = lines_of(((40, 100), (160, 100)), ((124, 64), (160, 100)), ((124, 136), (160, 100)))
    ends = ends_of(lines)
    for tip in ((124, 64), (124, 136), (40, 100)):
        assert np.linalg.norm(ends - tip, axis=1).min() < 1.5
