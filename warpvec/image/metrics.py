"""Compare two images by PSNR and SSIM."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec.errors import InputError
from warpvec.image.alpha import MATTES, over_mattes

Image = NDArray[np.float64]
"""Array [h, w, c] in [0, 1]."""

SSIM_WINDOW = 7
"""Side of the square window of SSIM in pixels, the default of scikit-image."""

SSIM_C1, SSIM_C2 = 0.01**2, 0.03**2
"""Stabilisers of SSIM for a data range of 1, from Wang et al. 2004: (K1 L)^2 and (K2 L)^2."""

# Images are compared in bands of so many pixels and at least so many rows. Their float64 copies stay in the cache,
# which takes a third of the time of bands of 256 rows for images 8000 pixels wide.
_BAND_PIXELS, _BAND_ROWS_MIN = 2**16, 16


def psnr(a: NDArray[Any], b: NDArray[Any]) -> float:
    """Return the peak signal-to-noise ratio of two images [h, w, c] in dB, over all channels; infinite if equal.

    Each image is uint8, or float in [0, 1]. Images of four channels are straight RGBA; their error is the mean of the
    errors over a black and over a white matte.
    """
    _check_images(a, b)
    squares = math.fsum(np.square(x - y).sum() for x, y in _bands(a, b))
    return _decibels(_value_count(a.shape), squares)


def psnr_from_mse(mse: float) -> float:
    """Return the peak signal-to-noise ratio in dB of a mean squared error of values in [0, 1]; infinite for 0."""
    return -_decibels(mse, 1.0) if mse > 0.0 else math.inf


def _decibels(power: float, reference: float) -> float:
    """Return the ratio of two powers in dB; infinite if ``reference`` is 0."""
    return 10.0 * math.log10(power / reference) if reference else math.inf


def ssim(a: NDArray[Any], b: NDArray[Any]) -> float:
    """Return the mean structural similarity (Wang et al. 2004) of two images [h, w, c], uint8 or float in [0, 1].

    Images of four channels are compared over a black and over a white matte, as by `psnr`; the mean is over both.

    The result agrees with scikit-image's ``structural_similarity(a, b, channel_axis=2, data_range=1)``: uniform 7x7
    windows inside the image, sample covariance. For an image smaller than the window, which scikit-image refuses, the
    window is cut to the image.
    """
    _check_images(a, b)
    rows, columns = min(SSIM_WINDOW, a.shape[0]), min(SSIM_WINDOW, a.shape[1])
    maps = (_ssim_map(x, y, rows, columns) for x, y in _bands(a, b, overlap=rows - 1))
    window_count = _value_count((a.shape[0] - rows + 1, a.shape[1] - columns + 1, a.shape[2]))
    return math.fsum(float(similarity.sum()) for similarity in maps) / window_count


def _check_images(a: NDArray[Any], b: NDArray[Any]) -> None:
    if a.shape != b.shape or a.ndim != 3 or not a.size:
        shapes = f"{list(a.shape)} and {list(b.shape)}"
        raise InputError("images", "must have the same shape [h, w, c] to be compared", shapes, "resize one of them")
    for image in (a, b):
        if image.dtype != np.uint8 and image.dtype.kind != "f":
            rule = "must be uint8 or float in [0, 1] to be compared"
            raise InputError("images", rule, str(image.dtype), "convert them first")


def _bands(a: NDArray[Any], b: NDArray[Any], overlap: int = 0) -> Iterator[tuple[Image, Image]]:
    """Yield bands of rows of both images as float64, each overlapping the next by ``overlap`` rows.

    RGBA images become [h, w, 6]: their colours over the black and over the white matte.
    """
    row_count = max(_BAND_ROWS_MIN, _BAND_PIXELS // a.shape[1])
    for top in range(0, len(a) - overlap, row_count):
        rows = slice(top, top + row_count + overlap)
        yield over_mattes(_as_float(a[rows], b.dtype)), over_mattes(_as_float(b[rows], a.dtype))


def _value_count(shape: tuple[int, ...]) -> int:
    """Return how many values are compared in images of ``shape`` [h, w, c]."""
    return shape[0] * shape[1] * (3 * len(MATTES) if shape[2] == 4 else shape[2])


def _as_float(image: NDArray[Any], other: np.dtype[Any]) -> Image:
    """Return ``image`` in [0, 1] as float64; uint8 is first rounded to the type of the ``other`` image."""
    if image.dtype != np.uint8:
        return image.astype(np.float64)
    # Rounded so that equal pixels stay equal.
    return image / 255.0 if other == np.uint8 else (image / 255.0).astype(other).astype(np.float64)


def _ssim_map(a: Image, b: Image, rows: int, columns: int) -> Image:
    """Return the SSIM of every window of ``rows`` x ``columns`` (Wang et al. 2004, equation 13)."""
    mean_a, mean_b = (_window_mean(x, rows, columns) for x in (a, b))
    # A window of one pixel has no variance to correct.
    unbiased = rows * columns / max(rows * columns - 1, 1)
    variances = unbiased * (_window_mean(a * a + b * b, rows, columns) - mean_a**2 - mean_b**2)
    covariance = unbiased * (_window_mean(a * b, rows, columns) - mean_a * mean_b)
    luminance = (2 * mean_a * mean_b + SSIM_C1) / (mean_a**2 + mean_b**2 + SSIM_C1)
    return luminance * (2 * covariance + SSIM_C2) / (variances + SSIM_C2)


def _window_mean(x: Image, rows: int, columns: int) -> Image:
    height, width = x.shape[0] - rows + 1, x.shape[1] - columns + 1
    down = functools.reduce(np.add, (x[row : row + height] for row in range(rows)))
    both = functools.reduce(np.add, (down[:, column : column + width] for column in range(columns)))
    return both / (rows * columns)
