"""Circles, straight lines and rounded corners of known size, and the error near an outline."""

from __future__ import annotations

import numpy as np
import pytest

from warpvec.flat.simplification.circles import Ellipse, ellipse_of
from warpvec.flat.simplification.local_error import boxes_of, errors_in_boxes, errors_near
from warpvec.flat.simplification.outline_samples import cubic_points, cubic_slopes
from warpvec.flat.simplification.rounded_corners import rounded_corners
from warpvec.flat.simplification.span_fitting import Ends, Span, fit_cubics, fit_lines
from warpvec.flat.simplification.straight_lines import Lines, regular_anchors


def _ellipse(a: float, b: float, degrees: float, turn: float = 360.0) -> np.ndarray:
    t, tilt = np.radians(np.linspace(0, turn, 60, endpoint=turn < 360)), np.radians(degrees)
    x, y = a * np.cos(t), b * np.sin(t)
    return np.stack([30 + x * np.cos(tilt) - y * np.sin(tilt), 20 + x * np.sin(tilt) + y * np.cos(tilt)], 1)


@pytest.mark.parametrize(
    ("a", "b", "degrees", "expected"),
    [(7.0, 7.05, 0.0, (7.025, 7.025, 0.0)), (12.0, 5.0, 0.3, (12.0, 5.0, 0.0)), (12.0, 5.0, 30.0, (12.0, 5.0, 30.0))],
    ids=["circle", "level", "tilted"],
)
def test_an_outline_is_the_simplest_ellipse_that_it_can_be(
    a: float, b: float, degrees: float, expected: tuple[float, float, float]
) -> None:
    found = ellipse_of(_ellipse(a, b, degrees), np.ones(60))
    assert found is not None
    assert (found.x, found.y) == pytest.approx((30, 20), abs=0.01)
    axes = sorted((found.a, found.b), reverse=True)
    assert axes == pytest.approx(list(expected[:2]), abs=0.05)
    assert (found.a == found.b) == (expected[0] == expected[1])
    tilt = np.degrees(found.angle) % 90
    assert min(abs(tilt - expected[2] % 90), 90 - abs(tilt - expected[2] % 90)) < 0.5


def test_squares_dots_and_short_arcs_are_no_ellipses() -> None:
    side = np.linspace(-1, 1, 15)
    square = np.concatenate([np.stack([side, side * 0 + k], 1) for k in (-1, 1)])
    square = 20 + 9 * np.concatenate([square, square[:, ::-1]])
    assert ellipse_of(square, np.ones(60)) is None
    assert ellipse_of(_ellipse(1.0, 1.0, 0.0), np.ones(60)) is None
    assert ellipse_of(_ellipse(9.0, 9.0, 0.0, turn=200.0), np.ones(60)) is None
    assert ellipse_of(_ellipse(9.0, 9.0, 0.0, turn=300.0), np.ones(60)) is not None


def test_four_arcs_are_a_circle() -> None:
    segments = Ellipse(30, 20, 8, 8, 0.0).segments(is_clockwise=True)
    control = np.concatenate([segments, np.roll(segments, -1, 0)[:, :1]], 1)
    points = cubic_points(control, np.linspace(0, 1, 9)).reshape(-1, 2)
    assert np.abs(np.hypot(*(points - [30, 20]).T) - 8).max() < 0.003
    assert Ellipse(30, 20, 8, 8, 0.0).distances(np.array([[40.0, 20.0], [30.0, 27.0]])) == pytest.approx(
        [2, 1], abs=0.3
    )


def _lines_of(anchor: np.ndarray, path: list[int] | None = None) -> Lines:
    following = np.roll(anchor, -1, 0)
    count = len(anchor)
    return Lines(np.arange(count), np.array(path or [0] * count), anchor, following, np.full(count, 10.0))


def test_a_square_that_leans_a_little_stands_straight() -> None:
    turn = np.radians(1.0)
    square = np.array([[0, 0], [20, 0], [20, 20], [0, 20]], float) - 10
    leaning = 30 + square @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    found = regular_anchors(_lines_of(leaning), leaning, np.array([3, 0, 1, 2]))
    np.testing.assert_allclose(found, 30 + square, atol=0.02)
    assert found[0, 1] == found[1, 1] and found[1, 0] == found[2, 0]


def test_a_square_that_leans_on_purpose_keeps_its_angle_and_gets_right_angles() -> None:
    turn = np.radians(20.0)
    square = np.array([[0, 0], [20, 0], [20.2, 20], [0, 20]], float) - 10
    leaning = 30 + square @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    found = regular_anchors(_lines_of(leaning), leaning, np.array([3, 0, 1, 2]))
    sides = np.roll(found, -1, 0) - found
    np.testing.assert_allclose((sides * np.roll(sides, -1, 0)).sum(1), 0, atol=1e-6)
    assert np.degrees(np.arctan2(*sides[0, ::-1])) == pytest.approx(20, abs=0.3)


def _rounded_square(radii: tuple[float, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Return the segments [8, 4, 2] of a square of 40 whose corners have these radii, and its lines [8]."""
    corners = np.array([[0, 0], [40, 0], [40, 40], [0, 40]], float)
    along = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]], float)
    segments, share = [], np.linspace(0, 1, 4)[:, None]
    for k in range(4):
        start, end = corners[k] + radii[k] * along[k], corners[(k + 1) % 4] - radii[(k + 1) % 4] * along[k]
        segments.append(start + share * (end - start))
        reach = radii[(k + 1) % 4]
        leave, arrive = end + 0.5 * reach * along[k], corners[(k + 1) % 4] + 0.5 * reach * along[(k + 1) % 4]
        segments.append(np.stack([end, leave, arrive, corners[(k + 1) % 4] + reach * along[(k + 1) % 4]]))
    return np.array(segments), np.tile([True, False], 4)


@pytest.mark.parametrize(("radii", "expected"), [((6, 6.4, 6, 6.4), [6.2] * 4), ((4, 8, 4, 8), [4, 8, 4, 8])])
def test_rounded_corners_become_arcs_of_one_radius_if_theirs_are_alike(
    radii: tuple[float, ...], expected: list[float]
) -> None:
    control, is_line = _rounded_square(radii)
    row, loop = np.arange(8), np.zeros(8, int)
    anchor, leaving, _, arcs = rounded_corners(control, is_line, (row + 1) % 8, (row - 1) % 8, loop)
    assert arcs.tolist() == (~is_line).tolist()
    lengths = np.linalg.norm(leaving[arcs], axis=1)
    reach = np.linalg.norm(anchor[[1, 3, 5, 7]] - np.array([[40, 0], [40, 40], [0, 40], [0, 0]]), axis=1)
    np.testing.assert_allclose(reach, np.roll(expected, -1))
    np.testing.assert_allclose(lengths / reach, 4 / 3 * np.tan(np.pi / 8), atol=1e-9)


def test_errors_count_for_the_outlines_that_pass_them() -> None:
    error = np.zeros((20, 20), np.float32)
    error[5, 5], error[5, 9], error[15, 15] = 1.0, 2.0, 4.0
    share = np.linspace(0, 1, 4)[:, None]
    lines = np.stack([np.array([2.5, 6.5]) + share * [6, 0], np.array([14.5, 2.5]) + share * [0, 13]])
    assert errors_near(lines, error).tolist() == [3.0, 4.0]
    low, high = boxes_of(lines, np.array([0, 0]), 1)
    assert (low.tolist(), high.tolist()) == ([[2.5, 2.5]], [[14.5, 15.5]])
    assert errors_in_boxes(error, low, high).tolist() == [7.0]
    assert errors_in_boxes(error, low, np.array([[7.5, 7.5]])).tolist() == [1.0]


def test_the_parts_of_a_cubic_become_that_cubic_again() -> None:
    whole = np.array([[2.0, 2.0], [6.0, 12.0], [18.0, 14.0], [24.0, 3.0]])
    t = (np.arange(48) + 0.5) / 48
    points = cubic_points(whole[None], t)
    lengths = np.linalg.norm(cubic_slopes(whole[None], t), axis=-1) / 48
    unit = [(b - a) / np.linalg.norm(b - a) for a, b in (whole[:2], whole[2:])]
    ends = Ends(whole[None, 0], whole[None, 3], unit[0][None], unit[1][None])
    fits = fit_cubics(Span(points, lengths, np.ones_like(lengths), np.zeros(1, int)), ends)
    np.testing.assert_allclose(fits.handles[0], whole[1:3], atol=0.2)
    assert np.linalg.norm(fits.places - points, axis=-1).max() < 0.05


def test_points_beside_a_line_and_beyond_its_end_go_to_the_nearest_place_on_it() -> None:
    start, end, along = np.array([[0.0, 0.0]]), np.array([[8.0, 0.0]]), np.array([[1.0, 0.0]])
    straight = fit_lines(np.array([[[5.0, 3.0], [9.0, 1.0]]]), Ends(start, end, along, along))
    np.testing.assert_allclose(straight.places, [[[5.0, 0.0], [8.0, 0.0]]], atol=1e-9)
