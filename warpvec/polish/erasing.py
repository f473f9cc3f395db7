"""Change a picture as a user has changed its drawing: deleted shapes are filled from around, others are drawn anew."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from warpvec.svg.measure import draw

Pixels = NDArray[np.float32]

MARGIN = 2
"""Pixels around the shapes that are filled too: soft edges still show a little of what was there."""

MARGIN_SHARE = 1.0 / 400.0
"""The same as a share of the longer side: the edges of large photos are softer than those of small ones."""

CHANGED = 3.0 / 255.0
"""Difference of a channel from which on a pixel has been edited: what resvg draws of an unedited shape is the same."""


def hole_of(photo: Pixels, shapes: str) -> NDArray[np.bool_]:
    """Return the pixels [h, w] that ``shapes`` paint, and those next to them.

    Args:
        photo: the picture [h, w, 3 or 4].
        shapes: SVG text with the proportions of the picture.

    Raises:
        InputError: ``shapes`` is not such an SVG.
    """
    height, width = photo.shape[:2]
    margin = max(MARGIN, round(MARGIN_SHARE * max(height, width)))
    return _grown(draw(shapes, width, height, transparent=True)[..., 3] > 0, margin)


def wanted_picture(photo: Pixels, before: str, after: str, hole: NDArray[np.bool_] | None = None) -> Pixels:
    """Return ``photo`` [h, w, 3 or 4] as the drawing ``after`` shows it where that differs from ``before``.

    A fit then compares recoloured and moved shapes with what the user wants, and not with the picture. The ``hole``
    [h, w] of erased shapes stays as it has been filled.

    Raises:
        InputError: one of the drawings is no SVG with the proportions of the picture.
    """
    height, width, channels = photo.shape
    old, new = (draw(text, width, height, transparent=channels == 4) / np.float32(255.0) for text in (before, after))
    changed = _grown(np.abs(new - old).max(-1) > CHANGED, 1)
    if hole is not None:
        changed &= ~hole
    return np.where(changed[..., None], new, photo).astype(np.float32)


def erase(photo: Pixels, hole: NDArray[np.bool_]) -> Pixels:
    """Return ``photo`` [h, w, 3 or 4], in [0, 1], with the ``hole`` [h, w] filled; a hole without a border stays.

    The fill is the smooth one between the colours at its border: each pixel gets the mean of known pixels near it, near
    ones first ("pull-push", Gortler et al., The Lumigraph, 1996).
    """
    if not hole.any() or hole.all():
        return photo
    filled = _fill(photo.astype(np.float32), ~hole)
    return np.where(hole[..., None], filled, photo).astype(np.float32)


def _grown(mask: NDArray[np.bool_], by: int) -> NDArray[np.bool_]:
    """Return ``mask`` with all pixels at most ``by`` rows and columns away."""
    from scipy.ndimage import maximum_filter

    grown: NDArray[np.bool_] = maximum_filter(mask, size=2 * by + 1)
    return grown


def _fill(colors: Pixels, known: NDArray[np.bool_]) -> Pixels:
    """Return ``colors`` [h, w, c] where ``known`` [h, w], and elsewhere the means of coarser and coarser copies."""
    weights = known.astype(np.float32)[..., None]
    if min(weights.shape[:2]) < 2 or known.all():
        mean = (colors * weights).sum((0, 1)) / max(float(weights.sum()), 1e-9)
        return np.where(weights > 0, colors, mean.astype(np.float32))
    coarse, share = _halved(colors * weights), _halved(weights)
    means: Pixels = (coarse / np.maximum(share, 1e-9)).astype(np.float32)
    coarser = _fill(means, share[..., 0] > 0)
    return np.where(weights > 0, colors, _doubled(coarser, *colors.shape[:2]))


def _halved(values: Pixels) -> Pixels:
    """Return the means of blocks of two by two."""
    height, width = values.shape[:2]
    padded = np.pad(values, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")
    blocks = padded.reshape(padded.shape[0] // 2, 2, padded.shape[1] // 2, 2, -1)
    means: Pixels = blocks.mean((1, 3))
    return means


def _doubled(values: Pixels, height: int, width: int) -> Pixels:
    """Return ``values`` at twice their size, interpolated linearly, cut to ``height`` and ``width``."""
    rows, columns = (_places(count, side) for count, side in zip(values.shape[:2], (height, width), strict=True))
    tall = values[rows[0]] * (1 - rows[2][:, None, None]) + values[rows[1]] * rows[2][:, None, None]
    share = columns[2][None, :, None]
    wide = tall[:, columns[0]] * (1 - share) + tall[:, columns[1]] * share
    return wide.astype(np.float32)


def _places(count: int, side: int) -> tuple[NDArray[np.int64], NDArray[np.int64], Pixels]:
    """Return the coarse neighbours, of ``count``, of each of ``side`` fine centres, and the second one's share."""
    place = np.clip((np.arange(side) + 0.5) / 2 - 0.5, 0, count - 1)
    low = np.floor(place).astype(np.int64)
    return low, np.minimum(low + 1, count - 1), (place - low).astype(np.float32)
