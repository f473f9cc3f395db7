"""Enlargement as a matrix, and its inverse: the small picture that explains an enlarged one.

Programs enlarge a row of n pixels to N by weights that depend on the distance from the old centre to the new one. The
enlarged row is U s, with a sparse matrix U [N, n]. The row s that explains it best solves U^T U s = U^T row, which has
few diagonals.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property, lru_cache
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import cho_solve_banded, cholesky_banded
from scipy.sparse import csr_matrix

from warpvec.arrays import Floats
from warpvec.condition.constants import CONDITION


class Kernel(NamedTuple):
    """A kernel of interpolation: its weight at a distance in pixels of the small picture, and its radius."""

    weight: Callable[[Floats], Floats]
    radius: int


def _triangle(distance: Floats) -> Floats:
    return np.maximum(0.0, 1.0 - distance)


def _cubic(b: float, c: float) -> Callable[[Floats], Floats]:
    """Return a cubic kernel. Source: Mitchell and Netravali, Reconstruction filters in computer graphics, 1988."""

    def weight(distance: Floats) -> Floats:
        near = ((12 - 9 * b - 6 * c) * distance + (-18 + 12 * b + 6 * c)) * distance**2 + 6 - 2 * b
        far = (((-b - 6 * c) * distance + (6 * b + 30 * c)) * distance - 12 * b - 48 * c) * distance + 8 * b + 24 * c
        return np.where(distance < 1.0, near, np.where(distance < 2.0, far, 0.0)) / 6.0

    return weight


def _lanczos(distance: Floats) -> Floats:
    return np.where(distance < 3.0, np.sinc(distance) * np.sinc(distance / 3.0), 0.0)


NEAREST = "nearest"

KERNELS = {
    "bicubic": Kernel(_cubic(0.0, 0.5), 2),  # Pillow, ImageMagick, GIMP
    "bilinear": Kernel(_triangle, 1),
    "lanczos": Kernel(_lanczos, 3),
    "mitchell": Kernel(_cubic(1 / 3, 1 / 3), 2),  # browsers
    "sharp bicubic": Kernel(_cubic(0.0, 0.75), 2),  # OpenCV, Photoshop
}
"""The kernels that interpolate, by the name that the summary gives."""


class Upsampling:
    """The enlargement of rows of ``small`` pixels to ``large`` pixels.

    Attributes:
        matrix: the weights U [large, small].
    """

    def __init__(self, large: int, small: int, kernel: str) -> None:
        """Build the matrix. ``kernel`` is a key of ``KERNELS`` or ``NEAREST``."""
        place = (np.arange(large) + 0.5) * (small / large) - 0.5
        if kernel == NEAREST:
            first = np.minimum(((2 * np.arange(large) + 1) * small) // (2 * large), small - 1)
            weights = np.ones((large, 1))
        else:
            weight, radius = KERNELS[kernel]
            first = np.floor(place).astype(np.int64) + 1 - radius
            columns = first[:, None] + np.arange(2 * radius)
            is_inside = (columns >= 0) & (columns < small)
            weights = np.where(is_inside, weight(np.abs(place[:, None] - columns)), 0.0)
            weights /= weights.sum(1, keepdims=True)
        self._weights = weights
        self._columns = np.clip(first[:, None] + np.arange(weights.shape[1]), 0, small - 1)
        starts = np.arange(large + 1) * weights.shape[1]
        self.matrix = csr_matrix((weights.ravel(), self._columns.ravel(), starts), (large, small))

    def inverse(self, rows: Floats) -> Floats:
        """Return the small rows [small, N] that explain the large ``rows`` [large, N] best, by least squares."""
        return self._solved(self.matrix.T @ rows)

    def inverse_of_cut_off(self, rows: Floats, low: float, high: float) -> Floats:
        """Return the small rows [small, N] that explain ``rows`` [large, N], cut off at ``low`` and ``high``, best.

        Kernels with negative weights overshoot beside an edge, and what is darker than black is saved as black. Such a
        pixel may have any value beyond, so the one that the others predict takes its place.
        """
        is_low, is_high = rows <= low, rows >= high
        small = self.inverse(rows)
        for _ in range(CONDITION.cut_off_rounds):
            predicted = self.matrix @ small
            beyond = np.where(is_high, np.maximum(predicted, rows), np.where(is_low, np.minimum(predicted, rows), rows))
            small = self.inverse(beyond)
        return small

    def unexplained(self, rows: Floats) -> float:
        """Return the root mean square of what no small rows explain of the large ``rows`` [large, N]."""
        return float(np.sqrt(np.mean((rows - self.matrix @ self.inverse(rows)) ** 2)))

    def unexplained_of_cut_off(self, rows: Floats, low: float, high: float) -> float:
        """Return what no small rows explain of ``rows`` [large, N], cut off at ``low`` and ``high``; else as above."""
        predicted = self.matrix @ self.inverse_of_cut_off(rows, low, high)
        return float(np.sqrt(np.mean((rows - predicted.clip(low, high)) ** 2)))

    def _solved(self, sums: Floats) -> Floats:
        """Return the solution s [small, N] of U^T U s = ``sums`` [small, N]."""
        return np.asarray(cho_solve_banded((self._factor, True), sums, check_finite=False), np.float64)

    @cached_property
    def _factor(self) -> Any:
        """The banded Cholesky factor of U^T U."""
        small, width = self.matrix.shape[1], self._weights.shape[1]
        bands = np.zeros((width, small))
        for offset in range(width):
            products = self._weights[:, : width - offset] * self._weights[:, offset:]
            # Columns that the border has clipped have no weight, so their products are 0.
            places = self._columns[:, : width - offset]
            bands[offset] = np.bincount(places.ravel(), products.ravel(), minlength=small)
        bands[0] += CONDITION.ridge * bands[0].mean()
        return cholesky_banded(bands, lower=True, check_finite=False)


KEPT_SIDE = 1024
"""Longest row of pixels whose enlargements are kept: 128 of them take some 20 MB."""


def upsampling(large: int, small: int, kernel: str) -> Upsampling:
    """Return the `Upsampling`, which is kept for the other axis, and for the next picture of a folder of icons."""
    return _kept(large, small, kernel) if large <= KEPT_SIDE else Upsampling(large, small, kernel)


_kept = lru_cache(maxsize=128)(Upsampling)
