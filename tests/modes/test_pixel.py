"""Pixel art and codes become exact squares, found by themselves; drawings do not."""

from __future__ import annotations

import numpy as np
import pytest
from damage import as_jpeg, drawn
from PIL import Image
from PIL.Image import Resampling
from scipy.ndimage import gaussian_filter
from sweep import sweep

import warpvec
from warpvec.errors import InputError
from warpvec.svg.measure import draw

COLORS = np.array([[230, 230, 240], [20, 20, 30], [220, 60, 50], [40, 90, 200]], np.uint8)


def sprite(side: int = 18) -> Image.Image:
    """Return blobs of four colours."""
    smooth = gaussian_filter(np.random.default_rng(4).normal(size=(side, side)), 1.2)
    return Image.fromarray(COLORS[np.digitize(smooth, np.quantile(smooth, [0.4, 0.6, 0.8]))])


def code(side: int = 25) -> Image.Image:
    """Return black and white modules."""
    modules = np.random.default_rng(2).random((side, side)) < 0.5
    return Image.fromarray(np.where(modules, 0, 255).astype(np.uint8)).convert("RGB")


def pixels_of(result: warpvec.Result) -> np.ndarray:
    return draw(result.svg(), result.picture.width, result.picture.height)


@sweep("factor", [1, 2, 7, 11])
def test_pixel_art_and_codes_are_found_and_exact(factor: int) -> None:
    for small, colors in ((sprite(), 4), (code(), 2)):
        large = small.resize((small.width * factor, small.height * factor), Resampling.NEAREST)
        result = warpvec.vectorize(large)
        assert result.config.mode == "pixel"
        np.testing.assert_array_equal(pixels_of(result), np.asarray(large))
        assert len(result.scene) == colors - 1  # one colour is the canvas


def test_transparent_pixels_stay_so() -> None:
    levels = np.dstack([np.asarray(sprite()), np.full((18, 18), 255, np.uint8)])
    levels[:6, :9] = 0
    levels[12:, 12:, 3] = 128
    result = warpvec.vectorize(levels)
    assert result.config.mode == "pixel"
    seen = draw(result.svg(), 18, 18, transparent=True).astype(int)
    assert np.abs(seen - levels).max() <= 1


def test_pixel_art_saved_as_jpeg_gets_its_colors_again() -> None:
    result = warpvec.vectorize(as_jpeg(sprite().resize((216, 216), Resampling.NEAREST), 75))
    assert result.config.mode == "pixel"
    clean = np.asarray(sprite().resize((216, 216), Resampling.NEAREST)).astype(int)
    assert np.abs(pixels_of(result) - clean).max() <= 6
    assert len(result.scene) == 3


def test_a_shape_of_two_colors_is_not_pixel_art() -> None:
    y, x = np.mgrid[:32, :48]
    disc = np.where((x - 24) ** 2 + (y - 16) ** 2 < 120, 0, 255).astype(np.uint8)
    assert warpvec.vectorize(disc, iterations=2).config.mode != "pixel"


@sweep("width", [16, 24, 48])
def test_clean_icons_are_not_pixel_art(width: int) -> None:
    assert warpvec.vectorize(drawn(width), iterations=2, threads=1).config.mode != "pixel"


def test_any_picture_can_be_drawn_in_pixels() -> None:
    result = warpvec.vectorize(drawn(40), mode="pixel")
    np.testing.assert_array_equal(pixels_of(result), np.asarray(drawn(40)))
    few = warpvec.vectorize(drawn(40), mode="pixel", colors=5)
    assert len(np.unique(pixels_of(few).reshape(-1, 3), axis=0)) <= 5


def test_too_many_pixels_are_refused() -> None:
    with pytest.raises(InputError, match="at most 1048576 pixels"):
        warpvec.vectorize(np.zeros((1200, 1000, 3), np.uint8), mode="pixel", fit_size=4096)
