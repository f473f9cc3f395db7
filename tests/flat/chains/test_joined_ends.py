"""Ends of strokes that lie under others meet where their centre lines do, and ends that show stay."""

from __future__ import annotations

import numpy as np
import pytest
from chain_pictures import line, rounded_rectangle

from warpvec.flat.chains.chain import Chain
from warpvec.flat.chains.joined_ends import with_met_ends

WIDTH = 20.0
CIRCLE = rounded_rectangle(60, -60, 120, 120, (60, 60, 60, 60))[::2]
"""Around (120, 0), with a radius of 60."""


def met(*lines: tuple[tuple[float, float], tuple[float, float]], looks: np.ndarray | None = None) -> list[np.ndarray]:
    chains = {k: Chain.of(line(*each), is_closed=False) for k, each in enumerate(lines)}
    found = with_met_ends(chains, np.full(len(chains), WIDTH), np.zeros(len(chains), int) if looks is None else looks)
    return [np.stack([found[k].points[0], found[k].points[-1]]) for k in range(len(chains))]


def test_the_three_ends_of_an_arrow_meet_at_its_tip():
    shaft, above, below = met(((102, 100), (300, 100)), ((98.5, 100.5), (160, 40)), ((98.5, 99.5), (160, 160)))

    assert np.allclose(shaft[0], above[0]) and np.allclose(shaft[0], below[0])
    assert np.linalg.norm(shaft[0] - [99.0, 100.0]) < 2.0
    assert np.allclose(shaft[1], [300, 100]) and np.allclose(above[1], [160, 40])


@pytest.mark.parametrize("top", [49.2, 53.0, 59.0])
def test_an_end_that_lies_on_a_line_ends_there(top: float):
    bar, stem = met(((40, 50), (200, 50)), ((120, top), (120, 150)))

    assert np.allclose(stem[0], [120, 50], atol=0.1)
    assert np.allclose(bar, [[40, 50], [200, 50]])


@pytest.mark.parametrize("top", [39.0, 46.0, 62.0])
def test_an_end_that_shows_stays(top: float):
    """Beyond the line it shows sooner than short of it, where the bar covers half a width."""
    _, stem = met(((40, 50), (200, 50)), ((120, top), (120, 150)))
    assert np.allclose(stem[0], [120, top])


def test_an_end_below_a_stroked_circle_ends_on_its_line():
    stem, ring = Chain.of(line((120, 64), (120, 160)), is_closed=False), Chain.of(CIRCLE, is_closed=True)
    found = with_met_ends({0: stem}, np.full(2, WIDTH), np.zeros(2, int), {1: ring})
    assert np.allclose(found[0].points[0], [120, 60], atol=0.1)


def test_an_end_on_a_stroke_of_another_colour_stays():
    _, stem = met(((40, 50), (200, 50)), ((120, 53), (120, 150)), looks=np.array([0, 1]))
    assert np.allclose(stem[0], [120, 53])


def test_lines_of_one_direction_meet_halfway():
    left, right = met(((40, 50), (120, 50)), ((123, 50), (200, 50)))
    assert np.allclose(left[1], right[0]) and abs(left[1, 0] - 121.5) < 0.1


@pytest.mark.parametrize(("y", "end"), [(58.0, [200, 58]), (51.0, [200, 50])], ids=["beside it", "at it"])
def test_an_end_goes_to_a_corner_only_if_its_line_does(y: float, end: list[float]):
    chains = {
        0: Chain.of(np.concatenate([line((200, 150), (200, 50)), line((200, 50), (260, 20))]), is_closed=False),
        1: Chain.of(line((60, y), (199, y)), is_closed=False),
    }
    found = with_met_ends(chains, np.full(2, WIDTH), np.zeros(2, int))
    assert np.allclose(found[1].points[-1], end, atol=0.2)
