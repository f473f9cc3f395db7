"""Find what a shadow may lie on: an area of one colour, or of a gradient along a line.

*Plateaus* are the connected areas of a picture whose colour hardly changes from pixel to pixel; in *even* areas it
changes steadily.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from warpvec.arrays import Floats, Mask
from warpvec.flat.connected_parts import with_filled_holes
from warpvec.flat.constants.softness import SOFTNESS
from warpvec.flat.softness.shaded_grounds import fit_shaded_ground
from warpvec.image.spread import largest_channel, spread


@dataclass(frozen=True)
class Ground:
    """What a shadow lies on, in levels.

    Attributes:
        color: its middle colour [C].
        below: its colour at each pixel [h, w, C], also where something hides it.
        is_flat: whether it has one colour.
        area: the plateau or the even area that it was measured in [h, w].
        is_seen: where the picture shows it [h, w], in its region.
        region: where it can lie [h, w]: everywhere, or in a shape of the drawing.
        is_part: whether it is what lies around one of several things.
    """

    color: Floats
    below: Floats
    is_flat: bool
    area: Mask
    is_seen: Mask
    region: Mask
    is_part: bool = False

    @property
    def deviation(self) -> Floats | None:
        """How far its colour is from the middle one [h, w, C]; None if it has one colour."""
        return None if self.is_flat else self.below - self.color

    def things(self) -> NDArray[np.int32]:
        """Return the number of the thing that lies on it at each pixel [h, w], with its shadow; 0 for none."""
        return ndimage.label(self.region & ~self.is_seen, np.ones((3, 3)))[0].astype(np.int32)

    def parts(self, soft: Mask, things: NDArray[np.int32]) -> Iterator[Ground]:
        """Yield the ground around each of the ``things`` [h, w] with a ``soft`` zone [h, w], the largest first.

        Each may have a shadow of its own. The parts meet halfway between the things. There are none if it is only one
        thing.
        """
        count = int(things.max())
        if count < 2:
            return
        nearest = ndimage.distance_transform_edt(things == 0, return_distances=False, return_indices=True)
        owner = things[tuple(nearest)]
        sizes, soft_sizes = (np.bincount(owner[each], minlength=count + 1)[1:] for each in (things > 0, soft))
        areas = np.bincount(owner[self.region], minlength=count + 1)[1:]
        is_large = (soft_sizes >= SOFTNESS.zone_area) & (areas >= SOFTNESS.part_share * owner.size)
        large = [k + 1 for k in np.argsort(-sizes, kind="stable") if is_large[k]]
        if len(large) > SOFTNESS.things_max:
            return
        for number in large:
            region = self.region & (owner == number)
            is_seen = self.is_seen & region
            if is_seen.sum() >= SOFTNESS.part_seen * region.sum():
                yield replace(self, is_seen=is_seen, region=region, is_part=True)


@dataclass(frozen=True)
class Parts:
    """The still areas of a picture.

    Attributes:
        number: of the part of each pixel [h, w], from 1 on; 0 for none.
        plateaus: the largest number of a plateau; higher ones are areas with a gradient.
        count: the largest number of all.
    """

    number: NDArray[np.int32]
    plateaus: int
    count: int

    @cached_property
    def seen(self) -> int:
        """How many there are."""
        return int(np.count_nonzero(np.bincount(self.number.ravel())[1:]))


def find_plateaus(levels: Floats) -> tuple[NDArray[np.int32], int]:
    """Return the number of the plateau of each pixel [h, w], from 1 on, 0 for none, and how many plateaus there are."""
    return _labels(spread(levels) <= SOFTNESS.alike)


def find_grounds(levels: Floats, plateaus: NDArray[np.int32], count: int) -> Iterator[Ground]:
    """Yield the grounds on which a shadow may lie, the likeliest first.

    The first is the largest plateau that reaches the border of the picture. Others are the largest even area there and
    inside, if it has a gradient, and the cards inside.
    """
    everywhere = np.ones(plateaus.shape, np.bool_)
    outer, outer_size = _largest(plateaus, count, at_border=True)
    # On a transparent one there is nothing more.
    graded = [] if levels.shape[2] > 3 else _graded_grounds(levels, outer_size)
    if outer_size >= SOFTNESS.ground_share * plateaus.size:
        area = plateaus == outer
        if not any(each.is_seen[area].mean() > SOFTNESS.own_share for each in graded):  # or it is a band of a gradient
            yield _flat(levels, area, everywhere)
    if levels.shape[2] > 3:
        return  # the others are opaque parts of a transparent picture
    yield from graded
    yield from find_cards(levels, plateaus, count, SOFTNESS.plate_share)


def _graded_grounds(levels: Floats, outer_size: int) -> list[Ground]:
    """Return the largest even areas at the border of a picture and inside, if they have a gradient along a line.

    The largest plateau at the border has an ``outer_size`` in pixels.
    """
    found = []
    even, count = _even_areas(levels)
    for at_border in (True, False):
        number, size = _largest(even, count, at_border)
        ground = None
        if size >= SOFTNESS.plate_share * even.size:
            area = even == number
            ground = _graded(levels, area, np.ones_like(area) if at_border else with_filled_holes(area))
        found.append(_shaded(levels, outer_size) if ground is None and at_border else ground)
    return [ground for ground in found if ground is not None]


def _shaded(levels: Floats, outer_size: int) -> Ground | None:
    """Return the ground at the border of a picture with a gradient that is shaded nearly everywhere; None without one.

    Its largest plateau, of an ``outer_size`` in pixels, is but a small part of it.
    """
    even, count = _even_areas(levels, SOFTNESS.edge_bends[0])
    number, size = _largest(even, count, at_border=True)
    if size < SOFTNESS.plate_share * even.size or outer_size >= SOFTNESS.shaded_share * size:
        return None
    area = even == number
    region = with_filled_holes(area)
    below = fit_shaded_ground(levels, area, ndimage.binary_erosion(region & ~area, iterations=2))
    if below is None:
        return None
    is_seen = region & (largest_channel(np.abs(levels - below)) <= SOFTNESS.alike)
    return Ground(np.median(below[area], axis=0), below, False, area, is_seen, region) if is_seen.any() else None


def find_cards(
    levels: Floats, plateaus: NDArray[np.int32], count: int, least_share: float = SOFTNESS.card_share
) -> Iterator[Ground]:
    """Yield the largest plateaus inside a picture that have at least a share of it.

    A shadow on a card may reach its edge.
    """
    left = plateaus.copy()
    bent = bends(levels)
    for _ in range(SOFTNESS.cards_max):
        inner, size = _largest(left, count, at_border=False)
        if size < least_share * plateaus.size:
            return
        area = plateaus == inner
        left[area] = 0
        ground = _flat(levels, area, _card_region(area, bent))
        if ground.is_seen[area].mean() >= SOFTNESS.card_seen:
            yield ground


def _card_region(area: Mask, bent: Floats) -> Mask:
    """Return what an ``area`` [h, w] encloses [h, w], with a shadow that reaches its edge.

    Where the second differences ``bent`` [h, w] are small there is no edge. A shadow is little beside its card.
    """
    own = with_filled_holes(area)
    for bend_max in SOFTNESS.edge_bends:
        reached = with_filled_holes(ndimage.binary_propagation(area, mask=(bent <= bend_max) | area))
        if reached.sum() <= SOFTNESS.card_growth * own.sum():
            return reached
    return own


def find_parts(levels: Floats, plateaus: NDArray[np.int32], count: int) -> Parts:
    """Return the ``count`` plateaus of a picture, and as one part each even area that has not one colour.

    The plateaus in such an area are bands of its gradient.
    """
    even, even_count = _even_areas(levels)
    parts, number = plateaus.copy(), count
    sizes = np.bincount(even.ravel(), minlength=even_count + 1)
    for area, box in enumerate(ndimage.find_objects(even), 1):
        if sizes[area] < SOFTNESS.zone_area:
            continue
        own = even[box] == area
        colors = levels[box][own]
        if (largest_channel(np.abs(colors - np.median(colors, axis=0))) <= SOFTNESS.alike).mean() < SOFTNESS.one_color:
            number += 1
            parts[box][own] = number
    return Parts(parts, count, number)


def bends(levels: Floats) -> Floats:
    """Return the largest second difference of neighbours in a row or a column [h, w], for ``levels`` [h, w, C]."""
    along = (np.abs(ndimage.correlate1d(levels, [1.0, -2.0, 1.0], axis, mode="nearest")) for axis in (0, 1))
    largest: Floats = np.maximum(*map(largest_channel, along))
    return largest


def _labels(mask: Mask) -> tuple[NDArray[np.int32], int]:
    labels, count = ndimage.label(mask)
    return labels.astype(np.int32), int(count)


def _even_areas(levels: Floats, bend_max: float = SOFTNESS.bend_max) -> tuple[NDArray[np.int32], int]:
    """Return the number of the even area of each pixel [h, w], from 1 on, 0 for none, and how many there are."""
    is_even = (bends(levels) <= bend_max) & (spread(levels) <= SOFTNESS.jump)
    return _labels(ndimage.binary_erosion(is_even, border_value=1))


def _largest(labels: NDArray[np.int32], count: int, at_border: bool) -> tuple[int, int]:
    """Return the largest area that does or does not reach the border of the picture, and its size; 0, 0 for none."""
    sizes = np.bincount(labels.ravel(), minlength=count + 1)
    reaches = np.zeros(count + 1, np.bool_)
    reaches[np.concatenate([labels[0], labels[-1], labels[:, 0], labels[:, -1]])] = True
    sizes[reaches != at_border] = 0
    sizes[0] = 0
    number = int(np.argmax(sizes))
    return number, int(sizes[number])


def _flat(levels: Floats, area: Mask, region: Mask) -> Ground:
    color = np.median(levels[area], axis=0)
    below = np.broadcast_to(color, levels.shape)
    is_seen = region & (largest_channel(np.abs(levels - color)) <= SOFTNESS.alike)
    return Ground(color, below, True, area, is_seen, region)


def _graded(levels: Floats, area: Mask, region: Mask) -> Ground | None:
    """Return an even area as the ground if a gradient along a line explains most of it, and one colour does not."""
    rows, columns = np.nonzero(area)
    if len(rows) > SOFTNESS.graded_samples:
        chosen = np.random.default_rng(0).choice(len(rows), SOFTNESS.graded_samples, replace=False)
        rows, columns = rows[chosen], columns[chosen]
    places = np.stack([np.ones(len(rows)), columns, rows], 1)
    colors = levels[rows, columns]
    if (np.abs(colors - np.median(colors, axis=0)).max(1) <= SOFTNESS.alike).mean() >= SOFTNESS.graded_share:
        return None
    is_like = np.ones(len(rows), np.bool_)
    for _ in range(SOFTNESS.graded_rounds):
        slopes = np.linalg.lstsq(places[is_like], colors[is_like], rcond=None)[0]
        rest = np.abs(colors - places @ slopes).max(1)
        is_like = rest <= max(SOFTNESS.alike, float(np.median(rest)))
    if (rest <= SOFTNESS.alike).mean() < SOFTNESS.graded_share:
        return None
    y, x = np.indices(area.shape)
    below = np.clip(np.stack([np.ones(x.shape), x, y], 2) @ slopes, 0.0, 255.0)
    color = np.median(below[rows, columns], axis=0)
    is_seen = region & (largest_channel(np.abs(levels - below)) <= SOFTNESS.alike)
    return Ground(color, below, False, area, is_seen, region)
