"""Islands in the grounds of a picture: what small marks, such as letters, can be."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy import ndimage

from warpvec.arrays import Floats, Floats32, Integers, Integers32, Mask, Places
from warpvec.flat.constants.lettering import LETTERING
from warpvec.flat.regions.assignment import Assignment
from warpvec.flat.regions.noise import Tolerances
from warpvec.flat.regions.paints import Paints
from warpvec.flat.regions.region_growing import NONE

_EIGHT = np.ones((3, 3), bool)


@dataclass(frozen=True, eq=False)
class Island:
    """Connected pixels that show no ground.

    Attributes:
        pixels: the pixels [n], numbered by rows.
        box: first row, first column, and the last ones [4].
        ground: the ground around; None if there are several.
        is_cut_out: whether it was a part of edges between grounds, and these are left out.
    """

    pixels: Places
    box: Integers
    ground: int | None
    is_cut_out: bool


class Grounds(NamedTuple):
    """The ground [h, w] that each pixel shows, or ``NONE``: that of large regions, and small ones of their paints too.

    The halo of a word may be white as paper, but so may be the ink of another one.
    """

    large: Integers32
    all: Integers32


def find_grounds(picture: Floats32, label: Integers32, paints: Paints, tolerances: Tolerances) -> Grounds:
    """Return the grounds of a picture. Regions of one flat paint are one ground, named by the first of them.

    Args:
        picture: premultiplied RGBA [h, w, 4].
        label: region with the largest share of each pixel [h, w].
        paints: those of the regions.
        tolerances: those of the picture.
    """
    first = paints.first_alike()
    size = np.bincount(label.ravel(), minlength=len(paints))
    largest = np.zeros(len(paints), np.int64)
    np.maximum.at(largest, first, size)
    is_large = size >= LETTERING.ground_area_min
    is_part = (size >= LETTERING.part_area_min) & (largest[first] >= LETTERING.ground_area_min)
    y, x = np.indices(label.shape, np.float32) + np.float32(0.5)
    is_pure = np.abs((picture - paints.at(label, x, y)) @ tolerances.metric).max(-1) <= tolerances.paint
    names = [np.where(chosen, first, NONE).astype(np.int32) for chosen in (is_large, is_part)]
    return Grounds(*(np.where(is_pure, name[label], np.int32(NONE)) for name in names))


def whole_islands(grounds: Grounds) -> tuple[list[Island], Mask]:
    """Return the small islands in one large ground, and the pixels [h, w] of all those in several.

    If there are more than ``LETTERING.islands_max``, there are none of either.
    """
    nowhere = np.zeros(grounds.large.shape, bool)
    return _islands(grounds.large, grounds.large == NONE, nowhere, is_cut_out=False)


def parted_islands(grounds: Grounds, where: Mask, found: Assignment, tolerances: Tolerances) -> list[Island]:
    """Return the small islands in all ``grounds`` that those of the pixels ``where`` [h, w] have in them.

    They are parted along the edges between grounds, which the mix that was ``found`` explains.
    """
    is_edge = where & _is_between_large(found, tolerances)
    islands = _islands(grounds.all, where & (grounds.all == NONE) & ~is_edge, is_edge, is_cut_out=True)[0]
    return [each for each in islands if (each.box[2:] - each.box[:2]).max() >= LETTERING.part_side_min]


def regions_behind(islands: list[Island], label: Integers32, grounds: Integers32) -> list[Integers32]:
    """Return the region behind each pixel [n] of each of the ``islands``: that of the nearest pixel of a ground.

    An island in one ground has regions of that ground behind it, also where another ground is nearer across an edge.
    """
    if not islands:
        return []
    rows, columns = ndimage.distance_transform_edt(grounds == NONE, return_distances=False, return_indices=True)
    found: list[Integers32] = []
    for island in islands:
        place = rows.flat[island.pixels], columns.flat[island.pixels]
        region, is_other = label[place], grounds[place] != island.ground
        if island.ground is not None and is_other.any():
            region[is_other] = island.ground if is_other.all() else region[~is_other][0]
        found.append(region)
    return found


def _islands(
    grounds: Integers32, is_island: Mask, is_edge: Mask, *, is_cut_out: bool
) -> tuple[list[Island], Mask]:  # fmt: skip
    """Return the small islands of ``is_island`` [h, w], and the pixels of those in several grounds.

    If they are cut out, those in several grounds are islands, too.
    """
    parts, count = ndimage.label(is_island, _EIGHT)
    if count > LETTERING.islands_max:
        return [], np.zeros(grounds.shape, bool)
    around = _grounds_around(parts, count, grounds, is_edge)
    is_several = around.first < around.last
    is_open = (around.first <= around.last) & (around.edges <= LETTERING.edge_share_max) & (is_cut_out | ~is_several)
    islands: list[Island] = []
    for number, (rows, columns) in enumerate(ndimage.find_objects(parts), 1):
        if is_open[number] and _is_small(rows, columns, grounds.shape):
            y, x = np.nonzero(parts[rows, columns] == number)
            pixels = np.ravel_multi_index((y + rows.start, x + columns.start), grounds.shape)
            box = np.array([rows.start, columns.start, rows.stop - 1, columns.stop - 1], np.int64)
            ground = None if is_several[number] else int(around.first[number])
            islands.append(Island(pixels, box, ground, is_cut_out))
    return islands, np.zeros(grounds.shape, bool) if is_cut_out else is_several[parts]


class _Around(NamedTuple):
    """What lies around each island [n + 1], numbered from 1.

    Attributes:
        first: the least number of a ground; more than the last if there is none.
        last: the greatest number of a ground.
        edges: share of the pixels around that are edges of grounds.
    """

    first: Integers
    last: Integers
    edges: Floats


def _grounds_around(parts: Integers32, count: int, grounds: Integers32, is_edge: Mask) -> _Around:
    """Return what lies around each of ``count`` islands, of all at once: a mask for each takes minutes if all nest."""
    place, island = _pixels_around(parts)
    is_edge_there, limits = is_edge.flat[place], np.iinfo(np.int64)
    first, last = np.full(count + 1, limits.max), np.full(count + 1, limits.min)
    ground, inside = grounds.flat[place[~is_edge_there]], island[~is_edge_there]
    np.minimum.at(first, inside, ground)
    np.maximum.at(last, inside, ground)
    total = np.bincount(island, minlength=count + 1)
    return _Around(first, last, np.bincount(island, is_edge_there, count + 1) / total.clip(1))


def _pixels_around(parts: Integers32) -> tuple[Places, Integers32]:
    """Return the pixels [m] beside the islands ``parts`` [h, w], numbered by rows, and the island [m] of each.

    A pixel is there once for each of the islands that it is beside.
    """
    place = np.flatnonzero((parts == 0) & (ndimage.maximum_filter(parts, 3) > 0))
    y, x = np.unravel_index(place, parts.shape)
    near = np.sort(sliding_window_view(np.pad(parts, 1), (3, 3))[y, x].reshape(-1, 9), 1)
    is_new = np.diff(near, axis=1, prepend=0) > 0
    return place[np.nonzero(is_new)[0]], near[is_new]


def _is_small(rows: slice, columns: slice, shape: tuple[int, ...]) -> bool:
    """Return whether a box is no larger than a letter, and not at the border of the picture."""
    sides = rows.stop - rows.start, columns.stop - columns.start
    is_inner = rows.start > 0 and columns.start > 0 and rows.stop < shape[0] and columns.stop < shape[1]
    return is_inner and min(sides) <= LETTERING.height_max and max(sides) <= LETTERING.width_max


def _is_between_large(found: Assignment, tolerances: Tolerances) -> Mask:
    """Return the pixels [h, w] that are mixes of two large regions, such as a halo and what is around it."""
    size = np.bincount(found.label.ravel(), minlength=int(found.other.max()) + 1)
    is_large = size >= LETTERING.ground_area_min
    is_explained = found.residual <= tolerances.mix
    return np.asarray(is_explained & is_large[found.label] & is_large[found.other])
