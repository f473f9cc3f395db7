"""The derivatives of pixels by the paints of a drawing: colours, the background, stops and ends of gradients."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from warpvec.geometry.paints.kind import GEOMETRY_SIZE
from warpvec.geometry.paints.registry import FLAT, kind_of
from warpvec.geometry.scene import Scene
from warpvec.geometry.stops import STOPS_MAX
from warpvec.polish.stop_slopes import StopRow, inner_color_index, slopes_of, stop_rows
from warpvec.polish.stop_variables import stop_parts

Values = NDArray[np.float64]

SHARE_MIN = 1e-3
"""A path that shows less of itself in a pixel counts as hidden there."""


class PaintSlopes:
    """The derivative of pixels by the paints, in the order of `warpvec.polish.variables.Variables` after the points.

    These are colours [N, 3], opacities [N] (always 0 here), background [3], and with gradients their end colours [N, 3]
    and ends [N, 4]. `Stops` follow: inner colours [N, 6, 3], offsets [N, 8], opacities [N, 8] (always 0 here), and the
    breadth [N]. The visible shares of all paths are added one after another.
    """

    def __init__(self, scene: Scene, width: int, pixels: NDArray[np.int64]) -> None:
        self._count, self._width, self._pixels = len(scene), width, pixels
        paints = scene.gradients
        self._kind = np.zeros(len(scene), np.int32) if paints is None else paints.kind.cpu().numpy()
        self._color = scene.color.double().cpu().numpy()
        self._end_color = self._color if paints is None else paints.end_color.double().cpu().numpy()
        self._ends = None if paints is None else paints.whole_geometry.double().cpu().numpy()
        self._stops = None if paints is None or paints.stops is None else stop_rows(scene, paints)
        per_path = 0 if paints is None else 7 + sum(part[0].numel() for part in stop_parts(paints) if len(part))
        self.value_count = (4 + per_path) * len(scene) + 3
        self._seen = 0
        self._at_pixels: list[tuple[Values, _Ramp | None]] = []  # the shares and ramps of each path in ``pixels``
        self._covered: Values | None = None
        self._squares: list[tuple[list[int], Values]] = []  # blocks of the matrix

    def add(self, shares: NDArray[np.float32]) -> None:
        """Add the ``shares`` [n, h w] of the next n paths in all pixels; rows past the last path are left."""
        if self._covered is None:
            self._covered = np.zeros(shares.shape[1])
        for share in shares[: self._count - self._seen].astype(np.float64):
            here = share[self._pixels]
            self._covered += share
            self._at_pixels.append((here, self._ramp_of(self._seen, self._pixels)))
            if self._kind[self._seen] == FLAT:
                square = np.full((1, 1), np.square(share).sum() - np.square(here).sum())
                self._squares += [([3 * self._seen + channel], square) for channel in range(3)]
            else:
                self._add_gradient(self._seen, share)
            self._seen += 1

    def elsewhere(self) -> sparse.csr_matrix:
        """Return the Gauss-Newton matrix [V, V] of the other pixels. It ignores that paths overlap there."""
        squares = list(self._squares)
        if self._covered is not None:
            seen = 1.0 - self._covered
            rest = np.full((1, 1), max(np.square(seen).sum() - np.square(seen[self._pixels]).sum(), 0.0))
            squares += [([4 * self._count + channel], rest) for channel in range(3)]
        rows = [np.repeat(columns, len(columns)) for columns, _ in squares]
        columns = [np.tile(columns, len(columns)) for columns, _ in squares]
        values = [square.ravel() for _, square in squares]
        where = (np.concatenate(rows), np.concatenate(columns))
        return sparse.csr_matrix((np.concatenate(values), where), shape=(self.value_count,) * 2)

    def at_pixels(self, channel: int) -> sparse.csr_matrix:
        """Return the derivative of one channel of ``pixels`` by the paints [P, V]."""
        columns: list[tuple[int, Values]] = []
        for path, (share, ramp) in enumerate(self._at_pixels):
            columns += self._columns(path, channel, share, ramp)
        if self._covered is not None:
            columns.append((4 * self._count + channel, 1.0 - self._covered[self._pixels]))
        found = [(value, *np.nonzero(np.abs(value) > SHARE_MIN)) for _, value in columns]
        indices = [np.full(len(rows), index) for (index, _), (_, rows) in zip(columns, found, strict=True)]
        values = np.concatenate([value[rows] for value, rows in found])
        where = (np.concatenate([rows for _, rows in found]), np.concatenate(indices))
        return sparse.csr_matrix((values, where), shape=(len(self._pixels), self.value_count))

    def nothing(self) -> sparse.csr_matrix:
        """Return the derivative of something that no paint changes, such as alpha [P, V]."""
        return sparse.csr_matrix((len(self._pixels), self.value_count))

    def _add_gradient(self, path: int, share: Values) -> None:
        """Add the block of a gradient in the pixels that no outline crosses."""
        shown = share > SHARE_MIN
        shown[self._pixels] = False
        pixels = np.flatnonzero(shown)
        if not len(pixels):
            return
        ramp = self._ramp_of(path, pixels)
        for channel in range(3):
            found = self._columns(path, channel, share[pixels], ramp)
            slopes = np.stack([value for _, value in found], 1)
            self._squares.append(([index for index, _ in found], slopes.T @ slopes))

    def _columns(self, path: int, channel: int, share: Values, ramp: _Ramp | None) -> list[tuple[int, Values]]:
        """Return which values of the paint of ``path`` change a ``channel`` of some pixels, and how."""
        color = 3 * path + channel
        if ramp is None:
            return [(color, share)]
        first_end_color = 4 * self._count + 3
        if self._stops is not None:
            return self._stop_columns(path, channel, share, ramp, self._stops[path])
        change = share * (self._end_color - self._color)[path, channel]
        first_end = first_end_color + 3 * self._count + GEOMETRY_SIZE * path
        ends = [(first_end + k, change * slope) for k, slope in enumerate(ramp.slopes)]
        return [(color, share * (1.0 - ramp.place)), (first_end_color + color, share * ramp.place), *ends]

    def _stop_columns(
        self, path: int, channel: int, share: Values, ramp: _Ramp, row: StopRow
    ) -> list[tuple[int, Values]]:
        """Return the same of a gradient of several stops."""
        count, slopes = self._count, slopes_of(row, ramp.place)
        end_colors = 4 * count + 3
        ends = end_colors + 3 * count
        inner, last = ends + GEOMETRY_SIZE * count, row.size - 1
        offsets = inner + 3 * (STOPS_MAX - 2) * count
        places = [3 * path + channel, *(inner + inner_color_index(path, stop, channel) for stop in range(1, last))]
        places.append(end_colors + 3 * path + channel)
        found = list(zip(places, share * slopes.weight, strict=True))
        found += [(offsets + STOPS_MAX * path + k, share * slopes.by_offset[k, :, channel]) for k in range(last + 1)]
        change = share * slopes.by_place[:, channel]
        numbers = [*range(ends + GEOMETRY_SIZE * path, ends + GEOMETRY_SIZE * (path + 1))]
        numbers.append(offsets + 2 * STOPS_MAX * count + path)
        return found + [(index, change * slope) for index, slope in zip(numbers, ramp.slopes, strict=True)]

    def _ramp_of(self, path: int, pixels: NDArray[np.int64]) -> _Ramp | None:
        """Return the ramp of ``path`` in the ``pixels``, or None if the path is flat."""
        if self._kind[path] == FLAT or self._ends is None:
            return None
        y, x = np.divmod(pixels, self._width)
        paint, place = kind_of(int(self._kind[path])), (self._ends[path], x + 0.5, y + 0.5)
        share, slopes = paint.share(*place), paint.slopes(*place)
        if self._stops is not None:
            return _Ramp(share, slopes)
        slopes[:, (share <= 0.0) | (share >= 1.0)] = 0.0
        return _Ramp(share.clip(0.0, 1.0), slopes)


class _Ramp(NamedTuple):
    """The share of a gradient at each place [M], from 0 to 1, and its derivative by each of the ends [4, M].

    With `Stops` the share is not limited, and there are five ends.
    """

    place: Values
    slopes: Values
