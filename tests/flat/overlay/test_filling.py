"""Tests of warpvec.flat.overlay.filling: what lies below marks goes on from both sides."""

from __future__ import annotations

import numpy as np
from flat_regions import coverage

from warpvec.flat.overlay.filling import filled, ink_share

GREEN, WHITE = np.array((0.7, 0.8, 0.6), np.float32), np.ones(3, np.float32)
GRAY, BLACK = np.full(3, 0.7, np.float32), np.zeros(3, np.float32)


def road() -> np.ndarray:
    """Return a white road with thin gray sides on a green ground [48, 48, 3]; it leans by a fifth."""
    wide, narrow = (coverage(lambda x, y, half=half: np.abs(x - 20.3 - 0.2 * y) < half, 48, 48) for half in (3.5, 2.7))
    picture = GREEN + wide[..., None] * (GRAY - GREEN)
    return (picture + narrow[..., None] * (WHITE - picture)).astype(np.float32)


def test_a_road_and_its_thin_sides_go_on_below_a_bar() -> None:
    picture = road()
    hidden = np.zeros((48, 48), bool)
    hidden[20:24, 12:36] = True
    marked = np.where(hidden[..., None], BLACK, picture)
    assert np.abs(filled(marked, hidden, BLACK) - picture).max() < 0.1


def test_a_mix_of_ink_and_ground_tells_which_ground_it_is() -> None:
    # White is nearer on both sides than green.
    picture = np.broadcast_to(WHITE, (48, 48, 3)).copy()
    picture[:, 20:32] = GREEN
    hidden = np.zeros((48, 48), bool)
    hidden[16:30, 20:32] = True
    marked = np.where(hidden[..., None], 0.5 * picture + 0.5 * BLACK, picture)
    ground = filled(marked, hidden, BLACK)
    np.testing.assert_allclose(ground, picture, atol=0.02)
    np.testing.assert_allclose(ink_share(marked, ground, BLACK)[hidden], 0.5, atol=0.02)
