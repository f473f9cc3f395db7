"""Reducing images."""

from __future__ import annotations

import numpy as np
import pytest
from image_files import RNG, assert_in_range, assert_pixels

from warpvec.image.picture import reduce_image


@pytest.mark.parametrize(
    ("size", "longest_side", "want"),
    [
        ((40, 30), 20, (20, 15)),
        ((30, 40), 20, (15, 20)),
        ((1, 5000), 1024, (1, 1024)),
        ((5000, 2), 10, (10, 1)),
        ((9, 7), 1, (1, 1)),
    ],
)
def test_reduce_image_size_and_constant(size, longest_side, want):
    reduced = reduce_image(np.full((*size, 3), (0.0, 0.3, 1.0), np.float32), longest_side)
    assert_pixels(reduced, np.full((*want, 3), (0.0, 0.3, 1.0)), atol=1e-6)
    assert_in_range(reduced)


def test_reduce_image_never_enlarges():
    pixels = RNG.random((6, 9, 3)).astype(np.float32)
    assert_pixels(reduce_image(pixels, 9), pixels)
    assert_pixels(reduce_image(pixels, 10**9), pixels)


def test_reduce_image_removes_frequencies_above_those_of_the_smaller_grid():
    board = np.indices((128, 128)).sum(0) % 2
    pixels = np.repeat(board[..., None].astype(np.float32), 3, -1)
    assert_pixels(reduce_image(pixels, 32)[2:-2, 2:-2].copy(), np.full((28, 28, 3), 0.5), atol=0.01)
    step = np.zeros((8, 128, 3), np.float32)
    step[:, 64:] = 1
    reduced = reduce_image(step, 32)
    assert (reduced.min(), reduced.max()) == (0, 1)
    np.testing.assert_allclose(reduced.mean(), 0.5, atol=1e-6)
