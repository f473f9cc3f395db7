"""PSNR and SSIM of two images."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec.errors import InputError
from warpvec.image.alpha import MATTES, is_transparent, over

Image = NDArray[np.float64]
"""Of shape [h, w, c], in [0, 1]."""

SSIM_WINDOW = 7
"""Side of the square window of SSIM, scikit-image's default."""

# Stabilisers of SSIM for a data range of 1, from Wang et al. 2004: (K1 L)^2 and (K2 L)^2.
_SSIM_C1, _SSIM_C2 = 0.01**2, 0.03**2

# Pixels compared at a time, a few rows at least: their copies in float64 stay in the cache, which takes a third of the
# time of bands of 256 rows 8000 pixels wide.
_BAND_PIXELS, _BAND_ROWS_MIN = 2**16, 16


def psnr(a: NDArray[Any], b: NDArray[Any]) -> float:
    """Peak signal-to-noise ratio in dB over all channels of two images [h, w, c]; infinite where they are equal.

    Each is uint8, or float in [0, 1]. Images of four channels are RGBA, straight: their error is the mean of those of
    what they show on a black and on a white page.
    """
    _check_images(a, b)
    squares = math.fsum(np.square(x - y).sum() for x, y in _bands(a, b))
    return 10.0 * math.log10(_value_count(a.shape) / squares) if squares else math.inf


def ssim(a: NDArray[Any], b: NDArray[Any]) -> float:
    """Mean structural similarity (Wang et al. 2004) of two images [h, w, c], each uint8 or float in [0, 1].

    Images of four channels are compared on a black and on a white page, as by `psnr`, and the mean is over both.

    Agrees with scikit-image's ``structural_similarity(a, b, channel_axis=2, data_range=1)``: uniform 7x7 windows
    inside the image, sample covariance. On an image smaller than the window, where scikit-image gives up, the
    window is cut to the image.
    """
    _check_images(a, b)
    rows, columns = min(SSIM_WINDOW, a.shape[0]), min(SSIM_WINDOW, a.shape[1])
    maps = (_ssim_map(x, y, rows, columns) for x, y in _bands(a, b, overlap=rows - 1))
    window_count = _value_count((a.shape[0] - rows + 1, a.shape[1] - columns + 1, a.shape[2]))
    return math.fsum(float(similarity.sum()) for similarity in maps) / window_count


def _check_images(a: NDArray[Any], b: NDArray[Any]) -> None:
    if a.shape != b.shape or a.ndim != 3 or not a.size:
        raise InputError(f"images to compare must share one shape [h, w, c], got {list(a.shape)} and {list(b.shape)}")
    for image in (a, b):
        if image.dtype != np.uint8 and image.dtype.kind != "f":
            raise InputError(f"images to compare must be uint8 or float in [0, 1], got {image.dtype}; scale them first")


def _bands(a: NDArray[Any], b: NDArray[Any], overlap: int = 0) -> Iterator[tuple[Image, Image]]:
    """Both images as float64 in bands of rows, each ``overlap`` rows into the next; RGBA on its pages [h, w, 6]."""
    row_count = max(_BAND_ROWS_MIN, _BAND_PIXELS // a.shape[1])
    for top in range(0, len(a) - overlap, row_count):
        rows = slice(top, top + row_count + overlap)
        yield _on_pages(_as_float(a[rows], b.dtype)), _on_pages(_as_float(b[rows], a.dtype))


def _on_pages(image: Image) -> Image:
    return np.concatenate([over(image, page) for page in MATTES], axis=2) if is_transparent(image) else image


def _value_count(shape: tuple[int, ...]) -> int:
    """Values that are compared in images of ``shape`` [h, w, c]."""
    return shape[0] * shape[1] * (3 * len(MATTES) if shape[2] == 4 else shape[2])


def _as_float(image: NDArray[Any], other: np.dtype[Any]) -> Image:
    """``image`` in [0, 1]; 8 bits rounded to the precision of the ``other`` that it is compared with."""
    if image.dtype != np.uint8:
        return image.astype(np.float64)
    # So that equal pixels are equal.
    return image / 255.0 if other == np.uint8 else (image / 255.0).astype(other).astype(np.float64)


def _ssim_map(a: Image, b: Image, rows: int, columns: int) -> Image:
    """SSIM of every window of ``rows`` x ``columns`` (Wang et al. 2004, equation 13)."""
    mean_a, mean_b = (_window_mean(x, rows, columns) for x in (a, b))
    # A window of one pixel has no variance to correct.
    unbiased = rows * columns / max(rows * columns - 1, 1)
    variances = unbiased * (_window_mean(a * a + b * b, rows, columns) - mean_a**2 - mean_b**2)
    covariance = unbiased * (_window_mean(a * b, rows, columns) - mean_a * mean_b)
    luminance = (2 * mean_a * mean_b + _SSIM_C1) / (mean_a**2 + mean_b**2 + _SSIM_C1)
    return luminance * (2 * covariance + _SSIM_C2) / (variances + _SSIM_C2)


def _window_mean(x: Image, rows: int, columns: int) -> Image:
    height, width = x.shape[0] - rows + 1, x.shape[1] - columns + 1
    down = functools.reduce(np.add, (x[row : row + height] for row in range(rows)))
    both = functools.reduce(np.add, (down[:, column : column + width] for column in range(columns)))
    return both / (rows * columns)


def psnr_from_mse(mse: float) -> float:
    """Peak signal-to-noise ratio in dB for values in [0, 1]; infinite when ``mse`` is 0."""
    return math.inf if mse <= 0.0 else -10.0 * math.log10(mse)
