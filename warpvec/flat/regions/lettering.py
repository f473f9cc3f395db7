"""Small marks on one paint, such as letters: each pixel of them is a mix of one ink and the ground.

A stroke that is narrower than two pixels may have no pixel of pure ink, and no pixel in which ink has the larger share.
So the marks are found as islands in their ground, whatever their pixels show, and the ink of a word is the purest
colour of all its marks.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from warpvec.arrays import Floats, Floats32, Integers, Integers32, Mask, Places
from warpvec.flat.connected_parts import connected_parts
from warpvec.flat.constants.lettering import LETTERING
from warpvec.flat.regions.assignment import Assignment
from warpvec.flat.regions.box_gaps import are_close, are_dots_between, gaps_between
from warpvec.flat.regions.crossing_marks import CrossingMark, joined
from warpvec.flat.regions.islands import Island, find_grounds, parted_islands, regions_behind, whole_islands
from warpvec.flat.regions.mark_writing import join_grounds, without_unseen, write_mark
from warpvec.flat.regions.noise import Tolerances
from warpvec.flat.regions.paint_fitting import flat_paints
from warpvec.flat.regions.paints import Paints
from warpvec.flat.regions.region_growing import NONE, pixels_of
from warpvec.geometry.paints.registry import FLAT


@dataclass(frozen=True, eq=False)
class _Mark:
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
    marks, crossing = _marks(picture, found, paints, tolerances)
    marks = [mark for mark in marks if not _is_shaded(mark, found, paints)]
    if not 0 < len(marks) <= LETTERING.marks_max:
        return found, paints, None
    crossing = crossing if len(crossing) <= LETTERING.marks_max else []
    result = found.copy()
    words = _words(marks)
    colors: list[Floats32] = []
    written: list[_Mark | CrossingMark] = []
    for word, ink in zip(words, _inks(words, paints, _is_pure(found, len(paints)), tolerances), strict=True):
        covered = [np.clip(mark.height / ink.depth, 0.0, 1.0) for mark in word]
        if _is_lettering(covered):
            least = area_min if len(word) > 1 else lone_area_min
            large: list[tuple[_Mark | CrossingMark, Floats32]] = [
                (mark, part) for mark, part in zip(word, covered, strict=True) if part.sum() >= least
            ]
            boxes = np.array([mark.box for mark in word], np.float32)
            large += joined(boxes, ink.value, crossing, tolerances) if large else []
            if len(large) == 1 and word[0].island.is_cut_out:
                continue  # what an edge leaves may look like a mark, but not like a word
            for mark, part in large:
                write_mark(mark.pixels, mark.beside, part, len(paints) + len(colors), result)
                written.append(mark)
            colors += [_straight(ink.value)] * bool(large)
    if not colors:
        return found, paints, None
    is_lettering = np.arange(len(paints) + len(colors)) >= len(paints)
    join_grounds(result, [mark.beside for mark in written], paints)
    return without_unseen(result, paints.joined(flat_paints(np.stack(colors))), is_lettering)


def _is_shaded(mark: _Mark, found: Assignment, paints: Paints) -> bool:
    """Return whether pure pixels of a ``mark`` show a gradient: a mark of one ink shows none."""
    own = found.label.flat[mark.pixels]
    is_shaded = (paints.kind[own] != FLAT) & (own != mark.ground) & found.is_pure.flat[mark.pixels]
    return int(is_shaded.sum()) >= LETTERING.shaded_area_min


def _is_lettering(covered: list[Floats32]) -> bool:
    """Return whether the marks of a word, each ``covered`` [n] by its ink, are thin; several may be bolder than one."""
    is_word = len(covered) >= LETTERING.word_marks_min
    return _is_thin(np.concatenate(covered), LETTERING.pure_word_max if is_word else LETTERING.pure_part_max)


def _is_thin(covered: Floats32, pure_max: float = LETTERING.pure_part_max) -> bool:
    """Return whether at most the share ``pure_max`` of what is ``covered`` [n] lies in pixels of pure ink."""
    return bool(covered[covered >= LETTERING.pure_share].sum() <= pure_max * covered.sum())


def _marks(
    picture: Floats32, found: Assignment, paints: Paints, tolerances: Tolerances
) -> tuple[list[_Mark], list[CrossingMark]]:
    """Return the islands in grounds of one paint that are mixes of the ground and one ink, and those in several."""
    grounds = find_grounds(picture, found.label, paints, tolerances)
    islands, others = whole_islands(grounds)
    marks: list[_Mark] = []
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


def _mark(
    island: Island, picture: Floats32, beside: Integers32, paints: Paints, tolerances: Tolerances
) -> _Mark | None:
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
    mark = _Mark(island, island.ground, beside, behind.mean(0), direction, height, (picture.shape[0], picture.shape[1]))
    return None if mark.shows_two_inks(tolerances.paint) else mark


def _words(marks: list[_Mark]) -> list[list[_Mark]]:
    """Return the marks in groups of one ink and ground that are close to each other."""
    box = np.array([mark.box for mark in marks], np.float32)
    depth = np.array([mark.depth for mark in marks], np.float32)
    gaps = gaps_between(box[:, None], box)
    is_near = (are_close(box[:, None], box) | are_dots_between(box[:, None], box)) & _are_of_one_ink(marks)
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


def _are_of_one_ink(marks: list[_Mark]) -> Mask:
    """Return which pairs of marks [n, n] lie on the same ground and differ from it in the same direction."""
    ground = np.array([mark.ground for mark in marks])
    direction = np.array([mark.direction for mark in marks], np.float32)
    return np.asarray((ground[:, None] == ground) & (direction @ direction.T >= LETTERING.direction_min))


@dataclass(frozen=True, eq=False)
class _Ink:
    """The ink of a word: its premultiplied colour [4], and its distance from the ground."""

    value: Floats32
    depth: float


def _is_pure(found: Assignment, count: int) -> Mask:
    """Return which of ``count`` paints pure pixels show, and not only mixes."""
    return np.asarray(np.bincount(found.label[found.is_pure], minlength=count) > 0)


def _inks(words: list[list[_Mark]], paints: Paints, is_pure: Mask, tolerances: Tolerances) -> list[_Ink]:
    """Return the ink of each of the ``words``: a known paint that it nearly reaches, or its purest colour.

    The purest colours of other words on the same ground are known too. A word whose marks agree on their purest colour
    has that one, or a paint that ``is_pure`` [K], for the colour of a paint that only mixed pixels show is uncertain.
    """
    deepest = [max(word, key=lambda mark: mark.depth) for word in words]
    is_flat = paints.kind == FLAT
    values = paints.premultiplied()
    written = {mark.ground: np.zeros((0, 4), np.float32) for mark in deepest}
    inks: dict[int, _Ink] = {}
    for index in sorted(range(len(words)), key=lambda index: -deepest[index].depth):
        mark, near = deepest[index], _nearness(words[index])
        agrees = _agree_on_ink(words[index], tolerances)
        known, others = values[is_flat & is_pure if agrees else is_flat], written[mark.ground]
        nearness = np.repeat([near, max(near, LETTERING.pure_share) if agrees else near], [len(known), len(others)])
        inks[index] = _ink(mark, np.concatenate([known, others]), nearness, tolerances)
        written[mark.ground] = np.concatenate([others, inks[index].value[None]])
    return [inks[index] for index in range(len(words))]


def _agree_on_ink(word: list[_Mark], tolerances: Tolerances) -> bool:
    """Return whether several marks of a ``word`` have as pure pixels: strokes narrower than a pixel seldom agree."""
    least = max(mark.depth for mark in word) - tolerances.paint
    counts = [int((mark.height >= least).sum()) for mark in word]
    return sum(counts) >= LETTERING.agreeing_pixels and sum(map(bool, counts)) >= LETTERING.agreeing_marks


def _nearness(word: list[_Mark]) -> float:
    """Return the share of an ink known from elsewhere that the purest pixel of a ``word`` of this ink has at least."""
    if len(word) > 1:
        return LETTERING.ink_near
    is_sure = word[0].shows_ink or (word[0].is_solid and not word[0].is_weak)
    return LETTERING.pure_share if is_sure else LETTERING.lone_ink_near


def _ink(mark: _Mark, known: Floats32, near: Floats, tolerances: Tolerances) -> _Ink:
    """Return the ink of ``mark``: a ``known`` premultiplied colour [K, 4] that it is ``near`` [K], or its purest."""
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
