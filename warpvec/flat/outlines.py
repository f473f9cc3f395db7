"""The outlines of a layer: precise where they show, simple where a layer above hides them."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from warpvec.flat.contours import LEVEL, contours_of
from warpvec.flat.hidden_borders import Cover, is_in, with_simple_hidden_borders
from warpvec.flat.regions import Regions
from warpvec.flat.stacking import Layer

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

AREA_MIN = 1.0
"""Area in square pixels of the smallest loop that is kept."""

MARGIN = 2.5
"""Pixels that a layer stays away, beneath another one, from what neither of them covers: its colour would show along
the edge of the upper one."""

TAPER = 0.7
"""Pixels of that margin per pixel from what the layer shows, so that no gap opens where the three meet."""


def outlines(regions: Regions, layer: Layer) -> list[Floats]:
    """Return the closed polylines [n, 2] of ``layer`` in pixels, x right, y down; holes run the other way."""
    from scipy import ndimage

    coverage, cover = layer_coverage(regions, layer)
    loops = [loop for loop in contours_of(coverage) if abs(signed_area(loop)) >= AREA_MIN]
    if not cover.above.any():
        return loops
    shows = ndimage.maximum_filter(mixed(regions, chosen(regions, layer.members)), 3) >= LEVEL
    found = (with_simple_hidden_borders(loop, ~is_in(shows, loop), cover) for loop in loops)
    return [loop for loop in found if abs(signed_area(loop)) >= AREA_MIN]


def signed_area(loop: Floats) -> float:
    """Return the area in square pixels that a polyline [n, 2] encloses; its sign says which way it runs."""
    following = np.roll(loop, -1, axis=0)
    return float((loop[:, 0] * following[:, 1] - loop[:, 1] * following[:, 0]).sum() / 2.0)


def layer_coverage(regions: Regions, layer: Layer) -> tuple[Floats, Cover]:
    """Return how much of each pixel [h, w] a layer covers, what layers above hide included, and these."""
    from scipy import ndimage

    is_member, is_above = chosen(regions, layer.members), chosen(regions, layer.above)
    shown, visible, above = mixed(regions, is_member), is_member[regions.label], is_above[regions.label]
    if not above.any():
        return shown, Cover(visible, above, shown)
    out = np.pad(~(above | visible), 1, constant_values=True)
    from_out = ndimage.distance_transform_edt(~out)[1:-1, 1:-1]
    from_visible = ndimage.distance_transform_edt(~visible)
    hidden = above & (from_out >= np.minimum(MARGIN, 1.0 + TAPER * (from_visible - 1.0)))
    hidden &= _connected(hidden | visible, visible)
    beside = visible & ndimage.binary_dilation(hidden, np.ones((3, 3), bool))
    coverage = np.where(hidden | beside, shown + mixed(regions, is_above), shown)
    return coverage, Cover(visible, above, from_out)


def chosen(regions: Regions, indices: Collection[int]) -> Mask:
    """Return a mask [K] of the regions with these ``indices``."""
    mask = np.zeros(len(regions), bool)
    mask[list(indices)] = True
    return mask


def mixed(regions: Regions, which: Mask) -> Floats:
    """Return the share [h, w] of the ``chosen`` regions [K] in each pixel."""
    share = regions.share.astype(np.float64)
    return share * which[regions.label] + (1.0 - share) * which[regions.other]


def _connected(mask: Mask, seeds: Mask) -> Mask:
    """Return the parts of ``mask`` that hold one of ``seeds``."""
    from scipy import ndimage  # type: ignore[import-untyped]

    parts, count = ndimage.label(mask)
    keep = np.zeros(count + 1, bool)
    keep[parts[seeds]] = True
    return keep[parts] & mask
