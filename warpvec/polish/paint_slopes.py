"""The derivatives of pixels by the paints of a drawing: colours, the background, stops and ends of gradients."""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from warpvec.arrays import Mask, counted
from warpvec.geometry.paints.kind import GEOMETRY_SIZE
from warpvec.geometry.paints.registry import FLAT, kind_of
from warpvec.geometry.scene import Scene
from warpvec.geometry.stops import STOPS_MAX
from warpvec.kernels.constants import TILE
from warpvec.kernels.pixel_weights import SHARE_MIN
from warpvec.polish.normal_matrix import TILE_PIXELS
from warpvec.polish.stop_slopes import StopSlopes, inner_color_index, slopes_of, stop_rows
from warpvec.polish.stop_variables import stop_parts
from warpvec.rendering.stages.pixel_slopes import HitSlopes

Values = NDArray[np.float64]

LATTICES, LATTICE_PIXELS_MIN = ((5, 2), (13, 5), (29, 12), (61, 11)), 1000
"""Steps and shifts of lattices, and the fewest pixels of a gradient on one. One pixel in a step is kept, and stands for
the others; the largest step that keeps so many is taken. Gradients change slowly, and the matrix only steers steps."""


class PaintSlopes:
    """The derivative of pixels by the paints, in the order of `warpvec.polish.variables.Variables` after the points.

    These are colours [N, 3], opacities [N] (always 0 here), background [3], end colours [N, 3] and ends [N, 4].
    `Stops` follow: inner colours [N, 6, 3], offsets [N, 8], opacities [N, 8] (always 0 here), and the breadth [N].
    The parts of a drawing are added one after another.

    Args:
        scene: the drawing, which has gradients.
        width, height: size of the canvas.
        pixels: the pixels that an outline crosses [P]; see `warpvec.polish.normal_matrix.NormalMatrix`.
        is_free: paths whose gradients count in the other pixels [N]; None for all.
    """

    def __init__(
        self, scene: Scene, width: int, height: int, pixels: NDArray[np.int64], is_free: Mask | None = None
    ) -> None:
        self._count, self._size, self._pixels = len(scene), (width, height), pixels
        paints = scene.gradients
        assert paints is not None
        self._kind = paints.kind.cpu().numpy()
        self._color = scene.color.double().cpu().numpy()
        self._end_color = paints.end_color.double().cpu().numpy()
        self._ends = paints.whole_geometry.double().cpu().numpy()
        self._is_ramp = (self._kind != FLAT) & (True if is_free is None else is_free)
        self._stops = None if paints.stops is None else stop_rows(scene, paints)
        self._value_count = paint_value_count(scene)
        self._parts: list[_Shares] = []  # of the crossed pixels
        self._squares = np.zeros(len(scene))  # sums of the squared shares elsewhere
        self._blocks: list[tuple[list[int], Values]] = []  # blocks of the matrix, of gradients elsewhere
        self._open = np.ones(len(pixels))  # the share of the background in the crossed pixels
        self._open_squares = 0.0  # the sum of its squares elsewhere

    def add(self, part: HitSlopes) -> None:
        """Add some more tiles."""
        first, last = np.searchsorted(self._pixels, TILE_PIXELS * np.array(part.tiles))
        tile, place = np.divmod(self._pixels[first:last], TILE_PIXELS)
        starts, ends = (np.searchsorted(part.tile, tile, side) for side in ("left", "right"))
        counts = ends - starts
        owner = np.repeat(np.arange(len(tile)), counts)
        hit = starts[owner] + counted(counts)
        shares = part.share.astype(np.float64)  # once: sums that convert what they add take twice as long
        share, path = shares[hit, place[owner]], part.path[hit]
        self._open[first:last] -= np.bincount(owner, share, len(tile))
        whole = np.einsum("hp,hp->h", shares, shares)
        self._squares += np.bincount(part.path, whole, self._count) - np.bincount(path, share * share, self._count)
        shown = share > SHARE_MIN
        self._parts.append(_Shares(first + owner[shown], path[shown], share[shown]))
        self._add_background(part, shares, self._open[first:last])
        is_crossed = np.zeros((part.tiles[1] - part.tiles[0], TILE_PIXELS), np.bool_)
        is_crossed[tile - part.tiles[0], place] = True
        for own in np.unique(part.path[self._is_ramp[part.path]]):
            self._add_gradient(own, part, is_crossed)

    def elsewhere(self, first: int, count: int) -> sparse.csr_matrix:
        """Return the Gauss-Newton matrix of the other pixels. It ignores that paths overlap there.

        It has ``count`` rows and columns; those of the paints begin at ``first``.
        """
        flat = np.flatnonzero(self._kind == FLAT)
        colors = (3 * flat[:, None] + np.arange(3)).ravel()
        background = 4 * self._count + np.arange(3)
        rows, columns = [colors, background], [colors, background]
        values = [np.repeat(self._squares[flat], 3), np.full(3, max(self._open_squares, 0.0))]
        for indices, block in self._blocks:
            rows.append(np.repeat(indices, len(indices)))
            columns.append(np.tile(indices, len(indices)))
            values.append(block.ravel())
        where = (first + np.concatenate(rows), first + np.concatenate(columns))
        return sparse.csr_matrix((np.concatenate(values), where), shape=(count, count))

    def at_pixels(self) -> sparse.csr_matrix:
        """Return the derivative of ``pixels`` by the paints [3 P, V]: first of red, then of green, then of blue."""
        pixel, path, share = self._shares
        flat = self._kind[path] == FLAT
        seen = np.flatnonzero(self._open > SHARE_MIN)
        rows: list[NDArray[np.int64]] = []
        columns: list[NDArray[np.int64]] = []
        values: list[Values] = []
        for channel in range(3):
            first = channel * len(self._pixels)
            rows += [first + pixel[flat], first + seen]
            columns += [3 * path[flat] + channel, np.full(len(seen), 4 * self._count + channel)]
            values += [share[flat], self._open[seen]]
            for own, rows_here, share_here, ramp in self._crossed_ramps:
                for index, value in self._columns(own, channel, share_here, ramp):
                    kept = np.abs(value) > SHARE_MIN
                    rows.append(first + rows_here[kept])
                    columns.append(np.full(int(kept.sum()), index))
                    values.append(value[kept])
        where = (np.concatenate(rows), np.concatenate(columns))
        return sparse.csr_matrix((np.concatenate(values), where), shape=(3 * len(self._pixels), self._value_count))

    @cached_property
    def _shares(self) -> _Shares:
        return _Shares(*(np.concatenate(arrays) for arrays in zip(*self._parts, strict=True)))

    @cached_property
    def _crossed_ramps(self) -> list[tuple[int, NDArray[np.int64], Values, _Ramp]]:
        """Each path with a gradient: the crossed pixels, the path's share in each, and its ramp."""
        pixel, path, share = self._shares
        found = []
        for own in np.unique(path[self._kind[path] != FLAT]).tolist():
            chosen = path == own
            centers = self._centers(self._pixels[pixel[chosen]])
            found.append((own, pixel[chosen], share[chosen], self._ramp_of(own, *centers)))
        return found

    def _add_background(self, part: HitSlopes, shares: Values, crossed: Values) -> None:
        """Add the squared share of the background in the pixels that no outline crosses; paths have ``shares``."""
        count = part.tiles[1] - part.tiles[0]
        tiles = np.arange(*part.tiles)
        width, height = self._size
        columns = -(-width // TILE)
        inside = [
            np.minimum(TILE, side - TILE * index)
            for side, index in ((width, tiles % columns), (height, tiles // columns))
        ]
        is_own, first = np.unique(part.tile, return_index=True)
        covered = np.add.reduceat(shares, first, axis=0) if len(first) else np.zeros((0, 1))
        areas = (inside[0] * inside[1]).astype(np.float64)
        # The sum of (1 - c)^2, as c is 0 outside of the canvas.
        squares = np.bincount(is_own - part.tiles[0], (covered * (covered - 2.0)).sum(1), count) + areas
        self._open_squares += float(squares.sum() - np.square(crossed).sum())

    def _add_gradient(self, path: int, part: HitSlopes, is_crossed: NDArray[np.bool_]) -> None:
        """Add the block of a gradient in the pixels that no outline crosses."""
        hits = np.flatnonzero(part.path == path)
        tile, shares = part.tile[hits], part.share[hits]
        shown = (shares > SHARE_MIN) & ~is_crossed[tile - part.tiles[0]]
        count = int(np.count_nonzero(shown))
        if not count:
            return
        few = self._lattice(tile, shown, count)
        row, place = np.nonzero(few)
        share, each = shares[few].astype(np.float64), count / len(row)
        ramp = self._ramp_of(path, *self._centers(TILE_PIXELS * tile[row] + place))
        for channel in range(3):
            found = self._columns(path, channel, share, ramp)
            slopes = np.stack([value for _, value in found])
            self._blocks.append(([index for index, _ in found], each * np.einsum("im,jm->ij", slopes, slopes)))

    def _lattice(self, tile: NDArray[np.integer[Any]], shown: Mask, count: int) -> Mask:
        """Return which of the ``count`` pixels ``shown`` [H, 256] of some tiles [H] stand for all; see ``LATTICES``."""
        if count < LATTICE_PIXELS_MIN:
            return shown
        step, shift = next((each for each in reversed(LATTICES) if count >= each[0] * LATTICE_PIXELS_MIN), LATTICES[0])
        row, column = np.divmod(tile, -(-self._size[0] // TILE))
        x, y = np.divmod(np.arange(TILE_PIXELS), TILE)
        # How far the lattice has come at the corner of each tile, and at each pixel from there on.
        corner = (TILE * (column + shift * row) % step).astype(np.uint8)
        pixel = ((x + shift * y) % step).astype(np.uint8)
        far = corner[:, None] + pixel
        found: Mask = ((far == 0) | (far == step)) & shown
        return found if found.any() else shown

    def _centers(self, pixels: NDArray[np.int64]) -> tuple[Values, Values]:
        """Return the centres x and y of ``pixels``."""
        tile, place = np.divmod(pixels, TILE_PIXELS)
        row, column = np.divmod(tile, -(-self._size[0] // TILE))
        return TILE * column + place // TILE + 0.5, TILE * row + place % TILE + 0.5

    def _columns(self, path: int, channel: int, share: Values, ramp: _Ramp) -> list[tuple[int, Values]]:
        """Return which values of the gradient of ``path`` change a ``channel`` of some pixels, and how."""
        color = 3 * path + channel
        first_end_color = 4 * self._count + 3
        if ramp.stops is not None:
            return self._stop_columns(path, channel, share, ramp, ramp.stops)
        change = share * (self._end_color - self._color)[path, channel]
        first_end = first_end_color + 3 * self._count + GEOMETRY_SIZE * path
        ends = [(first_end + k, change * slope) for k, slope in enumerate(ramp.slopes)]
        return [(color, share * (1.0 - ramp.place)), (first_end_color + color, share * ramp.place), *ends]

    def _stop_columns(
        self, path: int, channel: int, share: Values, ramp: _Ramp, slopes: StopSlopes
    ) -> list[tuple[int, Values]]:
        """Return the same of a gradient of several stops."""
        count = self._count
        end_colors = 4 * count + 3
        ends = end_colors + 3 * count
        inner, last = ends + GEOMETRY_SIZE * count, len(slopes.weight) - 1
        offsets = inner + 3 * (STOPS_MAX - 2) * count
        places = [3 * path + channel, *(inner + inner_color_index(path, stop, channel) for stop in range(1, last))]
        places.append(end_colors + 3 * path + channel)
        found = list(zip(places, share * slopes.weight, strict=True))
        found += [(offsets + STOPS_MAX * path + k, share * slopes.by_offset[k, :, channel]) for k in range(last + 1)]
        change = share * slopes.by_place[:, channel]
        numbers = [*range(ends + GEOMETRY_SIZE * path, ends + GEOMETRY_SIZE * (path + 1))]
        numbers.append(offsets + 2 * STOPS_MAX * count + path)
        return found + [(index, change * slope) for index, slope in zip(numbers, ramp.slopes, strict=True)]

    def _ramp_of(self, path: int, x: Values, y: Values) -> _Ramp:
        """Return the ramp of ``path``, which has a gradient, at some places."""
        paint, place = kind_of(int(self._kind[path])), (self._ends[path], x, y)
        share, slopes = paint.share(*place), paint.slopes(*place)
        if self._stops is not None:
            return _Ramp(share, slopes, slopes_of(self._stops[path], share))
        slopes[:, (share <= 0.0) | (share >= 1.0)] = 0.0
        return _Ramp(share.clip(0.0, 1.0), slopes)


def paint_value_count(scene: Scene) -> int:
    """Return the number of values of the paints of ``scene``: with or without gradients, and their stops."""
    paints = scene.gradients
    per_path = 0 if paints is None else 7 + sum(part[0].numel() for part in stop_parts(paints) if len(part))
    return (4 + per_path) * len(scene) + 3


class _Shares(NamedTuple):
    """The visible share of paths in crossed pixels: index of the pixel, path, and share, each [M]."""

    pixel: NDArray[np.int64]
    path: NDArray[np.int64]
    share: Values


class _Ramp(NamedTuple):
    """The share of a gradient at each place [M], from 0 to 1, and its derivative by each of the ends [4, M].

    With `Stops` the share is not limited, there are five ends, and ``stops`` are the derivatives by the stops.
    """

    place: Values
    slopes: Values
    stops: StopSlopes | None = None
