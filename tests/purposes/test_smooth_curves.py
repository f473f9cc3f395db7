"""Closed curves through dense points: near them, and with lines where these are shorter to say."""

from __future__ import annotations

import numpy as np
import pytest

from warpvec.arrays import Floats
from warpvec.purposes.smooth_curves import smooth_curve

TOLERANCE = 0.3


def ring(half_line: float, radius: float) -> Floats:
    """Points about a unit apart along a square with round corners, from the middle of its upper side on."""
    angle = np.linspace(-np.pi / 2, 0.0, max(2, round(1.6 * radius)), endpoint=False)
    corner = half_line + radius * np.stack([np.cos(angle), np.sin(angle)], 1) - [0, 2 * half_line]
    side = np.stack([half_line + radius + np.zeros(round(2 * half_line)), np.arange(-half_line, half_line)], 1)
    quarter = np.concatenate([corner, side]) if half_line else corner
    turns = [np.array([[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]]) for a in np.arange(4) * np.pi / 2]
    return np.concatenate([quarter @ turn.T for turn in turns]) + 100.0


@pytest.mark.parametrize(("half_line", "radius", "lines", "rows"), [(40.0, 20.0, 4, 8), (0.0, 40.0, 0, 4)])
def test_a_ring_has_few_pieces_and_stays_near_its_points(
    half_line: float, radius: float, lines: int, rows: int
) -> None:
    points = ring(half_line, radius)
    found = smooth_curve(points, TOLERANCE)
    assert found.is_line.sum() == lines and len(found.is_line) <= rows
    cubics = found.points.reshape(-1, 3, 2)
    ends = np.roll(cubics[:, :1], -1, axis=0)
    t = np.linspace(0.0, 1.0, 65)[:, None]
    weights = np.hstack([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3])
    drawn = np.concatenate([weights @ rows for rows in np.concatenate([cubics, ends], 1)])
    distance = np.hypot(*(points[:, None] - drawn).transpose(2, 0, 1)).min(1)
    assert distance.max() < TOLERANCE + 1.0  # the points drawn are up to a unit apart
