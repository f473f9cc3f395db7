"""The extent of a layer: its visible area, and the area under higher layers that it may cover."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats, Mask
from warpvec.flat.connected_parts import with_filled_holes
from warpvec.flat.constants.layers import LAYERS
from warpvec.flat.regions.regions import Regions


@dataclass(frozen=True)
class Cover:
    """A layer in a box of pixels around it.

    Attributes:
        coverage: how much of each pixel it covers, where layers above hide it included [h, w].
        shown: how much of each pixel shows it [h, w].
        above: pixels of layers above that hide it [h, w].
        from_out: distance in pixels from what neither shows it nor hides it [h, w].
        corner: x and y of the box in the picture in pixels [2].
    """

    coverage: Floats
    shown: Floats
    above: Mask
    from_out: Floats
    corner: Floats


def cover_of(regions: Regions, members: Collection[int], above: Collection[int]) -> Cover:
    """Return what a shape of the regions ``members`` covers.

    It goes on beneath the regions ``above``, but not close to where these end.
    """
    is_member, is_above = chosen(regions, members), chosen(regions, above)
    visible = is_member[regions.label]
    share = LAYERS.cover_depth_share if is_opaque(regions, members) else 0.0
    depth = max(LAYERS.cover_depth_min, share * float(visible.sum()) ** 0.5)
    margin = int(depth + 2.0 * LAYERS.cover_margin) if above else 2
    reached = visible | is_member[regions.other] if is_lettering(regions, members) else visible
    top, bottom, left, right = _box(reached, margin)
    box = np.s_[top:bottom, left:right]
    part = replace(regions, label=regions.label[box], other=regions.other[box], share=regions.share[box])
    corner = np.array([left, top], np.float64)
    shown, visible, hides = mixed(part, is_member), visible[box], is_above[part.label]
    if not hides.any():
        return Cover(shown, shown, hides, np.full(shown.shape, np.inf), corner)
    height, width = regions.label.shape
    at_border = ((top == 0, bottom == height), (left == 0, right == width))
    from_out = _from_out(hides | visible, at_border)
    hidden = _hidden(visible, hides, from_out, depth)
    beside = visible & ndimage.binary_dilation(hidden, np.ones((3, 3), bool))
    coverage = np.where(hidden | beside, shown + mixed(part, is_above), shown)
    return Cover(coverage, shown, hides, from_out, corner)


def is_lettering(regions: Regions, members: Collection[int]) -> bool:
    """Return whether the regions ``members`` are words of small thin marks."""
    found = regions.lettering_among(list(members))
    return found is not None and bool(found.all())


def is_opaque(regions: Regions, members: Collection[int]) -> bool:
    """Return whether nothing shines through the regions ``members``."""
    return bool((regions.paints.opacity[list(members)] >= 1.0).all())


def chosen(regions: Regions, indices: Collection[int]) -> Mask:
    """Return a mask [K] of the regions with these ``indices``."""
    mask = np.zeros(len(regions), bool)
    mask[list(indices)] = True
    return mask


def mixed(regions: Regions, which: Mask) -> Floats:
    """Return the share [h, w] of regions ``which`` [K] in each pixel."""
    share = regions.share.astype(np.float64)
    return share * which[regions.label] + (1.0 - share) * which[regions.other]


def _box(mask: Mask, margin: int) -> tuple[int, int, int, int]:
    rows, columns = np.nonzero(mask.any(1))[0], np.nonzero(mask.any(0))[0]
    if not len(rows):
        return 0, 1, 0, 1
    top, left = max(0, int(rows[0]) - margin), max(0, int(columns[0]) - margin)
    return top, int(rows[-1]) + 1 + margin, left, int(columns[-1]) + 1 + margin


def _from_out(inside: Mask, at_border: tuple[tuple[bool, bool], tuple[bool, bool]]) -> Floats:
    """Return the distance from what is not ``inside``; beyond the border of the picture, nothing is."""
    padding = [[int(side) for side in sides] for sides in at_border]
    padded = np.pad(inside, padding)
    if padded.all():
        return np.full(inside.shape, np.inf)
    distance = ndimage.distance_transform_edt(padded)
    height, width = inside.shape
    (top, _), (left, _) = padding
    return distance[top : top + height, left : left + width]


def _hidden(visible: Mask, above: Mask, from_out: Floats, depth: float) -> Mask:
    """Return the pixels that a layer covers beneath others."""
    from_visible = ndimage.distance_transform_edt(~visible)
    margin = np.minimum(LAYERS.cover_margin, 1.0 + LAYERS.cover_taper * (from_visible - 1.0))
    hidden = above & (from_out >= margin) & (from_visible <= depth)
    hidden &= _connected(hidden | visible, visible)
    return hidden | _holes(hidden | visible, ~(above | visible))


def _holes(mask: Mask, out: Mask) -> Mask:
    """Return what ``mask`` surrounds, except for holes with anything ``out``."""
    holes = with_filled_holes(mask) & ~mask
    return holes & ~_connected(holes, out)


def _connected(mask: Mask, seeds: Mask) -> Mask:
    """Return the parts of ``mask`` that hold one of ``seeds``."""
    parts, count = ndimage.label(mask)
    keep = np.zeros(count + 1, bool)
    keep[parts[seeds]] = True
    return keep[parts] & mask
