"""Marks: islands in one ground whose pixels are mixes of that ground and one ink."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from warpvec.arrays import Floats32, Integers, Integers32, Places
from warpvec.flat.constants.lettering import LETTERING
from warpvec.flat.regions.assignment import Assignment
from warpvec.flat.regions.crossing_marks import CrossingMark
from warpvec.flat.regions.islands import Island, find_grounds, parted_islands, regions_behind, whole_islands
from warpvec.flat.regions.noise import Tolerances
from warpvec.flat.regions.paints import Paints
from warpvec.flat.regions.region_growing import NONE


@dataclass(frozen=True, eq=False)
class Mark:
    """A mark: an island in one ground.

    Attributes:
        island: its pixels [n] and its box.
        ground: region of the ground.
        beside: region of the nearest pixel of the ground for each pixel [n], of the same paint.
        color: mean premultiplied colour of the ground there [4].
        direction: direction of the ink from the ground [4], of length 1.
        height: how far each pixel is from the ground in this direction [n].
        shape: height and width of the picture.
    """

    island: Island
    ground: int
    beside: Integers32
    color: Floats32
    direction: Floats32
    height: Floats32
    shape: tuple[int, int]

    @property
    def pixels(self) -> Places:
        """Its pixels [n], numbered by rows."""
        return self.island.pixels

    @property
    def box(self) -> Integers:
        """First row, first column, and the last ones [4]."""
        return self.island.box

    @cached_property
    def depth(self) -> float:
        """Distance of the purest pixel from the ground."""
        return float(self.height.max())

    @property
    def is_solid(self) -> bool:
        """Whether most of it lies in pixels as pure as its purest one."""
        return not is_thin(self.height / self.depth)

    @cached_property
    def shows_ink(self) -> bool:
        """Whether its purest pixels are of pure ink, as their neighbours tell."""
        least, _ = self._around
        # A line narrower than a pixel may lie evenly between two rows, but not in three.
        return bool((least >= LETTERING.pure_share * self.depth).any()) or self._has_covered_side

    @property
    def _has_covered_side(self) -> bool:
        """Whether a straight stroke fills pixels: it also reaches into their neighbours on both sides."""
        heights = self._heights(1)
        return any(map(self._covers_a_run, (heights, heights.T)))

    def _covers_a_run(self, heights: Floats32) -> bool:
        """Return whether some pixels of a column of ``heights`` [h, w] are pure, with ink in those on both sides."""
        is_purest = heights >= self.depth - LETTERING.pure_difference
        has_ink = heights > LETTERING.side_ink_min * self.depth
        is_filled = is_purest[:, 1:-1] & has_ink[:, :-2] & has_ink[:, 2:]
        if len(is_filled) < LETTERING.covered_run:
            return False
        return bool(sliding_window_view(is_filled, LETTERING.covered_run, axis=0).all(-1).any())

    def _heights(self, margin: int) -> Floats32:
        """Return the heights of its box with a ``margin`` around it; 0 where it has no pixel."""
        rows, columns = np.unravel_index(self.pixels, self.shape)
        heights = np.zeros(self.box[2:] - self.box[:2] + 1 + 2 * margin, np.float32)
        heights[rows - self.box[0] + margin, columns - self.box[1] + margin] = self.height
        return heights

    def shows_two_inks(self, tolerance: float) -> bool:
        """Return whether a pixel is equal to its four neighbours, within ``tolerance``, and less pure than the purest.

        Two shapes of two inks touch there, such as an eye and its brow.
        """
        least, most = self._around
        is_even = most - least <= tolerance
        is_other = (least >= LETTERING.ink_contrast_min) & (most < LETTERING.pure_share * self.depth)
        return bool((is_even & is_other).any())

    @cached_property
    def _around(self) -> tuple[Floats32, Floats32]:
        """The least and the largest height of each inner pixel of its box and its four neighbours."""
        heights = self._heights(1)
        inner = heights[1:-1, 1:-1]
        beside = [heights[:-2, 1:-1], heights[2:, 1:-1], heights[1:-1, :-2], heights[1:-1, 2:]]
        five = np.stack([inner, *beside])
        return five.min(0), five.max(0)

    @property
    def is_weak(self) -> bool:
        """Whether it may have no pure pixel, such as a dot or an l."""
        return int((self.box[2:] - self.box[:2]).min()) < LETTERING.weak_side_max


def find_marks(
    picture: Floats32, found: Assignment, paints: Paints, tolerances: Tolerances
) -> tuple[list[Mark], list[CrossingMark]]:
    """Return the islands in grounds of one paint that are mixes of the ground and one ink, and those in several."""
    grounds = find_grounds(picture, found.label, paints, tolerances)
    islands, others = whole_islands(grounds)
    marks: list[Mark] = []
    for island in islands:
        mark = _mark(island, picture, np.full(len(island.pixels), island.ground, np.int32), paints, tolerances)
        if mark is not None:
            marks.append(mark)
        elif (grounds.all.flat[island.pixels] != NONE).any():
            others.flat[island.pixels] = True
    if not others.any():
        return marks, []
    crossing: list[CrossingMark] = []
    islands = parted_islands(grounds, others, found, tolerances)
    for island, beside in zip(islands, regions_behind(islands, found.label, grounds.all), strict=True):
        if island.ground is None:
            crossing.append(_crossing(island, picture, beside, paints))
        elif (mark := _mark(island, picture, beside, paints, tolerances)) is not None:
            marks.append(mark)
    return marks, crossing


def _colors(island: Island, picture: Floats32, beside: Integers32, paints: Paints) -> tuple[Floats32, Floats32]:
    """Return the premultiplied colours [n, 4] of the pixels of an ``island``, and those of ``beside`` [n] there."""
    y, x = np.unravel_index(island.pixels, picture.shape[:2])
    return picture[y, x], paints.at(beside, x + np.float32(0.5), y + np.float32(0.5))


def _crossing(island: Island, picture: Floats32, beside: Integers32, paints: Paints) -> CrossingMark:
    colors, behind = _colors(island, picture, beside, paints)
    return CrossingMark(island.pixels, beside, behind, colors, island.box)


def _mark(island: Island, picture: Floats32, beside: Integers32, paints: Paints, tolerances: Tolerances) -> Mark | None:
    """Return the mark of an ``island`` in one ground, or None if its pixels are no mixes of one ink.

    Args:
        island: the island, of n pixels.
        picture: premultiplied RGBA [h, w, 4].
        beside: region of the ground for each pixel [n].
        paints: those of the regions.
        tolerances: those of the picture.
    """
    assert island.ground is not None
    colors, behind = _colors(island, picture, beside, paints)
    offset = colors - behind
    if np.abs(offset).max() < LETTERING.ink_contrast_min:
        return None
    direction = (offset * np.linalg.norm(offset, axis=1)[:, None]).sum(0)
    direction /= np.linalg.norm(direction)
    height = offset @ direction
    rest = np.sqrt((((offset - height[:, None] * direction) @ tolerances.metric) ** 2).mean(1))
    is_mix = (rest <= tolerances.mix) & (height >= -tolerances.mix)
    if is_mix.mean() < LETTERING.mix_part:
        return None
    mark = Mark(island, island.ground, beside, behind.mean(0), direction, height, (picture.shape[0], picture.shape[1]))
    return None if mark.shows_two_inks(tolerances.paint) else mark


def is_thin(covered: Floats32, pure_max: float = LETTERING.pure_part_max) -> bool:
    """Return whether at most the share ``pure_max`` of what is ``covered`` [n] lies in pixels of pure ink."""
    return bool(covered[covered >= LETTERING.pure_share].sum() <= pure_max * covered.sum())
