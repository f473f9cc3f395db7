"""Cubics, nodes and pieces of outlines whose shape is known."""

from __future__ import annotations

import numpy as np
import pytest

from warpvec.flat.constants.curves import CURVES
from warpvec.flat.curves.contours import contours_of
from warpvec.flat.curves.cubic_fitting import fit_cubics, fit_lengths
from warpvec.flat.curves.outline_nodes import find_nodes, roughness, sample_loops

CUBIC = np.array([[0.0, 0.0], [2.0, 6.0], [9.0, 7.0], [12.0, 1.0]])
SQUARE = np.array([[2.0, 2.0], [32.0, 2.0], [32.0, 32.0], [2.0, 32.0]])


def _on(cubic: np.ndarray, t: np.ndarray) -> np.ndarray:
    a, b, c, d = cubic
    u, t = (1 - t)[:, None], t[:, None]
    points: np.ndarray = u**3 * a + 3 * u * u * t * b + 3 * u * t * t * c + t**3 * d
    return points


def _circle(radius: float, noise: float = 0.0) -> np.ndarray:
    angle = np.linspace(0, 2 * np.pi, int(8 * radius), endpoint=False)
    r = radius + noise * np.random.default_rng(0).standard_normal(len(angle))
    return 50 + r[:, None] * np.stack([np.cos(angle), np.sin(angle)], 1)


def test_a_cubic_is_found_from_its_points() -> None:
    t = np.linspace(0.05, 0.95, 24)
    points, place = _on(CUBIC, t), np.linspace(0.07, 0.93, 24)
    found = fit_cubics(CUBIC[None, 0], CUBIC[None, 3], points[None], place[None], (40, 1.0))
    np.testing.assert_allclose(found.handles[0], CUBIC[1:3], atol=0.05)
    assert float(found.distance[0]) < 0.01
    assert float(found.square[0]) <= float(found.distance[0]) ** 2


def test_where_points_are_too_few_handles_are_at_thirds() -> None:
    start, end, middle = np.array([[0.0, 0.0]]), np.array([[9.0, 3.0]]), np.array([[[4.5, 1.5]]])
    found = fit_cubics(start, end, middle, np.array([[0.5]]), (1, 1.0))
    np.testing.assert_allclose(found.handles[0], [[3.0, 1.0], [6.0, 2.0]], atol=1e-3)


def test_handles_keep_their_directions() -> None:
    t = np.linspace(0.05, 0.95, 24)
    away = np.stack([CUBIC[1] - CUBIC[0], CUBIC[2] - CUBIC[3]])
    unit = away / np.linalg.norm(away, axis=1)[:, None]
    found = fit_lengths(CUBIC[None, 0], CUBIC[None, 3], unit[None], _on(CUBIC, t)[None], t[None])
    np.testing.assert_allclose(found.handles[0], CUBIC[1:3], atol=0.02)


def test_samples_are_even() -> None:
    samples = sample_loops([SQUARE, SQUARE / 4])
    assert samples.first.tolist() == [0, 240, 300]
    np.testing.assert_allclose(samples.step, CURVES.sample_step)
    assert samples.xy[60].tolist() == [32.0, 2.0]


def test_a_square_has_four_corners_and_a_circle_none() -> None:
    nodes = find_nodes(sample_loops([SQUARE, _circle(20.0)]))
    corners = nodes.point[nodes.is_corner]
    assert (np.flatnonzero(nodes.is_corner) < nodes.first[1]).all()
    near = np.linalg.norm(corners[:, None] - SQUARE, axis=2)
    assert len(corners) == 4 and near.min(0).max() < 0.05
    smooth = np.flatnonzero(~nodes.is_corner[: nodes.first[1]])
    beside = np.linalg.norm(nodes.point[smooth, None] - SQUARE, axis=2).min(1) < 5.0
    np.testing.assert_allclose(np.abs(nodes.direction[smooth[~beside]]).max(1), 1.0, atol=1e-6)


def test_roughness_grows_with_the_noise_of_an_outline() -> None:
    rough = roughness(sample_loops([_circle(60.0), _circle(60.0, 0.05), _circle(60.0, 0.1), _circle(4.0, 0.1)]))
    assert rough[0] < 0.001
    assert rough[2] == pytest.approx(2 * rough[1], rel=0.1)
    assert rough[3] == 0.0  # too short to tell noise from shape


@pytest.mark.parametrize("share", [0.25, 0.5, 0.8])
def test_an_upright_edge_lies_where_its_coverage_says(share: float) -> None:
    coverage = np.zeros((12, 12))
    coverage[3:9, 3:8], coverage[3:9, 8] = 1.0, share
    (loop,) = contours_of(coverage)
    right = loop[(loop[:, 1] > 5) & (loop[:, 1] < 7) & (loop[:, 0] > 6)]
    np.testing.assert_allclose(right[:, 0], 8 + share, atol=1e-9)
