"""Outlines of whole pixels are exact: filled, they give the pixels again."""

from __future__ import annotations

import numpy as np
from sweep import sweep

from warpvec.arrays import Integers, Mask
from warpvec.flat.pixels.outlines import rectilinear_loops


def filled(loops: list[Integers], shape: tuple[int, int]) -> Mask:
    """Return the pixels [h, w] inside of ``loops`` by the winding of their upright sides."""
    winding = np.zeros((shape[0], shape[1] + 1), np.int64)
    for loop in loops:
        for (x, y), (other_x, other_y) in zip(loop, np.roll(loop, -1, axis=0), strict=True):
            assert (x == other_x) != (y == other_y)
            if x == other_x:
                winding[min(y, other_y) : max(y, other_y), x] += np.sign(y - other_y)
    inside = winding.cumsum(1)[:, :-1]
    assert set(np.unique(inside)) <= {0, 1}
    return inside != 0


@sweep("seed", list(range(12)))
def test_random_masks_come_back(seed: int) -> None:
    random = np.random.default_rng(seed)
    height, width = random.integers(1, 14, 2)
    mask = random.random((height, width)) < random.uniform(0.1, 0.9)
    loops = rectilinear_loops(mask)
    np.testing.assert_array_equal(filled(loops, mask.shape), mask)


def test_outlines_have_corners_only_and_holes() -> None:
    ring = np.ones((4, 6), bool)
    ring[1:3, 2:4] = False
    assert sorted(len(loop) for loop in rectilinear_loops(ring)) == [4, 4]


def test_pixels_that_touch_at_a_corner_are_apart() -> None:
    assert len(rectilinear_loops(np.eye(3, dtype=bool))) == 3
    assert rectilinear_loops(np.zeros((3, 3), bool)) == []
