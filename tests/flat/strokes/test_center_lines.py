"""Centre lines of strokes that meet, short ones and slanted ones, and of handles of no length."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from shapely import LineString, Point, unary_union
from shapely.geometry.polygon import orient

from warpvec.flat.constants.lines import LINES
from warpvec.flat.price import ARC, LINE
from warpvec.flat.simplification.outline_samples import cubic_points
from warpvec.flat.strokes.center_lines import _miter_tips, center_lines
from warpvec.flat.strokes.inner_disks import Boundary, boundary_of, inner_disks, stroke_width
from warpvec.flat.strokes.line_fitting import Line, Rows, cost_of, curves_of, fit_line


def test_a_corner_between_handles_of_no_length_has_no_tip() -> None:
    anchors = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0]])
    control = np.stack([anchors, anchors, np.roll(anchors, -1, 0)], 1)
    assert _miter_tips(Rows(control, np.zeros(3, bool), is_open=True), 2.0) == []


def boundary_of_strokes(*lines: Sequence[tuple[float, float]]) -> Boundary:
    """Return the outline of round strokes of 20 pixels."""
    shape = unary_union([LineString(each).buffer(10.0, quad_segs=64) for each in lines])
    assert not shape.interiors
    start = np.array(shape.exterior.coords)[:-1]
    way = np.roll(start, -1, 0) - start
    area = shape.area if shape.exterior.is_ccw else -shape.area
    return boundary_of(start[:, None] + way[:, None] * np.linspace(0.0, 1.0, 4)[:, None], area)


def center_lines_of(boundary: Boundary) -> list[Line]:
    disks = inner_disks(boundary)
    width, has_width = stroke_width(boundary, disks)
    found = center_lines(boundary, disks, has_width, width)
    assert found is not None
    return found.lines


def lines_of(*lines: Sequence[tuple[float, float]]) -> list[np.ndarray]:
    return [line.points for line in center_lines_of(boundary_of_strokes(*lines))]


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


def turn_at(line: np.ndarray, place: tuple[float, float]) -> float:
    """Return how far a line comes to a place, in pixels, and fail if it ends there."""
    away = np.linalg.norm(line - place, axis=1)
    assert min(away[0], away[-1]) > 10.0
    return float(away.min())


@pytest.mark.parametrize("half", [20.0, 30.0])
def test_two_lines_meet_in_a_corner_as_narrow_as_a_drop(half: float) -> None:
    """The skeleton of such a corner has a stem, whose end no disk of the width reaches."""
    lines = lines_of(((100 - half, 140), (100, 40)), ((100, 40), (100 + half, 140)))
    assert len(lines) == 1 and turn_at(lines[0], (100, 40)) < 1.5


def test_a_line_that_ends_beside_a_corner_does_not_take_part_in_it() -> None:
    """A page with a folded corner: its edge goes on into the fold, and the flap ends on the edge a little above."""
    lines = lines_of(((150, 20), (150, 100)), ((150, 100), (90, 160)), ((150, 88), (60, 88)))
    edge = next(line for line in lines if np.ptp(line[:, 1]) > 100)
    assert turn_at(edge, (150, 100)) < 1.5
    flap = next(line for line in lines if np.ptp(line[:, 1]) < 20)
    assert np.linalg.norm(flap[[0, -1]] - [150, 88], axis=1).min() < 2.0


def test_a_line_keeps_its_end_beyond_one_that_leaves_it() -> None:
    """As long as half a width, the end is no branch of the skeleton."""
    lines = lines_of(((100, 30), (100, 110)), ((100, 100), (180, 100)))
    assert np.linalg.norm(ends_of(lines) - [100, 110], axis=1).min() < 1.0


def test_a_circle_goes_on_below_a_bar_that_it_touches() -> None:
    bar = LineString([(135, 65), (135, 135)]).buffer(10.0, quad_segs=64)
    ring = Point(100, 100).buffer(45.0, quad_segs=128).difference(Point(100, 100).buffer(25.0, quad_segs=128))
    shape = unary_union([bar, ring])
    outlines = [np.array(each.coords)[:-1] for each in (orient(shape).exterior, *orient(shape).interiors)]
    start = np.concatenate(outlines)
    way = np.concatenate([np.roll(own, -1, 0) - own for own in outlines])
    found = center_lines_of(boundary_of(start[:, None] + way[:, None] * np.linspace(0, 1, 4)[:, None], shape.area))

    (circle,) = [line for line in found if line.is_closed]
    assert np.abs(np.linalg.norm(circle.points - [100, 100], axis=1) - 35.0).max() < 2.0
    (straight,) = [line for line in found if not line.is_closed]
    assert np.linalg.norm(straight.points[[0, -1]] - [[135, 65], [135, 135]], axis=1).min() < 1.0


def arc(center: tuple[float, float], first: float, last: float, radius: float = 20.0) -> list[tuple[float, float]]:
    """Return places on a circle from one angle to another, in degrees from x to y."""
    angle = np.radians(np.linspace(first, last, 33))
    return list(zip(center[0] + radius * np.cos(angle), center[1] + radius * np.sin(angle), strict=True))


def test_arcs_that_turn_back_meet_in_their_tip() -> None:
    """A brace: the lines beside its tip seem to meet before it."""
    brace = [(80.0, 20.0), *arc((60, 80), 0, 90), *arc((60, 120), -90, 0)[1:], (80.0, 180.0)]
    rows = fit_line(Line(np.array(brace), False), 20.0, 0.2)
    assert np.linalg.norm(rows.control[:, 0] - [60, 100], axis=1).min() < 1.0
    assert cost_of(rows) == 2 * LINE + 2 * ARC


@pytest.mark.parametrize(("radius", "degrees"), [(3.0, 90.0), (3.0, 120.0), (8.0, 60.0), (8.0, 350.0)])
def test_small_arcs_are_no_lines(radius: float, degrees: float) -> None:
    angles = np.radians(np.linspace(0.0, degrees, 60))
    points = 20.0 + radius * np.stack([np.cos(angles), np.sin(angles)], 1)
    rows = fit_line(Line(points, False), 2.0, LINES.spread)
    near = cubic_points(curves_of(rows), np.linspace(0.0, 1.0, 50)).reshape(-1, 2)
    assert np.abs(np.linalg.norm(near - 20.0, axis=1) - radius).max() < 5.0 * LINES.spread


def test_a_line_ends_at_a_round_corner_of_another() -> None:
    """Its own end hides how round the corner is."""
    lines = lines_of([(20.0, 60.0), *arc((100, 80), -90, 0), (120.0, 160.0)], ((60, 120), (114, 66)))
    corner = next(line for line in lines if np.ptp(line[:, 1]) > 80)
    near = corner[(np.abs(corner - [107, 73]) < 14).all(1)]
    assert np.abs(np.linalg.norm(near - [100, 80], axis=1) - 20.0).max() < 2.0
