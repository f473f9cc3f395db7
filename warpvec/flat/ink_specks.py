"""Which small outlines of ink and of paper are specks: by what lies around them, not by their area alone.

Dots beside thin strokes are commas and umlauts, and the holes of small letters. Dust falls anywhere: where small marks
lie beside strokes no more often than dust would, they are dust, too.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from warpvec.arrays import Floats, Mask
from warpvec.flat.constants.mono import MONO


def specks_among(outlines: Sequence[Floats], areas: Floats, ink: Mask, has_two_levels: bool) -> Mask:
    """Return which of the closed ``outlines`` [n, 2] are specks [L].

    Args:
        outlines: those of all ink, and of the holes in it, in pixels.
        areas: their areas in square pixels [L], without a sign.
        ink: which pixels are ink [h, w].
        has_two_levels: whether the picture has two levels. Then a few small marks that lie alone are meant.
    """
    is_speck = areas < MONO.area_min
    small = np.flatnonzero(is_speck & (areas > MONO.point_area)).tolist()
    if not small:
        return is_speck
    is_near = ndimage.distance_transform_edt(~_edges(ink)) <= MONO.dot_reach
    is_thin = np.minimum(_widest(ink), _widest(~ink)) <= MONO.thin_radius
    column, row = np.array([outlines[k].mean(0) for k in small]).astype(np.int64).T
    row, column = np.minimum(row, ink.shape[0] - 1), np.minimum(column, ink.shape[1] - 1)
    is_beside = is_thin[row, column] & _are_near(
        [outlines[k] for k in small], [outlines[k] for k in np.flatnonzero(~is_speck).tolist()]
    )
    lone_count = int((~is_beside).sum())
    zone = int((is_near & is_thin).sum())
    by_chance = lone_count * zone / max(ink.size - zone, 1)
    if is_beside.sum() > MONO.chance_factor * by_chance:
        is_speck[np.array(small)[is_beside]] = False
    if has_two_levels and lone_count <= MONO.lone_max:
        is_speck[np.array(small)[~is_beside]] = False
    return is_speck


def _edges(ink: Mask) -> Mask:
    """Return the pixels [h, w] of ``ink`` beside paper."""
    return np.asarray(ink & ~ndimage.binary_erosion(ink))


def _widest(mask: Mask) -> Floats:
    """Return the radius of the widest part of ``mask`` [h, w] around each pixel [h, w]; 1 for one or two pixels."""
    return np.asarray(ndimage.maximum_filter(ndimage.distance_transform_edt(mask), 4 * MONO.dot_reach + 1))


def _are_near(small: Sequence[Floats], large: Sequence[Floats]) -> Mask:
    """Return which of the outlines ``small`` [S] are near one of the ``large`` ones."""
    if not large:
        return np.zeros(len(small), bool)
    away = cKDTree(np.concatenate(large)).query(np.array([outline.mean(0) for outline in small]))[0]
    return np.asarray(away <= MONO.dot_reach + 0.5)
