"""Grow areas over the pixels on which their smooth shading goes on.

The gradients of a small picture are steep, and its shapes are thin: few squares of pixels in them are pure. From each
such square the shading is followed by a surface through the colours: level, then a plane, then one of the second
degree, each as the pixels so far need it (Besl and Jain 1988).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from warpvec.arrays import Floats, Floats32, Integers32, Mask
from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.regions.region_growing import NONE, without_small
from warpvec.watch.watch import UNWATCHED, Watch


@dataclass(frozen=True, eq=False)
class _Surface:
    """Colours that change smoothly with the place.

    Attributes:
        origin: middle of the places [2].
        scale: half the size of the area in pixels.
        values: coefficients of the terms of `_terms` [T, 4].
    """

    origin: Floats
    scale: float
    values: Floats

    def at(self, points: Floats) -> Floats:
        """Return the colours [N, 4] at ``points`` [N, 2]."""
        return _terms((points - self.origin) / self.scale, len(self.values)) @ self.values


def grow_by_surface(seeds: Integers32, picture: Floats32, watch: Watch = UNWATCHED) -> Integers32:
    """Return the areas ``seeds`` [h, w] grown over the pixels of ``picture`` [h, w, 4], and new ones in what is left.

    The largest area grows first, and takes opaque pixels of those that have not grown yet. ``NONE`` are the pixels of
    no area. When the ``watch`` is over, the others stay as they are.
    """
    labels, is_free = seeds.copy(), picture[..., 3] == 1
    sizes = np.bincount(seeds[seeds != NONE], minlength=seeds.max() + 1)
    for name in np.argsort(-sizes, kind="stable").tolist():
        area = labels == name
        is_opaque = bool((picture[area, 3] == 1).all())
        if watch.is_over() or not is_opaque or area.sum() < REGIONS.clean_seed_area:
            continue
        area = _grown(area, is_free, picture)
        labels[area] = name
        is_free &= ~area
    _add_areas(labels, picture, watch)
    return without_small(labels, 1)


def _add_areas(labels: Integers32, picture: Floats32, watch: Watch) -> None:
    """Write new areas into the opaque pixels of no area in ``labels`` [h, w]: first those that begin with a bend."""
    is_free = (labels == NONE) & (picture[..., 3] == 1)
    for side, count in REGIONS.surface_starts:
        rest = _rest_of_squares(picture, side, count)
        places = np.argsort(rest, axis=None, kind="stable")[: int(np.isfinite(rest).sum())]
        for row, column in np.column_stack(np.divmod(places, max(rest.shape[1], 1))).tolist():
            square = np.s_[row : row + side, column : column + side]
            if watch.is_over() or not is_free[square].all():
                continue
            area = np.zeros_like(is_free)
            area[square] = True
            area = _grown(area, is_free, picture)
            is_free &= ~area
            if area.sum() >= REGIONS.surface_area_min:
                labels[area] = labels.max() + 1


def _rest_of_squares(picture: Floats32, side: int, count: int) -> Floats:
    """Return what surfaces of ``count`` terms leave of the squares of ``side`` pixels of a picture [h, w, 4].

    That is a root mean square [h - side + 1, w - side + 1]. It is infinite where it is too much, or a plane too steep.
    """
    if min(picture.shape[:2]) < side:
        return np.zeros((0, 0))
    squares = np.lib.stride_tricks.sliding_window_view(picture[..., :3].astype(np.float64), (side, side), (0, 1))
    columns, rows = np.meshgrid(*[np.arange(side) - (side - 1) / 2] * 2)
    terms = _terms(np.stack([columns.ravel(), rows.ravel()], 1), count)
    colors = squares.reshape(*squares.shape[:3], side * side)
    values = np.einsum("tn,ijcn->ijct", np.linalg.pinv(terms), colors)
    rest = np.sqrt(((colors - np.einsum("nt,ijct->ijcn", terms, values)) ** 2).mean((2, 3)))
    steepness = np.abs(values[..., 1:3]).max((2, 3))
    limit = np.maximum(REGIONS.start_rest, REGIONS.start_bend * steepness)
    return np.where((rest <= limit) & (steepness <= REGIONS.start_step), rest, np.inf)


def _grown(area: Mask, may_take: Mask, picture: Floats32) -> Mask:
    """Return the ``area`` [h, w] with the pixels that it ``may_take`` [h, w] and that continue its shading."""
    area = area.copy()
    for _ in range(REGIONS.growth_max):
        rows, columns = np.nonzero(ndimage.binary_dilation(area) & ~area & may_take)
        is_small = area.sum() < REGIONS.ramp_area_min
        limit = REGIONS.surface_difference if is_small else REGIONS.paint[0] / 255
        for surface in _surfaces_of(area, picture):
            off = np.abs(picture[rows, columns] - surface.at(_points(rows, columns))).max(1, initial=0.0)
            fits = off <= limit
            if fits.any():
                break
        else:
            break
        area[rows[fits], columns[fits]] = True
    return area


def _surfaces_of(area: Mask, picture: Floats32) -> Iterator[_Surface]:
    """Yield the surfaces that show the colours of an ``area`` [h, w], the plainest first."""
    rows, columns = np.nonzero(area)
    points, colors = _points(rows, columns), picture[rows, columns].astype(np.float64)
    origin, scale = points.mean(0), max(float(np.ptp(points, axis=0).max()) / 2.0, 1.0)
    for count, least in zip((1, 3, 6), REGIONS.surface_areas, strict=True):
        if len(points) < least:
            break
        terms = _terms((points - origin) / scale, count)
        matrix = np.einsum("ni,nj->ij", terms, terms) + 1e-9 * len(points) * np.eye(count)
        values = np.linalg.solve(matrix, np.einsum("ni,nc->ic", terms, colors))
        rest = float(np.sqrt(((colors - terms @ values)[:, :3] ** 2).mean()))
        if rest <= REGIONS.surface_rest:
            yield _Surface(origin, scale, values)


def _terms(points: Floats, count: int) -> NDArray[np.floating[Any]]:
    """Return the first ``count`` terms of the second degree [N, count] at ``points`` [N, 2]."""
    x, y = points.T
    return np.stack([np.ones_like(x), x, y, x * x, x * y, y * y][:count], 1)


def _points(rows: NDArray[np.integer[Any]], columns: NDArray[np.integer[Any]]) -> Floats:
    """Return the places x, y [N, 2] of pixels."""
    return np.stack([columns, rows], 1).astype(np.float64)
