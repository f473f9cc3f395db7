"""The derivatives of pixels by the outlines of a drawing: by the four points of each curve, and by a stroke's width."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from warpvec.kernels.constants import TILE
from warpvec.polish.outline_samples import CrossedPixels
from warpvec.rendering.stages.pixel_slopes import HitSlopes

CURVE_VALUES = 9
"""Values of a row: the coordinates of the four points of its curve, and the width of its stroke."""

TILE_PIXELS = TILE * TILE


class OutlineSlopes:
    """The derivatives of the pixels that outlines cross, as the parts of a drawing are added.

    Args:
        crossed: pairs of a curve and a pixel.
        path: the path of each row [R].
        columns: number of columns of tiles.
        matte_scale: see `warpvec.fit.target.Target.matte_scale`.

    Attributes:
        pixels: the crossed pixels [P], in ascending order: ``TILE_PIXELS`` times the tile plus the place in it, which
            is counted column by column.
    """

    def __init__(self, crossed: CrossedPixels, path: NDArray[np.int64], columns: int, matte_scale: float) -> None:
        tile = crossed.y // TILE * columns + crossed.x // TILE
        pixel = TILE_PIXELS * tile + crossed.x % TILE * TILE + crossed.y % TILE
        order = np.argsort(pixel, kind="stable")
        self._pixel, row = pixel[order], crossed.row[order]
        self._path = path[row]
        self._row_count, self._path_count = len(path), int(path.max(initial=0)) + 1
        is_new = np.diff(self._pixel, prepend=-1) > 0
        self.pixels, self._place = self._pixel[is_new], np.cumsum(is_new) - 1
        bounds = CURVE_VALUES * np.arange(len(row) + 1)
        columns_of = (CURVE_VALUES * row[:, None] + np.arange(CURVE_VALUES)).ravel()
        shape = (len(row), CURVE_VALUES * len(path))
        # How the winding of a pixel changes with the values of a row [M, 9 R].
        self._windings = sparse.csr_matrix((crossed.slopes[order].ravel(), columns_of, bounds), shape=shape)
        self._by_winding = np.zeros((len(row), 4))
        self._scale = np.array([1.0, 1.0, 1.0, matte_scale])

    def add(self, part: HitSlopes) -> None:
        """Add the derivatives in some more tiles."""
        first, last = np.searchsorted(self._pixel, TILE_PIXELS * np.array(part.tiles))
        if first == last or not len(part.tile):
            return
        tile, place = np.divmod(self._pixel[first:last], TILE_PIXELS)
        keys, wanted = (
            owner * self._path_count + path for owner, path in ((part.tile, part.path), (tile, self._path[first:last]))
        )
        hit = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
        is_known = (keys[hit] == wanted) & part.is_partial[hit]
        found = part.slopes[hit, :, place] * self._scale
        self._by_winding[first:last] = np.where(is_known[:, None], found, 0.0)

    def half_squares(self) -> sparse.csr_matrix:
        """Return half of the Gauss-Newton matrix of the values of all rows [9 R, 9 R]; its transpose is the other."""
        count, starts, ends, weights = len(self._place), [], [], []
        for gap in range(count):  # to the next curves that cross the same pixel
            first = np.flatnonzero(self._place[gap:] == self._place[: count - gap])
            if not len(first):
                break
            share = 1.0 if gap else 0.5
            weights.append(share * (self._by_winding[first] * self._by_winding[first + gap]).sum(1))
            starts.append(first)
            ends.append(first + gap)
        if not weights:
            return sparse.csr_matrix((CURVE_VALUES * self._row_count,) * 2)
        where = (np.concatenate(starts), np.concatenate(ends))
        pairs = sparse.csr_matrix((np.concatenate(weights), where), shape=(count, count))
        return self._by_rows @ (pairs @ self._windings)

    def products(self, paints: sparse.csr_matrix) -> sparse.csr_matrix:
        """Return the same of the values of rows and of other values [9 R, V].

        Args:
            paints: derivatives of red, then of green, then of blue of the crossed pixels by these values [3 P, V].
        """
        count, channels = len(self._place), np.arange(3)
        where = (self._place[:, None] + len(self.pixels) * channels).ravel()
        own = (self._by_winding[:, :3].ravel(), where, 3 * np.arange(count + 1))
        by_channels = sparse.csr_matrix(own, shape=(count, 3 * len(self.pixels)))
        return self._by_rows @ (by_channels @ paints)

    @cached_property
    def _by_rows(self) -> sparse.csr_matrix:
        return self._windings.T.tocsr()
