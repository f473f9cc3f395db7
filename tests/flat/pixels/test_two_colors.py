"""Pictures of two colours: whole pixels or smooth outlines, by what is shorter to say."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from warpvec.flat.pixels.two_colors import are_pixels_shorter


def of_two_colors(is_ink: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Return a picture [h, w, 3] of dark blue ink on pale yellow."""
    return np.where(is_ink[..., None], (0.1, 0.1, 0.4), (1.0, 1.0, 0.8)).astype(np.float32)


def test_a_large_disc_is_smooth_and_letters_of_few_pixels_are_not() -> None:
    y, x = np.indices((160, 160))
    assert not are_pixels_shorter(of_two_colors(np.hypot(x - 80, y - 80) < 61.3))
    glyphs = np.random.default_rng(0).random((12, 40)) < 0.5  # a bitmap font at one pixel a dot
    assert are_pixels_shorter(of_two_colors(np.pad(glyphs, 6)))


def test_a_picture_of_three_colours_is_not_asked() -> None:
    image = of_two_colors(np.eye(24, dtype=bool))
    image[0, 0] = (1.0, 0.0, 0.0)
    assert not are_pixels_shorter(image)
