"""Small marks on one paint, such as letters: each pixel of them is a mix of one ink and the ground.

A stroke that is narrower than two pixels may have no pixel of pure ink, and no pixel in which ink has the larger share.
So the marks are found as islands in their ground, whatever their pixels show, and the ink of a word is the purest
colour of all its marks.
"""

from __future__ import annotations

import numpy as np

from warpvec.arrays import Floats32, Mask
from warpvec.flat.constants.lettering import LETTERING
from warpvec.flat.regions.assignment import Assignment
from warpvec.flat.regions.crossing_marks import CrossingMark, joined
from warpvec.flat.regions.mark_writing import join_grounds, without_unseen, write_mark
from warpvec.flat.regions.marks import Mark, find_marks, is_thin
from warpvec.flat.regions.noise import Tolerances
from warpvec.flat.regions.paint_fitting import flat_paints
from warpvec.flat.regions.paints import Paints
from warpvec.flat.regions.region_growing import NONE
from warpvec.flat.regions.word_inks import find_inks
from warpvec.flat.regions.words import words_of
from warpvec.geometry.paints.registry import FLAT


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
    marks, crossing = find_marks(picture, found, paints, tolerances)
    marks = [mark for mark in marks if not _is_shaded(mark, found, paints)]
    if not 0 < len(marks) <= LETTERING.marks_max:
        return found, paints, None
    crossing = crossing if len(crossing) <= LETTERING.marks_max else []
    result = found.copy()
    words = words_of(marks, tolerances)
    is_seen = _seen_inside(found, len(paints))
    colors: list[Floats32] = []
    written: list[Mark | CrossingMark] = []
    for word, ink in zip(words, find_inks(words, paints, is_seen, tolerances), strict=True):
        covered = [np.clip(mark.height / ink.depth, 0.0, 1.0) for mark in word]
        if _is_lettering(covered):
            least = area_min if len(word) > 1 else lone_area_min
            large: list[tuple[Mark | CrossingMark, Floats32]] = [
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


def _seen_inside(found: Assignment, count: int) -> Mask:
    """Return which of ``count`` paints some pixel shows with its four neighbours: others may be those of mixes."""
    label = np.where(found.is_pure, found.label, NONE)
    inner = label[1:-1, 1:-1]
    beside = (label[:-2, 1:-1], label[2:, 1:-1], label[1:-1, :-2], label[1:-1, 2:])
    is_inside = np.logical_and.reduce([inner == each for each in beside]) & (inner != NONE)
    return np.asarray(np.bincount(inner[is_inside], minlength=count) > 0)


def _is_shaded(mark: Mark, found: Assignment, paints: Paints) -> bool:
    """Return whether pure pixels of a ``mark`` show a gradient: a mark of one ink shows none."""
    own = found.label.flat[mark.pixels]
    is_shaded = (paints.kind[own] != FLAT) & (own != mark.ground) & found.is_pure.flat[mark.pixels]
    return int(is_shaded.sum()) >= LETTERING.shaded_area_min


def _is_lettering(covered: list[Floats32]) -> bool:
    """Return whether the marks of a word, each ``covered`` [n] by its ink, are thin; several may be bolder than one."""
    is_word = len(covered) >= LETTERING.word_marks_min
    return is_thin(np.concatenate(covered), LETTERING.pure_word_max if is_word else LETTERING.pure_part_max)


def _straight(value: Floats32) -> Floats32:
    opacity = float(np.clip(value[3], 0.0, 1.0))
    return np.append(np.clip(value[:3] / max(opacity, 1e-6), 0.0, 1.0), opacity).astype(np.float32)
