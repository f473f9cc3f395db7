"""Tests of warpvec.flat.chains.traced on outlines whose true curves are known."""

from __future__ import annotations

import numpy as np
import pytest
from flat_regions import box, coverage, disc
from numpy.typing import NDArray

from warpvec.flat.chains.traced import said_loops
from warpvec.flat.curves.contours import contours_of
from warpvec.flat.curves.outline_nodes import _distance_on_cycle

Floats = NDArray[np.float64]


def half_plane(x: float, y: float, degrees: float):  # type: ignore[no-untyped-def]
    """The points left of a line through (x, y) in a direction, as seen along it with y down."""
    across = np.array([np.sin(np.radians(degrees)), -np.cos(np.radians(degrees))])
    return lambda px, py: (px - x) * across[0] + (py - y) * across[1] <= 0


def polygon(corners: Floats):  # type: ignore[no-untyped-def]
    """A convex polygon whose ``corners`` [n, 2] run clockwise on the screen."""

    def inside(px: Floats, py: Floats) -> NDArray[np.bool_]:
        found = np.ones(px.shape, bool)
        for a, b in zip(corners, np.roll(corners, -1, 0), strict=True):
            found &= (b[0] - a[0]) * (py - a[1]) - (b[1] - a[1]) * (px - a[0]) >= 0
        return found

    return inside


def fitted(shape, size: int = 96):  # type: ignore[no-untyped-def]
    loops = contours_of(coverage(shape, size, size))
    assert len(loops) == 1
    return said_loops(loops[:1])[0]


def sampled(segments: Floats, count: int = 20) -> Floats:
    u = np.linspace(0.0, 1.0, count)[:, None, None]
    a, b, c, d = segments[:, 0], segments[:, 1], segments[:, 2], np.roll(segments[:, 0], -1, 0)
    return ((1 - u) ** 3 * a + 3 * u * (1 - u) ** 2 * b + 3 * u * u * (1 - u) * c + u**3 * d).reshape(-1, 2)


def turns(segments: Floats) -> Floats:
    """Change of direction at each anchor, in degrees."""
    leaving = segments[:, 1] - segments[:, 0]
    arriving = segments[:, 0] - np.roll(segments[:, 2], 1, 0)
    cosine = (leaving * arriving).sum(1) / np.linalg.norm(leaving, axis=1) / np.linalg.norm(arriving, axis=1)
    return np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))


def farthest(points: Floats, others: Floats) -> float:
    """Largest distance from one of ``points`` to the nearest of ``others``."""
    return float(np.linalg.norm(points[:, None] - others, axis=-1).min(1).max())


@pytest.mark.parametrize("degrees", [0.0, 7.0, 30.0, 45.0])
def test_polygon_gets_its_corners_and_lines(degrees: float) -> None:
    turn = np.radians(degrees)
    corners = np.array([[-30.0, -14.0], [26.0, -20.0], [31.0, 11.0], [-12.0, 24.0]])
    corners = corners @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]]) + (48.3, 47.6)
    segments, is_line = fitted(polygon(corners))
    assert is_line.tolist() == [True] * 4
    assert farthest(corners, segments[:, 0]) < 0.15


@pytest.mark.parametrize("radius", [3.0, 12.0, 40.0])
def test_circle_takes_few_smooth_curves(radius: float) -> None:
    segments, is_line = fitted(disc(48.2, 47.7, radius))
    assert len(segments) <= 6  # an arc has one for each quarter that it begins
    assert not is_line.any()
    assert turns(segments).max() < 1e-2
    off = np.hypot(*(sampled(segments) - (48.2, 47.7)).T) - radius
    assert np.abs(off).max() < 0.15


def test_bar_with_round_ends_keeps_straight_sides_that_go_on_smoothly() -> None:
    def bar(px: Floats, py: Floats) -> NDArray[np.bool_]:
        return np.hypot(px - np.clip(px, 25.3, 70.6), py - 40.4) <= 9.0

    segments, is_line = fitted(bar)
    assert is_line.sum() == 2
    assert len(segments) <= 6
    assert turns(segments).max() < 1e-2


def test_tips_between_curves_are_found() -> None:
    def lens(px: Floats, py: Floats) -> NDArray[np.bool_]:
        return disc(48.0, 80.0, 50.0)(px, py) & disc(48.0, 16.0, 50.0)(px, py)

    reach = np.sqrt(50.0**2 - 32.0**2)
    segments, _ = fitted(lens)
    assert farthest(np.array([[48.0 - reach, 48.0], [48.0 + reach, 48.0]]), segments[:, 0]) < 0.3
    assert (turns(segments) > 20.0).sum() == 2
    assert len(segments) <= 4


def test_thin_tip_does_not_shrink() -> None:
    corners = np.array([[10.0, 40.0], [85.0, 46.0], [10.0, 52.0]])
    segments, is_line = fitted(polygon(corners))
    assert is_line.all()
    assert farthest(corners, segments[:, 0]) < 1.0


def test_smallest_loops_are_fitted() -> None:
    loops = [np.array([[3.0, 3.0], [3.6, 3.4], [3.2, 4.0]]), np.array([[1.0, 1.0], [9.0, 1.0], [9.0, 2.0], [1.0, 2.0]])]
    for (segments, is_line), loop in zip(said_loops(loops), loops, strict=True):
        assert len(segments) == len(is_line) >= 1
        assert np.isfinite(segments).all()
        assert farthest(sampled(segments), sampled(np.stack([loop] * 3, 1))) < 3.0
    assert said_loops([]) == []


def test_larger_tolerance_needs_fewer_pieces() -> None:
    def wavy(px: Floats, py: Floats) -> NDArray[np.bool_]:
        angle = np.arctan2(py - 48.0, px - 48.0)
        return np.hypot(px - 48.0, py - 48.0) <= 34.0 + 1.5 * np.sin(9.0 * angle)

    loop = contours_of(coverage(wavy, 96, 96))[0]
    exact, coarse = said_loops([loop], 0.2)[0][0], said_loops([loop], 8.0)[0][0]
    assert len(coarse) < len(exact) / 2
    assert farthest(loop, sampled(exact, 200)) < 0.4


def test_straight_edges_are_exact_at_any_slope() -> None:
    for degrees in (0.0, 20.0, 45.0, 70.0, 100.0):
        loop = contours_of(coverage(half_plane(32.3, 31.8, degrees), 64, 64))[0]
        inner = loop[((loop > 3.0) & (loop < 61.0)).all(1)]
        across = np.array([np.sin(np.radians(degrees)), -np.cos(np.radians(degrees))])
        assert len(inner) > 50
        assert np.abs((inner - (32.3, 31.8)) @ across).max() < 0.03


def test_holes_run_the_other_way() -> None:
    field = coverage(box(4.2, 4.2, 28.5, 28.5), 32, 32) - coverage(disc(16.0, 16.0, 6.0), 32, 32)
    areas = [
        (loop[:, 0] * np.roll(loop[:, 1], -1) - loop[:, 1] * np.roll(loop[:, 0], -1)).sum() / 2
        for loop in contours_of(field)
    ]
    assert sorted(np.abs(areas)) == pytest.approx([np.pi * 36, 24.3**2], rel=0.01)
    assert areas[0] * areas[1] < 0


@pytest.mark.parametrize("corners", [[7], [0, 9], [9, 2, 2], [4, 0, 8, 1]])
def test_the_nearest_corner_may_lie_beyond_the_start_of_a_loop(corners: list[int]) -> None:
    steps = [[min((place - corner) % 10, (corner - place) % 10) for corner in corners] for place in range(10)]
    found = _distance_on_cycle(np.arange(10), np.array(corners), 10)
    assert found.tolist() == [min(row) for row in steps]
