"""Structural similarity of an image with a target: what each window contributes to its adjoint, spread over pixels.

``warpvec/fit/similarity.py`` has the formulas and does the same with torch on a GPU. A work item is a band of rows. The
loops along a row are written in C++, because the CPU's compiler turns them into vector instructions.
"""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels.lanes import Lanes, bundle, stage_module
from warpvec.kernels.making import made_once

BAND = 16
"""Rows of a work item, which shares the memory for sums of a row."""

ROOM = 6
"""Rows of sums that a work item needs."""

_WINDOWS = """
typedef {c_type} real;
const int width = image.shape[1], across = width - columns + 1;
const long long plane = (long long)(image.shape[0] - rows + 1) * across;
real* __restrict__ down = room.data + (long long)band * {room} * width;
real* __restrict__ sum = down + 3 * width;
const real* __restrict__ g = image.data + (long long)row * width;
const real* __restrict__ t = target.data + (long long)row * width;
for (int i = 0; i < 6 * width; ++i) down[i] = real(0);
for (int k = 0; k < rows; ++k, g += width, t += width)
    for (int j = 0; j < width; ++j) {{
        down[j] += g[j];
        down[width + j] += g[j] * g[j];
        down[2 * width + j] += g[j] * t[j];
    }}
for (int value = 0; value < 3 * width; value += width)
    for (int k = 0; k < columns; ++k) {{
        const real* __restrict__ from = down + value + k;
        real* __restrict__ to = sum + value;
        for (int j = 0; j < across; ++j) to[j] += from[j];
    }}
const real count = real(rows * columns);
const real* __restrict__ tm = target_mean.data + (long long)row * across;
const real* __restrict__ tv = target_variance.data + (long long)row * across;
real* __restrict__ by_one = slopes.data + (long long)row * across;
real* __restrict__ by_square = by_one + plane;
real* __restrict__ by_product = by_square + plane;
for (int j = 0; j < across; ++j) {{
    const real mean = sum[j] / count;
    const real variance = sum[width + j] / count - mean * mean;
    const real covariance = sum[2 * width + j] / count - mean * tm[j];
    const real luminance = real(2) * mean * tm[j] + c1;
    const real luminance_scale = mean * mean + tm[j] * tm[j] + c1;
    const real structure = real(2) * unbiased * covariance + c2;
    const real structure_scale = unbiased * (variance + tv[j]) + c2;
    const real scale = luminance_scale * structure_scale;
    const real similarity = luminance * structure / scale;
    const real by_covariance = real(2) * unbiased * luminance / scale;
    const real by_variance = -unbiased * similarity / structure_scale;
    const real by_mean = real(2) * (tm[j] * structure / scale - mean * similarity / luminance_scale);
    by_one[j] = by_mean - real(2) * mean * by_variance - tm[j] * by_covariance;
    by_square[j] = by_variance;
    by_product[j] = by_covariance;
}}
"""

_PIXELS = """
typedef {c_type} real;
const int width = image.shape[1], across = width - columns + 1, window_rows = image.shape[0] - rows + 1;
const long long plane = (long long)window_rows * across;
real* __restrict__ down = room.data + (long long)band * {room} * width;
real* __restrict__ sum = down + 3 * width;
for (int i = 0; i < 6 * width; ++i) down[i] = real(0);
const int from_row = row - rows + 1 < 0 ? 0 : row - rows + 1;
const int to_row = row < window_rows ? row : window_rows - 1;
for (int value = 0; value < 3; ++value) {{
    real* __restrict__ to = down + value * width;
    for (int k = from_row; k <= to_row; ++k) {{
        const real* __restrict__ from = slopes.data + value * plane + (long long)k * across;
        for (int j = 0; j < across; ++j) to[j] += from[j];
    }}
    for (int k = 0; k < columns; ++k) {{
        const real* __restrict__ from = down + value * width;
        real* __restrict__ into = sum + value * width + k;
        for (int j = 0; j < across; ++j) into[j] += from[j];
    }}
}}
const real* __restrict__ g = image.data + (long long)row * width;
const real* __restrict__ t = target.data + (long long)row * width;
real* __restrict__ s = shift.data + (long long)row * width;
for (int j = 0; j < width; ++j) s[j] = factor * (sum[j] + real(2) * g[j] * sum[width + j] + t[j] * sum[2 * width + j]);
"""


@made_once
def make_kernels(lanes: Lanes) -> SimpleNamespace:
    """Return ``differentiate_windows`` and ``spread_windows`` for the precision of ``lanes``."""
    dtype, band_rows = lanes.dtype, wp.constant(BAND)
    words = {"c_type": "float" if dtype is wp.float32 else "double", "room": ROOM}
    module = stage_module("similarity", lanes)

    @wp.func_native(_WINDOWS.format(**words))
    def differentiate_row(
        band: int, row: int, rows: int, columns: int, c1: dtype, c2: dtype, unbiased: dtype,
        image: wp.array2d(dtype=dtype), target: wp.array2d(dtype=dtype),
        target_mean: wp.array2d(dtype=dtype), target_variance: wp.array2d(dtype=dtype),
        room: wp.array(dtype=dtype), slopes: wp.array(dtype=dtype),
    ): ...  # fmt: skip

    @wp.func_native(_PIXELS.format(**words))
    def spread_row(
        band: int, row: int, rows: int, columns: int, factor: dtype,
        image: wp.array2d(dtype=dtype), target: wp.array2d(dtype=dtype), slopes: wp.array(dtype=dtype),
        room: wp.array(dtype=dtype), shift: wp.array2d(dtype=dtype),
    ): ...  # fmt: skip

    @wp.kernel(module=module)
    def differentiate_windows(
        first: int,
        rows: int,  # of a window
        columns: int,
        c1: dtype,
        c2: dtype,
        unbiased: dtype,  # n / (n - 1) of the n pixels of a window
        image: wp.array2d(dtype=dtype),  # [h, w] grey
        target: wp.array2d(dtype=dtype),  # [h, w] grey
        target_mean: wp.array2d(dtype=dtype),  # [h - rows + 1, w - columns + 1]
        target_variance: wp.array2d(dtype=dtype),  # as the mean
        # outputs
        room: wp.array(dtype=dtype),  # [bands ROOM w]
        slopes: wp.array(dtype=dtype),  # [3 windows] by the sum of values, of squares and of products with the target
    ):
        """Differentiate the similarity in the windows of a band by the sums over their pixels."""
        band = first + wp.tid()
        start = band * band_rows
        for row in range(start, wp.min(start + band_rows, image.shape[0] - rows + 1)):
            differentiate_row(
                band, row, rows, columns, c1, c2, unbiased, image, target, target_mean, target_variance, room, slopes
            )

    @wp.kernel(module=module)
    def spread_windows(
        first: int,
        rows: int,
        columns: int,
        factor: dtype,
        image: wp.array2d(dtype=dtype),  # [h, w]
        target: wp.array2d(dtype=dtype),  # [h, w]
        slopes: wp.array(dtype=dtype),  # [3 windows]
        # outputs
        room: wp.array(dtype=dtype),  # [bands ROOM w]
        shift: wp.array2d(dtype=dtype),  # [h, w]
    ):
        """Add up the slopes of the windows around each pixel of a band, and write its shift times ``factor``."""
        band = first + wp.tid()
        start = band * band_rows
        for row in range(start, wp.min(start + band_rows, image.shape[0])):
            spread_row(band, row, rows, columns, factor, image, target, slopes, room, shift)

    return bundle(differentiate_windows, spread_windows)
