"""Find what covers a ground by where the ground ends: the area that it reaches through smooth changes.

A shadow fades into its ground without an edge, so that the ground *reaches* it pixel by pixel. Shapes have edges, so
that the ground ends there: at a figure of many gradients, or at a card of the colour of the ground itself.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from warpvec.arrays import Floats, Mask
from warpvec.flat.constants.softness import SOFTNESS
from warpvec.flat.softness.grounds import Ground, bends
from warpvec.image.spread import largest_channel


def find_covering(levels: Floats, ground: Ground, bend_max: float) -> tuple[Mask, Ground] | None:
    """Return what covers a ``ground`` [h, w], without its edges, and the ground without it; None if nothing does.

    Args:
        levels: the picture [h, w, C].
        ground: what a shadow would lie on.
        bend_max: largest second difference in levels where there is no edge.
    """
    if levels.shape[2] > 3:
        opaque = ground.region & (largest_channel(levels[..., 3:] - levels[..., :3]) < 0.5)
        return (opaque, ground) if opaque.any() else None
    smooth = bends(levels) <= bend_max
    reached = _reached(smooth, ground.area & ground.region, ground)
    reached = _reached(smooth, reached | _gaps(ground.is_seen & ~reached, reached & ~ground.is_seen), ground)
    covered = ground.region & ~reached
    pure = ndimage.binary_erosion(covered, iterations=2, border_value=1) & ground.region
    labels, count = ndimage.label(pure)
    is_large = np.bincount(labels.ravel(), minlength=count + 1) >= SOFTNESS.speck_area
    is_large[0] = False
    pure = is_large[labels]
    return (pure, replace(ground, is_seen=ground.is_seen & ~covered)) if pure.any() else None


def soft_zone(levels: Floats, ground: Ground) -> Mask:
    """Return what the ground reaches through smooth changes and is not of its colour [h, w]."""
    smooth = bends(levels) <= SOFTNESS.jump
    return _reached(smooth, ground.is_seen, ground) & ~ground.is_seen


def split_parts(levels: Floats, ground: Ground, soft: Mask) -> Iterator[Ground]:
    """Yield the parts of a ``ground`` around each of several shapes whose ``soft`` zones [h, w] meet.

    Their shadows may have colours of their own, as the glows of two buttons have.
    """
    covering = find_covering(levels, ground, SOFTNESS.edge_bends[0])
    if covering is None:
        return
    shapes, count = ndimage.label(ndimage.binary_dilation(covering[0], iterations=2), np.ones((3, 3)))
    if 1 < count <= SOFTNESS.things_max:
        yield from ground.parts(soft & _of_several(shapes, ground.things()), shapes)


def _of_several(shapes: NDArray[np.int32], things: NDArray[np.int32]) -> Mask:
    """Return the pixels of the ``things`` [h, w] that hold more than one of the ``shapes`` [h, w]."""
    pairs = np.unique(np.stack([things[shapes > 0], shapes[shapes > 0]], 1), axis=0)
    counts = np.bincount(pairs[:, 0], minlength=int(things.max()) + 1)
    counts[0] = 0
    several: Mask = (counts > 1)[things]
    return several


def _reached(smooth: Mask, start: Mask, ground: Ground) -> Mask:
    """Return what the pixels of ``start`` [h, w] reach through ``smooth`` pixels of a ground's region [h, w]."""
    found: Mask = ndimage.binary_propagation(start, mask=(smooth | start) & ground.region)
    return found


def _gaps(alone: Mask, soft: Mask) -> Mask:
    """Return the areas that show the ground through a hole [h, w], of those that lie ``alone`` [h, w].

    Around the others is a ``soft`` zone [h, w]: they are shapes of the colour of the ground, that cast a shadow.
    """
    labels, count = ndimage.label(alone)
    if not count:
        return alone
    nearest, (y, x) = ndimage.distance_transform_edt(~alone, return_indices=True)
    owner = labels[y, x]
    is_ring = (nearest > SOFTNESS.ring_from) & (nearest <= SOFTNESS.ring_to)
    all_around = np.bincount(owner[is_ring], minlength=count + 1)
    soft_around = np.bincount(owner[is_ring & soft], minlength=count + 1)
    is_gap = soft_around < SOFTNESS.ring_share * np.maximum(all_around, 1)
    is_gap[0] = False
    gaps: Mask = is_gap[labels]
    return gaps
