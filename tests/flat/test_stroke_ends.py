"""Test the ends of thin strokes: they are square or round, without spikes, and wedges stay sharp."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray

from warpvec.flat.chains.traced import said_loops
from warpvec.flat.curves.contours import contours_of
from warpvec.svg.measure import draw

SIDE = 64


def _coverage(element: str) -> NDArray[np.float64]:
    text = f'<svg xmlns="http://www.w3.org/2000/svg" width="{SIDE}" height="{SIDE}">{element}</svg>'
    return 1.0 - draw(text, SIDE, SIDE)[..., 0] / 255.0


def _fitted(element: str) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    (outline,) = contours_of(_coverage(element))
    return said_loops([outline])[0]


@pytest.mark.parametrize("width", [2, 3, 4])
@pytest.mark.parametrize("degrees", [4, 35, 80])
def test_stroke_is_a_rectangle(width: int, degrees: float) -> None:
    along = np.array([math.cos(math.radians(degrees)), math.sin(math.radians(degrees))])
    start, end = np.array([16.3, 14.6]), np.array([16.3, 14.6]) + 32 * along
    x, y = end
    segments, is_line = _fitted(f'<path d="M16.3,14.6L{x},{y}" stroke="#000" stroke-width="{width}"/>')
    across = 0.5 * width * np.array([-along[1], along[0]])
    corners = np.array([start + across, start - across, end + across, end - across])
    assert is_line.sum() >= 3
    assert len(segments) <= 5
    distance = np.linalg.norm(corners[:, None] - segments[None, :, 0], axis=2).min(1)
    assert distance.max() < 0.7


@pytest.mark.parametrize("width", [3, 4])
def test_round_end_has_no_spike(width: int) -> None:
    segments, _ = _fitted(f'<path d="M16,20L47,31" stroke="#000" stroke-width="{width}" stroke-linecap="round"/>')
    anchors = segments[:, 0]
    along = np.array([31.0, 11.0]) / math.hypot(31, 11)
    places = (anchors - [16, 20]) @ along
    assert places.min() > -width / 2 - 0.5
    assert places.max() < math.hypot(31, 11) + width / 2 + 0.5


def test_wedge_keeps_its_tip() -> None:
    segments, _ = _fitted('<path d="M12,20L52,26L12,32Z"/>')
    assert np.linalg.norm(segments[:, 0] - [52, 26], axis=1).min() < 1.0
