"""The largest disks inside a shape that touch its outline at given points: half the width of a stroke, and its centre.

Source: J. Ma, S. W. Bae and S. Choi, "3D medial axis point approximation using nearest neighbors and the normal field"
(2012): a disk that touches a point shrinks until no other point of the outline lies inside.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from warpvec.arrays import Floats, Integers, Mask, counted
from warpvec.flat.constants.strokes import STROKES
from warpvec.flat.simplification.outline_samples import cubic_points, cubic_slopes


class Boundary(NamedTuple):
    """Points along the outline of a shape.

    Attributes:
        points: [K, 2] px.
        inward: unit normals into the shape [K, 2].
        lengths: length of the outline that each stands for [K], in pixels.
    """

    points: Floats
    inward: Floats
    lengths: Floats


class Disks(NamedTuple):
    """The largest disks in a shape that touch each point of its `Boundary`: centres [K, 2] and radii [K]."""

    centers: Floats
    radii: Floats


def boundary_of(control: Floats, area: float) -> Boundary:
    """Return points along the cubics ``control`` [R, 4, 2] of a shape, whose outer loop has the signed ``area``.

    Its holes run the other way round.
    """
    lengths = np.linalg.norm(np.diff(control, axis=1), axis=2).sum(1)
    counts = np.maximum(np.ceil(lengths / STROKES.sample_gap).astype(np.int64), 1)
    row = np.repeat(np.arange(len(control)), counts)
    t = (counted(counts) + 0.5) / counts[row]
    points = cubic_points(control[row], t[:, None])[:, 0]
    slopes = cubic_slopes(control[row], t[:, None])[:, 0]
    speed = np.linalg.norm(slopes, axis=1)
    kept = speed > 1e-6
    points, slopes, speed, row = points[kept], slopes[kept], speed[kept], row[kept]
    unit = slopes / speed[:, None]
    inward = np.stack([-unit[:, 1], unit[:, 0]], 1) * np.sign(area)
    return Boundary(points, inward, speed / counts[row])


def may_have_width(boundary: Boundary) -> bool:
    """Return whether an outline may be that of a stroke, by the disks at some of its points."""
    some = np.arange(0, len(boundary.points), STROKES.glance_gap)
    if len(some) < STROKES.glance_points_min:
        return True
    disks, lengths = inner_disks(boundary, some), boundary.lengths[some]
    return _common_width(disks.radii[some], lengths)[1] >= STROKES.glance_share_min


def inner_disks(boundary: Boundary, at: Integers | None = None) -> Disks:
    """Return the largest disk inside the shape at each point; only those at the points ``at`` [M] if they are given."""
    points, inward = boundary.points, boundary.inward
    tree = cKDTree(points)
    radii = np.full(len(points), float(np.ptp(points, axis=0).max()) / 2.0 + 1.0)
    active = np.arange(len(points)) if at is None else at
    for _ in range(STROKES.disk_rounds):
        centers = points[active] + radii[active, None] * inward[active]
        distance, nearest = tree.query(centers)
        is_inside = distance < radii[active] - np.minimum(STROKES.disk_error * radii[active], STROKES.disk_error_max)
        is_inside &= nearest != active
        active, nearest = active[is_inside], nearest[is_inside]
        if not len(active):
            break
        chord = points[nearest] - points[active]
        ahead = np.maximum((chord * inward[active]).sum(1), 1e-6)
        radii[active] = np.minimum(radii[active] * 0.999, (chord * chord).sum(1) / (2.0 * ahead))
    return Disks(points + radii[:, None] * inward, radii)


def stroke_width(boundary: Boundary, disks: Disks) -> tuple[float, Mask]:
    """Return the width of a stroke of this outline, and the points [K] whose disks have that width exactly.

    The width is the median of those that differ least from it: the most common one. It is 0 if no width is common.
    """
    common, share = _common_width(disks.radii, boundary.lengths)
    error = max(STROKES.center_error * common, STROKES.center_error_min)
    return (common if share >= STROKES.width_share_min else 0.0), np.abs(2.0 * disks.radii - common) <= error


def _common_width(radii: Floats, lengths: Floats) -> tuple[float, float]:
    """Return the most common width of disks of ``radii`` [K], and the share of the ``lengths`` [K] that has it."""
    width = 2.0 * radii
    order = np.argsort(width)
    total = np.cumsum(lengths[order])
    low = np.searchsorted(width[order], width[order] * (1.0 - STROKES.width_error))
    within = total - np.concatenate([[0.0], total])[low]
    best = int(np.argmax(within))
    chosen = order[low[best] : best + 1]
    common = float(np.median(width[chosen]))
    has_width = np.abs(width - common) <= STROKES.width_error * common
    return common, float(lengths[has_width].sum() / max(lengths.sum(), 1e-9))
