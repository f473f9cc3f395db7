"""Small marks on one paint, such as letters: each pixel of them is a mix of one ink and the ground.

A stroke that is narrower than two pixels may have no pixel of pure ink, and no pixel in which ink has the larger share.
So the marks are found as islands in their ground, whatever their pixels show, and the ink of a word is the purest
colour of all its marks.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats32, Integers, Integers32, Mask, Places
from warpvec.flat.connected_parts import connected_parts
from warpvec.flat.constants.lettering import LETTERING
from warpvec.flat.regions.assignment import Assignment
from warpvec.flat.regions.noise import Tolerances
from warpvec.flat.regions.paint_fitting import flat_paints
from warpvec.flat.regions.paints import Paints
from warpvec.flat.regions.region_growing import NONE, pixels_of
from warpvec.geometry.paints.registry import FLAT


@dataclass(frozen=True, eq=False)
class _Mark:
    """A mark: an island in one ground.

    Attributes:
        pixels: its pixels [n], numbered by rows.
        ground: region of the ground.
        color: mean premultiplied colour of the ground there [4].
        direction: direction of the ink from the ground [4], of length 1.
        height: how far each pixel is from the ground in this direction [n].
        box: first row, first column, and the last ones [4].
        shape: height and width of the picture.
    """

    pixels: Places
    ground: int
    color: Floats32
    direction: Floats32
    height: Floats32
    box: Integers
    shape: tuple[int, int]

    @property
    def depth(self) -> float:
        """Distance of the purest pixel from the ground."""
        return float(self.height.max())

    @property
    def is_solid(self) -> bool:
        """Whether most of it lies in pixels as pure as its purest one."""
        return not _is_thin(self.height / self.depth)

    @property
    def shows_ink(self) -> bool:
        """Whether a pixel is as pure as its purest one with its four neighbours: only whole ink looks so.

        A line narrower than a pixel may lie evenly between two rows, but not in three.
        """
        least, _ = self._around
        return bool((least >= LETTERING.pure_share * self.depth).any())

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
        rows, columns = np.unravel_index(self.pixels, self.shape)
        heights = np.zeros(self.box[2:] - self.box[:2] + 3, np.float32)
        heights[rows - self.box[0] + 1, columns - self.box[1] + 1] = self.height
        inner = heights[1:-1, 1:-1]
        beside = [heights[:-2, 1:-1], heights[2:, 1:-1], heights[1:-1, :-2], heights[1:-1, 2:]]
        five = np.stack([inner, *beside])
        return five.min(0), five.max(0)

    @property
    def is_weak(self) -> bool:
        """Whether it may have no pure pixel, such as a dot or an l."""
        return int((self.box[2:] - self.box[:2]).min()) < LETTERING.weak_side_max


def with_lettering(
    picture: Floats32,
    found: Assignment,
    paints: Paints,
    tolerances: Tolerances,
    area_min: float,
    lone_area_min: float,
) -> tuple[Assignment, Paints, Mask | None]:
    """Return the mix and the paints with a region for each word of small thin marks, and a mask of these regions [K].

    The mask is None if there are none. Of the mix, only the two regions of each pixel and their share are changed.

    Args:
        picture: premultiplied RGBA [h, w, 4].
        found: the mix of regions in each pixel.
        paints: those of the regions.
        tolerances: those of the picture.
        area_min: marks of less ink, in square pixels, are left out: the dot of an i has hardly one.
        lone_area_min: the same for marks that are no part of a word, which may be specks.
    """
    marks = _marks(picture, found.label, paints, tolerances)
    if not 0 < len(marks) <= LETTERING.marks_max:
        return found, paints, None
    result = found.copy()
    words = _words(marks)
    colors: list[Floats32] = []
    for word, ink in zip(words, _inks(words, paints, tolerances), strict=True):
        covered = [np.clip(mark.height / ink.depth, 0.0, 1.0) for mark in word]
        if _is_thin(np.concatenate(covered)):
            least = area_min if len(word) > 1 else lone_area_min
            large = [(mark, part) for mark, part in zip(word, covered, strict=True) if part.sum() >= least]
            for mark, part in large:
                _write(mark, part, len(paints) + len(colors), result)
            colors += [_straight(ink.value)] * bool(large)
    if not colors:
        return found, paints, None
    is_lettering = np.arange(len(paints) + len(colors)) >= len(paints)
    return _compact(result, paints.joined(flat_paints(np.stack(colors))), is_lettering)


def _is_thin(covered: Floats32) -> bool:
    """Return whether most of what is ``covered`` [n] lies in pixels that are not pure ink."""
    return bool(covered[covered >= LETTERING.pure_share].sum() <= LETTERING.pure_part_max * covered.sum())


def _marks(picture: Floats32, label: Integers32, paints: Paints, tolerances: Tolerances) -> list[_Mark]:
    """Return the islands in grounds of one paint that are mixes of the ground and one ink."""
    grounds = _grounds(picture, label, paints, tolerances)
    islands, count = ndimage.label(grounds == NONE, np.ones((3, 3), bool))
    if count > LETTERING.islands_max:
        return []
    height, width = grounds.shape
    marks: list[_Mark] = []
    for number, box in enumerate(ndimage.find_objects(islands), 1):
        rows, columns = box
        sides = rows.stop - rows.start, columns.stop - columns.start
        is_inner = rows.start > 0 and columns.start > 0 and rows.stop < height and columns.stop < width
        if not is_inner or min(sides) > LETTERING.height_max or max(sides) > LETTERING.width_max:
            continue
        around = np.s_[rows.start - 1 : rows.stop + 1, columns.start - 1 : columns.stop + 1]
        inside = islands[around] == number
        beside = np.unique(grounds[around][ndimage.binary_dilation(inside, np.ones((3, 3), bool)) & ~inside])
        if len(beside) != 1 or beside[0] == NONE:
            continue
        y, x = (place - 1 + first for place, first in zip(np.nonzero(inside), (rows.start, columns.start), strict=True))
        behind = paints.at(np.full(len(y), beside[0]), x + np.float32(0.5), y + np.float32(0.5))
        corners = np.array([rows.start, columns.start, rows.stop - 1, columns.stop - 1], np.int64)
        pixels = np.ravel_multi_index((y, x), grounds.shape)
        mark = _mark(picture[y, x], behind, pixels, int(beside[0]), corners, tolerances, (height, width))
        if mark is not None:
            marks.append(mark)
    return marks


def _grounds(picture: Floats32, label: Integers32, paints: Paints, tolerances: Tolerances) -> Integers32:
    """Return the ground [h, w] that each pixel shows, or ``NONE``.

    Regions of one flat paint are one ground, named by the first of them.
    """
    values = np.column_stack([paints.color * paints.opacity[:, None], paints.opacity])
    own = np.where(paints.kind == FLAT, -1, np.arange(len(paints)))
    _, first, same = np.unique(np.column_stack([values, own]), axis=0, return_index=True, return_inverse=True)
    size = np.bincount(label.ravel(), minlength=len(paints))
    name = np.where(size >= LETTERING.ground_area_min, first[same.ravel()], NONE).astype(np.int32)
    y, x = np.indices(label.shape, np.float32) + np.float32(0.5)
    difference = np.abs((picture - paints.at(label, x, y)) @ tolerances.metric).max(-1)
    return np.where(difference <= tolerances.paint, name[label], np.int32(NONE))


def _mark(
    colors: Floats32, behind: Floats32, pixels: Places, ground: int, box: Integers, tolerances: Tolerances,
    shape: tuple[int, int],
) -> _Mark | None:  # fmt: skip
    """Return the mark of ``pixels`` [n], or None if they are no mixes of one ink.

    Args:
        colors: premultiplied colours of the pixels [n, 4].
        behind: those of the ground there [n, 4].
        pixels: the pixels, numbered by rows.
        ground: region of the ground.
        box: first row, first column, and the last ones.
        tolerances: those of the picture.
        shape: its height and width.
    """
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
    mark = _Mark(pixels, ground, behind.mean(0), direction, height, box, shape)
    return None if mark.shows_two_inks(tolerances.paint) else mark


def _words(marks: list[_Mark]) -> list[list[_Mark]]:
    """Return the marks in groups of one ink and ground that are close to each other."""
    box = np.array([mark.box for mark in marks], np.float32)
    depth = np.array([mark.depth for mark in marks], np.float32)
    gaps = np.maximum(box[:, None, :2] - box[None, :, 2:], box[None, :, :2] - box[:, None, 2:]) - 1.0
    is_near = _are_near(marks, gaps, box[:, 2] - box[:, 0] + 1.0)
    # A weak mark belongs to the nearest one that is not.
    is_weak, is_solid = np.array([mark.is_weak for mark in marks]), np.array([mark.is_solid for mark in marks])
    shows_ink = np.array([mark.shows_ink for mark in marks])
    is_sure = is_solid[:, None] | is_solid | (shows_ink[:, None] & shows_ink)
    least = np.where(is_sure, LETTERING.pure_share, LETTERING.depth_share_min)
    is_alike = np.minimum(depth[:, None], depth) >= least * np.maximum(depth[:, None], depth)
    is_linked = is_near & is_alike & (is_weak[:, None] == is_weak)
    distance = np.where(is_near & ~is_weak, np.hypot(*gaps.clip(0.0).transpose(2, 0, 1)), np.inf)
    weak = np.nonzero(is_weak & np.isfinite(distance.min(1)))[0]
    is_linked[weak] = False
    is_linked[weak, distance[weak].argmin(1)] = True
    first, second = np.nonzero(is_linked)
    groups = connected_parts(first, second, len(marks)).astype(np.int32)
    return [[marks[index] for index in group] for group in pixels_of(groups[None])]


def _are_near(marks: list[_Mark], gaps: Floats32, tall: Floats32) -> Mask:
    """Return which marks [n, n] of one direction and ground are as close as letters of a line.

    Args:
        marks: the marks.
        gaps: pixels between two boxes, in rows and in columns [n, n, 2].
        tall: heights of the marks in pixels [n].
    """
    ground = np.array([mark.ground for mark in marks])
    direction = np.array([mark.direction for mark in marks], np.float32)
    reach = np.array([LETTERING.reach_down, LETTERING.reach_across], np.float32)
    limit = np.maximum(reach * np.maximum(tall[:, None], tall)[..., None], LETTERING.reach_min)
    is_alike = direction @ direction.T >= LETTERING.direction_min
    return np.asarray((gaps <= limit).all(2) & (ground[:, None] == ground) & is_alike)


@dataclass(frozen=True, eq=False)
class _Ink:
    """The ink of a word: its premultiplied colour [4], and its distance from the ground."""

    value: Floats32
    depth: float


def _inks(words: list[list[_Mark]], paints: Paints, tolerances: Tolerances) -> list[_Ink]:
    """Return the ink of each of the ``words``: a known paint that it nearly reaches, or its purest colour.

    The purest colours of other words on the same ground are known too.
    """
    deepest = [max(word, key=lambda mark: mark.depth) for word in words]
    values = np.column_stack([paints.color * paints.opacity[:, None], paints.opacity])[paints.kind == FLAT]
    known = {mark.ground: values for mark in deepest}
    inks: dict[int, _Ink] = {}
    for index in sorted(range(len(words)), key=lambda index: -deepest[index].depth):
        mark = deepest[index]
        inks[index] = _ink(mark, known[mark.ground], _nearness(words[index]), tolerances)
        known[mark.ground] = np.concatenate([known[mark.ground], inks[index].value[None]])
    return [inks[index] for index in range(len(words))]


def _nearness(word: list[_Mark]) -> float:
    """Return the share of an ink known from elsewhere that the purest pixel of a ``word`` of this ink has at least."""
    if len(word) > 1:
        return LETTERING.ink_near
    is_sure = word[0].shows_ink or (word[0].is_solid and not word[0].is_weak)
    return LETTERING.pure_share if is_sure else LETTERING.lone_ink_near


def _ink(mark: _Mark, known: Floats32, near: float, tolerances: Tolerances) -> _Ink:
    """Return the ink of ``mark``: a ``known`` premultiplied colour [K, 4] that it is ``near``, or its purest colour."""
    offset = known - mark.color
    depth = offset @ mark.direction
    rest = np.abs(offset - depth[:, None] * mark.direction).max(1)
    is_near = (rest <= 2.0 * tolerances.mix) & (mark.depth >= near * depth)
    is_near &= depth >= mark.depth - tolerances.paint
    if is_near.any():
        chosen = int(np.where(is_near, depth, -np.inf).argmax())
        return _Ink(known[chosen].astype(np.float32), float(depth[chosen]))
    return _Ink(mark.color + mark.depth * mark.direction, mark.depth)


def _straight(value: Floats32) -> Floats32:
    opacity = float(np.clip(value[3], 0.0, 1.0))
    return np.append(np.clip(value[:3] / max(opacity, 1e-6), 0.0, 1.0), opacity).astype(np.float32)


def _write(mark: _Mark, covered: Floats32, region: int, result: Assignment) -> None:
    """Make ``mark`` a part of the ``region``, which has ``covered`` [n] of each of its pixels."""
    is_own: Mask = covered > 0.5
    is_own[covered.argmax()] = True  # a mark that nowhere has more than its ground is still one
    place = np.unravel_index(mark.pixels, result.label.shape)
    result.label[place] = np.where(is_own, region, mark.ground)
    result.other[place] = np.where(is_own, mark.ground, region)
    result.share[place] = np.where(is_own, np.maximum(covered, 0.5), 1.0 - covered)


def _compact(found: Assignment, paints: Paints, is_lettering: Mask) -> tuple[Assignment, Paints, Mask]:
    """Return the regions, numbered anew without those that no pixel shows."""
    shown = np.bincount(found.label.ravel(), minlength=len(paints)) > 0
    number = (np.cumsum(shown) - 1).astype(np.int32)
    other = np.where(shown[found.other], found.other, found.label)
    share = np.where(other == found.label, np.float32(1), found.share)
    numbered = replace(found, label=number[found.label], other=number[other], share=share)
    return numbered, paints.select(np.flatnonzero(shown)), is_lettering[shown]
