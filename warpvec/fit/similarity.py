"""The term of the loss for structural similarity (SSIM, Wang et al. 2004), as a shift of the target.

The loss has the term w (1 - SSIM) beside the mean squared error over the 3 h w values I of the image. The adjoint of
the error is 2 (I - T) / (3 h w) for the target T. So the adjoint of the sum is that of the error alone against the
target T + w h w / 2 dSSIM/dg. Here g is the mean of the three channels, of which SSIM is taken: of each channel it
would cost three times as much, for files of the same SSIM.

There is such a term for each of several scales: images of half the sides, a quarter and so on, by means of squares.

The weight w is a constant times the present mean squared error E. So the sum has the gradient of log E + constant
(1 - SSIM), times E: one SSIM is worth as many decibels in every photo, whether its error is small or large.

The renderer's fused step takes such a shift in for next to nothing. It changes slowly, so it is computed only once in
``schedule.SHIFT_GAP`` iterations: on the CPU by ``kernels/similarity.py``, on a GPU by torch.
"""

from __future__ import annotations

import torch
import warp as wp
from torch import Tensor
from torch.nn.functional import avg_pool2d, pad

from warpvec.image.metrics import SSIM_C1, SSIM_C2, SSIM_WINDOW
from warpvec.kernels.constants import TILE
from warpvec.kernels.lanes import make_lanes
from warpvec.kernels.similarity import BAND, ROOM, make_kernels
from warpvec.rendering.launch import Launcher, as_warp, start_warp

SCALE_COUNT = 5
"""Scales at most. kodim05, 13 and 23 at 512 paths, with a weight of 0.7: five scales give 26.03 to 26.08 dB and LPIPS
(VGG) 0.483, four 25.99 and 0.487. With a weight of 1, one gives 25.95 dB and 0.492."""

WINDOW_SIDES = 4.1
"""Largest side of a window over that of a square of a path's share of the image. With 1,340 paths, kodim07 has 33.01 dB
with five scales, whose largest windows are 6.5 times such a side, 33.12 with four, and 33.15 with three."""


class Similarity:
    """SSIM of images with a ``target`` [h, w, 3], at one scale or more.

    Windows of each scale have twice the sides of those before. They are no larger than the image or ``WINDOW_SIDES``.
    Rows and columns that fill no square of a scale do not count there.
    """

    def __init__(self, target: Tensor, path_count: int) -> None:
        """Compare with ``target`` the images of ``path_count`` paths."""
        scales = [target.mean(2)]
        side = (scales[0].numel() / path_count) ** 0.5
        while len(scales) < SCALE_COUNT and min(scales[-1].shape) >= 2 * SSIM_WINDOW:
            if SSIM_WINDOW * 2 ** len(scales) > WINDOW_SIDES * side:
                break
            scales.append(_halved(scales[-1]))
        self._scales = [ScaleSimilarity(gray) for gray in scales]

    def shift(self, image: Tensor, weight: Tensor) -> Tensor:
        """Return the shift [h, w] of the target for an ``image`` [h, w, 3], with the weight w of each scale."""
        gray = image.mean(2)
        shifts: list[Tensor] = []
        for scale in self._scales:
            gray = gray if not shifts else _halved(gray)
            shifts.append(scale.shift(gray, weight))
        total = shifts.pop()
        while shifts:
            height, width = total.shape
            doubled = total[:, None, :, None].expand(-1, 2, -1, 2).reshape(2 * height, 2 * width)
            total = shifts.pop()
            total[: 2 * height, : 2 * width] += doubled
        return total


def _halved(gray: Tensor) -> Tensor:
    """Return the mean of each square of 2 x 2 pixels of ``gray`` [h, w]."""
    return avg_pool2d(gray[None], 2)[0]


class ScaleSimilarity:
    """SSIM of grey images with a ``target`` [h, w], in windows as in `warpvec.image.metrics.ssim`.

    The sum over the windows is divided by h w, although there are no windows at the border: sizes stay comparable. At
    the k-th smaller scale, which has 4^k times fewer pixels, it is divided by h w / 4^k.
    """

    def __init__(self, target: Tensor) -> None:
        self._target = target
        height, width = self._target.shape
        self._window = (min(SSIM_WINDOW, height), min(SSIM_WINDOW, width))
        self._area = self._window[0] * self._window[1]
        self._unbiased = self._area / max(self._area - 1, 1)
        self._mean = self._means(self._target)
        self._variance = self._means(self._target.square()) - self._mean.square()
        start_warp()
        self._launch = Launcher("cpu", threads=1)

    def shift(self, gray: Tensor, weight: Tensor) -> Tensor:
        """Return the shift [h, w] of the target for a ``gray`` image [h, w], with the weight w."""
        return self.shift_by_torch(gray, weight) if gray.is_cuda else self._shift_by_kernel(gray.contiguous(), weight)

    def _shift_by_kernel(self, gray: Tensor, weight: Tensor) -> Tensor:
        """Return the shift on the CPU, where each operation of torch reads and writes whole images."""
        lanes = make_lanes(TILE, wp.dtype_from_torch(gray.dtype))
        (height, width), (rows, columns), real = gray.shape, self._window, lanes.dtype
        kernels, band_count = make_kernels(lanes), -(-height // BAND)
        room = as_warp(gray.new_empty(band_count * ROOM * width), real)
        slopes = as_warp(gray.new_empty(3 * self._mean.numel()), real)
        shift = torch.empty_like(gray)
        pixels = [as_warp(values, real) for values in (gray, self._target)]
        windows = [as_warp(values, real) for values in (self._mean, self._variance)]
        settings = [rows, columns, real(SSIM_C1), real(SSIM_C2), real(self._unbiased)]
        self._launch(kernels.differentiate_windows, band_count, [*settings, *pixels, *windows, room, slopes])
        factor = real(0.5 * float(weight) / self._area)
        self._launch(
            kernels.spread_windows, band_count, [rows, columns, factor, *pixels, slopes, room, as_warp(shift, real)]
        )
        return shift

    def shift_by_torch(self, gray: Tensor, weight: Tensor) -> Tensor:
        """Return the shift on any device; ``kernels/similarity.py`` has the same formulas."""
        mean = self._means(gray)
        variance = self._means(gray.square()) - mean.square()
        covariance = self._means(gray * self._target) - mean * self._mean
        luminance = 2.0 * mean * self._mean + SSIM_C1
        luminance_scale = mean.square() + self._mean.square() + SSIM_C1
        structure = 2.0 * self._unbiased * covariance + SSIM_C2
        structure_scale = self._unbiased * (variance + self._variance) + SSIM_C2
        scale = luminance_scale * structure_scale
        similarity = luminance * structure / scale
        by_covariance = 2.0 * self._unbiased * luminance / scale
        by_variance = -self._unbiased * similarity / structure_scale
        by_mean = 2.0 * (self._mean * structure / scale - mean * similarity / luminance_scale)
        constant = by_mean - 2.0 * mean * by_variance - self._mean * by_covariance
        spread = [self._spread(values) for values in (constant, by_variance, by_covariance)]
        return (0.5 * weight / self._area) * (spread[0] + 2.0 * gray * spread[1] + self._target * spread[2])

    def _means(self, values: Tensor) -> Tensor:
        """Return the mean of ``values`` [h, w] in each window inside the image."""
        return _window_sums(_window_sums(values, self._window[0], 0), self._window[1], 1) / self._area

    def _spread(self, values: Tensor) -> Tensor:
        """Return the sum of ``values``, one of each window, over the windows around each pixel [h, w]."""
        rows, columns = self._window[0] - 1, self._window[1] - 1
        return _window_sums(_window_sums(pad(values, (columns, columns, rows, rows)), rows + 1, 0), columns + 1, 1)


def _window_sums(values: Tensor, size: int, dim: int) -> Tensor:
    """Return the sums of ``size`` consecutive ``values`` along ``dim``."""
    count = values.shape[dim] - size + 1
    total = values.narrow(dim, 0, count).clone()
    for offset in range(1, size):
        total += values.narrow(dim, offset, count)
    return total
