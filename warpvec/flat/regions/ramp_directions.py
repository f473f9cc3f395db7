"""Along which lines or around which centre the colours of an area change."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec.arrays import interpolated
from warpvec.flat.constants.regions import REGIONS
from warpvec.geometry.paints.registry import ELLIPTIC, LINEAR, RADIAL

Floats = NDArray[np.floating[Any]]


@dataclass(frozen=True, eq=False)
class LineDirection:
    """Distances from a line.

    Attributes:
        origin: a point x, y of the line [2].
        along: unit vector in which places grow [2].
    """

    origin: Floats
    along: Floats
    kind = LINEAR

    def places(self, points: Floats) -> Floats:
        """Return the distances [N] of ``points`` [N, 2]."""
        return (points - self.origin) @ self.along

    def changes(self, points: Floats, places: Floats) -> Floats:
        """Return how the places change with the angle [N, 1]."""
        across = np.array([-self.along[1], self.along[0]])
        return ((points - self.origin) @ across)[:, None]

    def moved(self, step: Floats) -> Direction:
        """Return the direction turned by the angle ``step`` [1], but by at most half a radian."""
        angle = float(np.clip(step[0], -0.5, 0.5)) + np.arctan2(self.along[1], self.along[0])
        return LineDirection(self.origin, np.array([np.cos(angle), np.sin(angle)]))

    def geometry(self, start: float, end: float) -> Floats:
        """Return x1, y1, x2, y2 of the gradient between two places."""
        ends: Floats = self.origin + np.array([start, end])[:, None] * self.along
        return ends.ravel()


@dataclass(frozen=True, eq=False)
class CenterDirection:
    """Distances from a centre, the ``origin`` x, y [2]."""

    origin: Floats
    kind = RADIAL

    def places(self, points: Floats) -> Floats:
        """Return the distances [N] of ``points`` [N, 2]."""
        offset = points - self.origin
        return np.hypot(offset[:, 0], offset[:, 1])

    def changes(self, points: Floats, places: Floats) -> Floats:
        """Return how the places change with the centre [N, 2]."""
        return -(points - self.origin) / np.maximum(places, 1.0)[:, None]

    def moved(self, step: Floats) -> Direction:
        """Return the direction with its centre moved by ``step`` [2]."""
        return CenterDirection(self.origin + step)

    def geometry(self, start: float, end: float) -> Floats:
        """Return cx, cy, r, 0 of the gradient to the place ``end``; ``start`` does not count, as it begins at 0."""
        return np.append(self.origin, [end, 0.0])


@dataclass(frozen=True, eq=False)
class EllipseDirection:
    """Distances from a centre in a stretched plane: the root of q . S q, q from the ``origin`` [2] to a place.

    S is [[1 + a, b], [b, 1 - a]] with the ``stretch`` a, b [2], of a length below 1.
    """

    origin: Floats
    stretch: Floats
    kind = ELLIPTIC

    def places(self, points: Floats) -> Floats:
        """Return the distances [N] of ``points`` [N, 2]."""
        offset = points - self.origin
        return np.sqrt(((offset @ self._matrix()) * offset).sum(1))

    def changes(self, points: Floats, places: Floats) -> Floats:
        """Return how the places change with the centre and the stretch [N, 4]."""
        offset, root = points - self.origin, np.maximum(places, 1.0)[:, None]
        x, y = offset[:, :1], offset[:, 1:]
        return np.hstack([-(offset @ self._matrix()), 0.5 * (x * x - y * y), x * y]) / root

    def moved(self, step: Floats) -> Direction:
        """Return the direction with its centre and its stretch changed by ``step`` [4]."""
        stretch = self.stretch + step[2:]
        stretch *= min(1.0, REGIONS.ellipse_stretch_max / max(float(np.hypot(*stretch)), 1e-9))
        return EllipseDirection(self.origin + step[:2], stretch)

    def geometry(self, start: float, end: float) -> Floats:
        """Return cx, cy, the axis and the radius across it of the gradient to the place ``end``."""
        values, vectors = np.linalg.eigh(self._matrix())
        return np.concatenate([self.origin, vectors[:, 0] * end / np.sqrt(values[0]), [end / np.sqrt(values[1])]])

    def _matrix(self) -> Floats:
        a, b = self.stretch
        return np.array([[1.0 + a, b], [b, 1.0 - a]])


Direction = LineDirection | CenterDirection | EllipseDirection
"""A field of places along a ramp, in pixels. A gradient of its ``kind`` shows it."""


def directions_of(points: Floats, colors: Floats) -> list[Direction]:
    """Return a linear and, unless its centre is far, a radial and an elliptic direction of the colours [N, D].

    All come from the slopes of the colours in blocks of the area; none is returned if no block is filled.
    """
    return directions_from(points, *block_slopes(points, colors))


def directions_from(points: Floats, centers: Floats, slopes: Floats) -> list[Direction]:
    """Return the directions of pixels ``points`` [N, 2] with these ``slopes`` [B, D, 2] about ``centers`` [B, 2]."""
    if len(centers) == 0:
        return []
    tensor = np.einsum("bcx,bcy->xy", slopes, slopes)
    directions: list[Direction] = [LineDirection(points.mean(0), np.linalg.eigh(tensor)[1][:, 1])]
    center = _center(centers, slopes)
    extent = np.ptp(points, axis=0).max() + 1
    if center is not None and np.abs(center - points.mean(0)).max() <= REGIONS.center_far * extent:
        directions.append(CenterDirection(center))
    ellipse = _ellipse(centers, slopes)
    if ellipse is not None and np.abs(ellipse.origin - points.mean(0)).max() <= REGIONS.center_far * extent:
        directions.append(ellipse)
    elif len(directions) > 1:
        directions.append(EllipseDirection(directions[1].origin, np.zeros(2)))
    return directions


def block_slopes(points: Floats, colors: Floats) -> tuple[Floats, Floats]:
    """Return the centres [B, 2] and slopes [B, D, 2] of planes through the colours in square blocks."""
    side = int(np.clip(np.sqrt(len(points)) / REGIONS.blocks_across, REGIONS.block_min, REGIONS.block_max))
    cell = ((points - points.min(0)) // side).astype(np.int64)
    number = cell[:, 1] * (cell[:, 0].max() + 1) + cell[:, 0]
    _, number, count = np.unique(number, return_inverse=True, return_counts=True)
    is_full = count >= REGIONS.block_fill * side**2

    def means(values: Floats) -> Floats:
        return np.bincount(number, values) / count

    centers = np.stack([means(points[:, axis]) for axis in (0, 1)], 1)
    x, y = (points - centers[number]).T
    xx, xy, yy = means(x * x), means(x * y), means(y * y)
    determinant = xx * yy - xy * xy
    is_full &= determinant > 0
    divisor = np.where(is_full, determinant, 1.0)
    slopes = []
    for channel in colors.T:
        xc, yc = means(x * channel), means(y * channel)
        slopes.append(np.stack([(xc * yy - yc * xy) / divisor, (yc * xx - xc * xy) / divisor], -1))
    return centers[is_full], np.stack(slopes, 1)[is_full]


def _center(centers: Floats, slopes: Floats) -> Floats | None:
    """Return the point [2] that all slopes point to or from, by least squares, or None."""
    x, y = centers[:, None, 0], centers[:, None, 1]
    rows = np.stack([slopes[..., 1], -slopes[..., 0]], -1).reshape(-1, 2)
    values = (slopes[..., 1] * x - slopes[..., 0] * y).ravel()
    matrix = (rows[:, :, None] * rows[:, None, :]).sum(0)
    if np.linalg.cond(matrix) > 1.0e6:
        return None
    return np.linalg.solve(matrix, (rows * values[:, None]).sum(0))


def _ellipse(centers: Floats, slopes: Floats) -> EllipseDirection | None:
    """Return the ellipses across which all slopes lie, by least squares, or None if these are no ellipses.

    A slope g at p lies across the ellipse about c if it is along S (p - c). That is linear in S and S c.
    """
    x, y = centers[:, None, 0], centers[:, None, 1]
    gx, gy = slopes[..., 0], slopes[..., 1]
    scale = max(float(np.ptp(centers, axis=0).max()), 1.0)
    middle = centers.mean(0)
    u, v = (x - middle[0]) / scale, (y - middle[1]) / scale
    rows = np.stack([gy * u, gy * v - gx * u, -gx * v, -gy, gx], -1).reshape(-1, 5)
    xx, xy, yy, kx, ky = np.linalg.eigh((rows[:, :, None] * rows[:, None, :]).sum(0))[1][:, 0]
    trace, determinant = xx + yy, xx * yy - xy * xy
    if determinant <= 1e-4 * trace * trace:
        return None
    center = np.linalg.solve(np.array([[xx, xy], [xy, yy]]), np.array([kx, ky]))
    stretch = np.array([(xx - yy) / trace, 2.0 * xy / trace])
    return EllipseDirection(middle + scale * center, stretch)


def refined(direction: Direction, points: Floats, colors: Floats) -> Direction:
    """Return ``direction`` changed so that pixels of one place show one colour, by least squares."""
    for _ in range(REGIONS.ellipse_refinements if direction.kind == ELLIPTIC else REGIONS.refinements):
        places = direction.places(points)
        profile, slope = _profile(places, colors)
        change = direction.changes(points, places)
        rows = (slope[:, :, None] * change[:, None, :]).reshape(-1, change.shape[1])
        direction = direction.moved(_least_squares(rows, (colors - profile).ravel()))
    return direction


def _least_squares(rows: Floats, values: Floats) -> Floats:
    """Solve ``rows`` [N, P] x = ``values`` [N] by sums of NumPy, which are the same for any number of threads."""
    matrix = (rows[:, :, None] * rows[:, None, :]).sum(0)
    matrix += 1.0e-9 * np.trace(matrix) * np.eye(len(matrix)) + 1.0e-12 * np.eye(len(matrix))
    return np.linalg.solve(matrix, (rows * values[:, None]).sum(0))


def _profile(places: Floats, colors: Floats) -> tuple[Floats, Floats]:
    """Return the mean colours [N, D] at ``places`` [N] and how they change per pixel [N, D]."""
    knots, means = binned(places, colors, REGIONS.profile_bins)[:2]
    slopes = np.gradient(means, knots, axis=0) if len(knots) > 1 else np.zeros_like(means)
    return interpolated(places, knots, means), interpolated(places, knots, slopes)


def unevenness(direction: Direction, points: Floats, colors: Floats) -> float:
    """Return the root mean square by which the colours [N, D] of one place along ``direction`` differ."""
    bins = int(np.clip(len(points) // REGIONS.bin_area, 1, REGIONS.profile_bins))
    places = direction.places(points)
    knots, means, _ = binned(places, colors, bins)
    profile = interpolated(places, knots, means)
    return float(np.sqrt(((colors - profile) ** 2).sum() / ((len(points) - bins + 1) * colors.shape[1])))


def binned(places: Floats, colors: Floats, bins: int) -> tuple[Floats, Floats, Floats]:
    """Return the mean places [B], mean colours [B, D] and counts [B] of the bins that are not empty."""
    start, extent = places.min(), max(float(np.ptp(places)), 1.0e-6)
    number = np.minimum(((places - start) / extent * bins).astype(np.int64), bins - 1)
    count = np.bincount(number, minlength=bins)
    filled = count > 0
    divisor = np.maximum(count, 1)
    means = np.stack([np.bincount(number, column, bins) / divisor for column in colors.T], 1)
    return (np.bincount(number, places, bins) / divisor)[filled], means[filled], count[filled].astype(float)
