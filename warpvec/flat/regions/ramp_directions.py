"""Along which lines or around which centre the colours of an area change."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec.geometry.gradients import LINEAR, RADIAL

Floats = NDArray[np.floating[Any]]

BLOCKS_ACROSS = 10
"""Blocks across an area, in which the slope of its colours is measured."""

BLOCK_MIN, BLOCK_MAX = 3, 16
"""Sides of a block in pixels: smaller ones show nothing but rounding, larger ones hide curvature."""

BLOCK_FILL = 0.6
"""Part of a block that lies in the area at least, so that its slope is certain."""

PROFILE_BINS = 32
"""Places at which the colours along a ramp are averaged while its direction is refined."""

REFINEMENTS = 5
"""Steps of Gauss and Newton on the direction or centre. They converge in three."""

FAR = 20.0
"""A centre farther from an area than this multiple of its size is that of a linear ramp."""


@dataclass(frozen=True, eq=False)
class Direction:
    """A field of places along a ramp: distances in pixels from a line (linear) or from a centre (radial).

    Attributes:
        kind: ``LINEAR`` or ``RADIAL``.
        origin: the point x, y where the place is 0 [2].
        along: unit vector in which places of a linear ramp grow [2]; unused for radial ones.
    """

    kind: int
    origin: Floats
    along: Floats

    def places(self, points: Floats) -> Floats:
        """Return the places [N] of ``points`` [N, 2]."""
        offset = points - self.origin
        places: Floats = offset @ self.along if self.kind == LINEAR else np.hypot(offset[:, 0], offset[:, 1])
        return places


def directions_of(points: Floats, colors: Floats) -> list[Direction]:
    """Return a linear and, unless its centre is far, a radial direction of the colours [N, D] of an area.

    Both come from the slopes of the colours in blocks of the area; none is returned if no block is filled.
    """
    centers, slopes = block_slopes(points, colors)
    if len(centers) == 0:
        return []
    tensor = np.einsum("bcx,bcy->xy", slopes, slopes)
    directions = [Direction(LINEAR, points.mean(0), np.linalg.eigh(tensor)[1][:, 1])]
    center = _center(centers, slopes)
    extent = np.ptp(points, axis=0).max() + 1
    if center is not None and np.abs(center - points.mean(0)).max() <= FAR * extent:
        directions.append(Direction(RADIAL, center, np.zeros(2)))
    return directions


def block_slopes(points: Floats, colors: Floats) -> tuple[Floats, Floats]:
    """Return the centres [B, 2] and slopes [B, D, 2] of planes through the colours in square blocks."""
    side = int(np.clip(np.sqrt(len(points)) / BLOCKS_ACROSS, BLOCK_MIN, BLOCK_MAX))
    cell = ((points - points.min(0)) // side).astype(np.int64)
    number = cell[:, 1] * (cell[:, 0].max() + 1) + cell[:, 0]
    _, number, count = np.unique(number, return_inverse=True, return_counts=True)
    is_full = count >= BLOCK_FILL * side**2

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
    center: Floats = np.linalg.solve(matrix, (rows * values[:, None]).sum(0))
    return center


def refined(direction: Direction, points: Floats, colors: Floats) -> Direction:
    """Return ``direction`` changed so that pixels of one place show one colour, by least squares."""
    for _ in range(REFINEMENTS):
        places = direction.places(points)
        profile, slope = _profile(places, colors)
        change = _place_changes(direction, points, places)
        rows = (slope[:, :, None] * change[:, None, :]).reshape(-1, change.shape[1])
        direction = _moved(direction, _least_squares(rows, (colors - profile).ravel()))
    return direction


def _least_squares(rows: Floats, values: Floats) -> Floats:
    """Solve ``rows`` [N, P] x = ``values`` [N] by sums of NumPy, which are the same for any number of threads."""
    matrix = (rows[:, :, None] * rows[:, None, :]).sum(0)
    matrix += 1.0e-9 * np.trace(matrix) * np.eye(len(matrix)) + 1.0e-12 * np.eye(len(matrix))
    solution: Floats = np.linalg.solve(matrix, (rows * values[:, None]).sum(0))
    return solution


def _profile(places: Floats, colors: Floats) -> tuple[Floats, Floats]:
    """Return the mean colours [N, D] at ``places`` [N] and how they change per pixel [N, D]."""
    knots, means = binned(places, colors, PROFILE_BINS)[:2]
    slopes = np.gradient(means, knots, axis=0) if len(knots) > 1 else np.zeros_like(means)
    columns = range(colors.shape[1])
    profile = np.stack([np.interp(places, knots, means[:, column]) for column in columns], 1)
    return profile, np.stack([np.interp(places, knots, slopes[:, column]) for column in columns], 1)


def binned(places: Floats, colors: Floats, bins: int) -> tuple[Floats, Floats, Floats]:
    """Return the mean places [B], mean colours [B, D] and counts [B] of the bins that are not empty."""
    start, extent = places.min(), max(float(np.ptp(places)), 1.0e-6)
    number = np.minimum(((places - start) / extent * bins).astype(np.int64), bins - 1)
    count = np.bincount(number, minlength=bins)
    filled = count > 0
    divisor = np.maximum(count, 1)
    means = np.stack([np.bincount(number, column, bins) / divisor for column in colors.T], 1)
    return (np.bincount(number, places, bins) / divisor)[filled], means[filled], count[filled].astype(float)


def _place_changes(direction: Direction, points: Floats, places: Floats) -> Floats:
    """Return how the places [N] change with the parameters of the direction [N, P]: an angle, or a centre."""
    offset = points - direction.origin
    if direction.kind == LINEAR:
        across = np.array([-direction.along[1], direction.along[0]])
        return (offset @ across)[:, None]
    return -offset / np.maximum(places, 1.0)[:, None]


def _moved(direction: Direction, step: Floats) -> Direction:
    if direction.kind == RADIAL:
        return Direction(RADIAL, direction.origin + step, direction.along)
    angle = float(np.clip(step[0], -0.5, 0.5)) + np.arctan2(direction.along[1], direction.along[0])
    return Direction(LINEAR, direction.origin, np.array([np.cos(angle), np.sin(angle)]))
