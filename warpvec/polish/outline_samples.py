"""The pixels that the outlines of a drawing cross, and how the winding there changes with the points of a curve."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from warpvec.arrays import Mask
from warpvec.geometry.bezier import whole_curves
from warpvec.geometry.scene import Scene
from warpvec.polish.stroke_samples import stroke_samples

SAMPLE_GAP = 0.35
"""Largest distance of two samples of a curve in pixels, by its control polygon. The matrix that is made of them steers
steps and needs no exact areas: half the gap changes the PSNR after 30 iterations by less than 0.1 dB either way."""

SAMPLES_MIN, SAMPLES_MAX = 4, 4096
"""Fewest samples of a curve, and the most, which bound the work on one wild curve."""


class CrossedPixels(NamedTuple):
    """Pairs of a curve and a pixel that it crosses.

    Attributes:
        row: the segment [M].
        x, y: the pixel [M].
        slopes: change of the winding in the pixel with the coordinates of the curve's four points [M, 8], and with the
            width of its stroke: [M, 9].
    """

    row: NDArray[np.int64]
    x: NDArray[np.int64]
    y: NDArray[np.int64]
    slopes: NDArray[np.float64]


def crossed_pixels(scene: Scene, height: int, width: int, paths: Mask | None = None) -> CrossedPixels:
    """Return the pixels of a canvas that the curves of the cubic ``scene`` cross, or those of some ``paths`` [N].

    A move of the curve by (u, v) changes the winding of a pixel by the integral of (x' v - y' u) dt over the part of
    the curve in the pixel, as in ``kernels/coverage_adjoint.py``; here it is summed over samples.
    """
    path = scene.structure.segment_path.cpu().numpy()
    wanted = np.ones(len(path), np.bool_) if paths is None else paths[path]
    if scene.strokes is None:
        row, place, slopes = _of_fills(scene, wanted)
    else:
        is_stroked = scene.strokes.is_stroked.cpu().numpy()[path]
        parts = zip(_of_fills(scene, wanted & ~is_stroked), _of_strokes(scene, wanted), strict=True)
        row, place, slopes = (np.concatenate(both) for both in parts)
    x, y = np.floor(place).astype(np.int64).T
    kept = (x >= 0) & (x < width) & (y >= 0) & (y < height)
    row, x, y, slopes = row[kept], x[kept], y[kept], slopes[kept]
    if not len(row):
        return CrossedPixels(row, x, y, slopes)
    key = (row * height + y) * width + x
    if scene.strokes is not None:  # the samples of a row are not side by side
        order = np.argsort(key, kind="stable")
        row, x, y, slopes, key = row[order], x[order], y[order], slopes[order], key[order]
    starts = np.flatnonzero(np.diff(key, prepend=key[0] - 1))
    return CrossedPixels(row[starts], x[starts], y[starts], np.add.reduceat(slopes, starts, axis=0))


_Slopes = tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]
"""The segment [M], the place [M, 2] and the slopes [M, 9] of samples."""


def _of_fills(scene: Scene, wanted: Mask) -> _Slopes:
    """Return the samples of the curves that are ``wanted`` [R], as the outlines of fills."""
    rows = np.flatnonzero(wanted)
    curves = whole_curves(scene).double().cpu().numpy()[rows]
    curve, gap, weights, tangents = _samples(curves)
    points = np.einsum("mk,mkd->md", weights, curves[curve])
    return rows[curve], points, _with_width(weights, gap[:, None] * tangents, np.zeros(len(curve)))


def _of_strokes(scene: Scene, wanted: Mask) -> _Slopes:
    """Return the samples of the strokes with the rows that are ``wanted`` [R]."""
    found = stroke_samples(scene)
    by_width = (found.along[:, 0] * found.outward[:, 1] - found.along[:, 1] * found.outward[:, 0]) / 2.0
    kept = wanted[found.row]
    return found.row[kept], found.place[kept], _with_width(found.weights, found.along, by_width)[kept]


def _with_width(
    weights: NDArray[np.float64], along: NDArray[np.float64], by_width: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the slopes [M, 9] of pieces of outlines ``along`` [M, 2] whose points have the ``weights`` [M, 4]."""
    slopes = np.empty((len(weights), 9))
    slopes[:, 0:8:2] = -along[:, 1:] * weights
    slopes[:, 1:8:2] = along[:, :1] * weights
    slopes[:, 8] = by_width
    return slopes


def _samples(
    curves: NDArray[np.float64],
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return samples of ``curves`` [R, 4, 2]: curve [M], parameter gap [M], weights [M, 4] and tangents [M, 2]."""
    lengths = np.linalg.norm(np.diff(curves, axis=1), axis=2).sum(1)
    counts = np.clip(np.ceil(lengths / SAMPLE_GAP), SAMPLES_MIN, SAMPLES_MAX).astype(np.int64)
    row = np.repeat(np.arange(len(curves)), counts)
    first = np.repeat(np.cumsum(counts) - counts, counts)
    gap = 1.0 / counts[row]
    t = (np.arange(len(row)) - first + 0.5) * gap
    s = 1.0 - t
    weights = np.stack([s**3, 3 * s * s * t, 3 * s * t * t, t**3], 1)
    sides = 3 * np.diff(curves, axis=1)[row]
    tangents = np.einsum("mk,mkd->md", np.stack([s * s, 2 * s * t, t * t], 1), sides)
    return row, gap, weights, tangents
