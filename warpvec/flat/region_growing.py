"""Connected areas of pure pixels: those that no edge touches."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float32]
Integers = NDArray[np.int32]

NONE = -1
"""Label of a pixel that belongs to no region yet."""


def neighbour_differences(picture: Floats) -> tuple[Floats, Floats]:
    """Return the largest difference of a channel to the pixel at the right [h, w - 1] and to that below [h - 1, w]."""
    right = np.abs(np.diff(picture, axis=1)).max(-1)
    below = np.abs(np.diff(picture, axis=0)).max(-1)
    return right, below


def grow_seeds(picture: Floats, step: float) -> Integers:
    """Return connected areas of pixels [h, w] that differ from all four neighbours by at most ``step``, or ``NONE``.

    The pixels of an edge do so along the edge, but not across it.
    """
    right, below = (difference <= step for difference in neighbour_differences(picture))
    interior = np.ones(picture.shape[:2], bool)
    interior[:, 1:] &= right
    interior[:, :-1] &= right
    interior[1:] &= below
    interior[:-1] &= below
    return connected_areas(interior)


def connected_areas(mask: NDArray[np.bool_]) -> Integers:
    """Return numbers from 0 of the areas of ``mask`` [h, w] connected by pixel sides, and ``NONE`` elsewhere."""
    from scipy import ndimage

    labels, _ = ndimage.label(mask)
    return (labels - 1).astype(np.int32)


def without_small(labels: Integers, area_min: float) -> Integers:
    """Return ``labels`` [h, w], numbered anew, without the areas of fewer than ``area_min`` pixels."""
    area = np.bincount(labels[labels >= 0], minlength=labels.max() + 1)
    is_kept = area >= area_min
    number = np.append(np.where(is_kept, np.cumsum(is_kept) - 1, NONE), NONE)
    return number[labels].astype(np.int32)
