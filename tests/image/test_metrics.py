"""PSNR and SSIM against scikit-image, and images that cannot be compared."""

from __future__ import annotations

import math

import numpy as np
import pytest
from skimage.metrics import peak_signal_noise_ratio, structural_similarity
from svg_files import refusal

from warpvec.image import metrics
from warpvec.image.metrics import psnr, ssim


def image_pair(height: int, width: int, seed: int = 0, dtype: str = "float64"):
    """A smooth image and a disturbed copy."""
    generator = np.random.default_rng(seed)
    waves = np.sin(np.arange(height)[:, None, None] / 9 + np.arange(width)[:, None] / 5 + np.arange(3))
    first = 0.5 + 0.4 * waves
    second = np.clip(first + 0.1 * generator.standard_normal(first.shape), 0, 1)
    if dtype == "uint8":
        return (first * 255).round().astype(np.uint8), (second * 255).round().astype(np.uint8)
    return first.astype(dtype), second.astype(dtype)


@pytest.mark.parametrize("dtype", ["float64", "float32", "uint8"])
def test_psnr_agrees_with_scikit_image(dtype):
    first, second = image_pair(600, 31, dtype=dtype)
    expected = peak_signal_noise_ratio(first, second, data_range=255 if dtype == "uint8" else 1)
    assert psnr(first, second) == pytest.approx(expected, abs=1e-5)


def test_psnr_of_a_known_difference():
    black = np.zeros((5, 7, 3))
    assert psnr(black, black + 0.1) == pytest.approx(20.0)
    assert psnr(black, black) == math.inf
    assert psnr(np.full((2, 2, 3), 51, np.uint8), np.full((2, 2, 3), 0.2)) == math.inf


# Images are compared in bands, here of 256 rows. The heights cross their borders: by one row less, by one window row
# more, by two and a half bands.
@pytest.mark.parametrize(
    "shape", [(7, 7), (7, 40), (33, 50), (255, 9), (256, 9), (257, 9), (262, 9), (263, 9), (640, 12)]
)
def test_ssim_agrees_with_scikit_image(shape, monkeypatch):
    monkeypatch.setattr(metrics, "_BAND_PIXELS", 256 * shape[1])
    first, second = image_pair(*shape)
    expected = structural_similarity(first, second, channel_axis=2, data_range=1)
    assert ssim(first, second) == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("dtype", ["float32", "uint8"])
def test_ssim_of_other_types_agrees_with_scikit_image(dtype):
    first, second = image_pair(40, 50, dtype=dtype)
    expected = structural_similarity(first, second, channel_axis=2, data_range=255 if dtype == "uint8" else 1)
    assert ssim(first, second) == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("side", [3, 5])
def test_ssim_of_a_small_image_has_a_smaller_window(side):
    first, second = image_pair(side, side)
    expected = structural_similarity(first, second, channel_axis=2, data_range=1, win_size=side)
    assert ssim(first, second) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("shape", [(1, 1), (1, 9), (4, 1), (2, 300)])
def test_ssim_is_defined_for_any_size(shape):
    first, second = image_pair(*shape)
    assert ssim(first, first) == pytest.approx(1.0)
    assert -1.0 <= ssim(first, second) < 1.0


@pytest.mark.parametrize("function", [psnr, ssim])
def test_images_that_cannot_be_compared_are_refused(function):
    image = np.zeros((4, 4, 3))
    assert "the same shape" in refusal(function, image, image[:3])
    assert "the same shape" in refusal(function, image[..., 0], image[..., 0])
    assert "the same shape" in refusal(function, image[:0], image[:0])
    assert "uint16" in refusal(function, image, image.astype(np.uint16))
