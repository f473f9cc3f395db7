"""Words: marks of one ink on one ground that are close to each other.

Marks join the nearest ones first, so that the letters of a word have joined before a word asks the next one. Two words
stay apart where their pixels show two inks.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpvec.arrays import Floats32, Mask
from warpvec.flat.constants.lettering import LETTERING
from warpvec.flat.regions.box_gaps import are_close, are_dots_between, gaps_between
from warpvec.flat.regions.marks import Mark
from warpvec.flat.regions.noise import Tolerances


@dataclass(frozen=True, eq=False)
class _Word:
    """Marks that have joined.

    Attributes:
        marks: their numbers.
        depth: that of the purest of them.
        ink: depth of the ink that some of them show; None if none does.
        is_solid: whether the purest one is solid.
    """

    marks: list[int]
    depth: float
    ink: float | None
    is_solid: bool

    def joined(self, other: _Word) -> _Word:
        """Return both as one."""
        inks = [each.ink for each in (self, other) if each.ink is not None]
        purest = self if self.depth >= other.depth else other
        return _Word(self.marks + other.marks, purest.depth, max(inks, default=None), purest.is_solid)

    def may_reach(self, depth: float) -> bool:
        """Return whether a mark of this ``depth`` may have the ink of the word: none is purer than ink."""
        return self.ink is None or depth <= self.ink + LETTERING.ink_difference

    def may_join(self, other: _Word) -> bool:
        """Return whether the pixels of both leave open that they have one ink."""
        if self.ink is not None and other.ink is not None:
            return abs(self.ink - other.ink) <= LETTERING.ink_difference
        if not (self.may_reach(other.depth) and other.may_reach(self.depth)):
            return False
        least = LETTERING.pure_share if self.is_solid or other.is_solid else LETTERING.depth_share_min
        return min(self.depth, other.depth) >= least * max(self.depth, other.depth)


def words_of(marks: list[Mark], tolerances: Tolerances) -> list[list[Mark]]:
    """Return the ``marks`` in groups of one ink and ground that are close to each other."""
    distance = _distances(marks, tolerances)
    is_weak = np.array([mark.is_weak for mark in marks])
    words = [
        _Word([k], mark.depth, mark.depth if mark.shows_ink else None, mark.is_solid) for k, mark in enumerate(marks)
    ]
    _join_near(words, np.where(is_weak[:, None] | is_weak, np.inf, distance))
    is_alone = is_weak.copy()
    for k in np.flatnonzero(is_weak):
        near = _nearest(words, np.where(is_weak, np.inf, distance[k]), marks[k].depth)
        if near is not None:
            _join(words, words[k], words[near])
            is_alone[k] = False
    _join_near(words, np.where(is_alone[:, None] & is_alone, distance, np.inf))
    return [[marks[k] for k in sorted(word.marks)] for word in dict.fromkeys(words)]


def _distances(marks: list[Mark], tolerances: Tolerances) -> Floats32:
    """Return the distances [n, n] of marks that may be letters of a word; infinite for others."""
    box = np.array([mark.box for mark in marks], np.float32)
    is_near = are_close(box[:, None], box) | are_dots_between(box[:, None], box)
    is_near &= _may_be_of_one_ink(marks, tolerances)
    distance = np.hypot(*gaps_between(box[:, None], box).clip(0.0).transpose(2, 0, 1))
    return np.asarray(np.where(is_near | is_near.T, distance, np.inf), np.float32)


def _may_be_of_one_ink(marks: list[Mark], tolerances: Tolerances) -> Mask:
    """Return which pairs of marks [n, n] lie on the same ground, and are mixes of one ink as far as pixels tell."""
    ground = np.array([mark.ground for mark in marks])
    direction = np.array([mark.direction for mark in marks], np.float32)
    depth = np.array([mark.depth for mark in marks], np.float32)
    cosine = (direction @ direction.T).clip(0.0, 1.0)
    rest = np.minimum(depth[:, None], depth) * np.sqrt(1.0 - cosine**2)
    return np.asarray((ground[:, None] == ground) & (rest <= 2.0 * tolerances.mix))


def _join_near(words: list[_Word], distance: Floats32) -> None:
    """Join the words of marks at a finite ``distance`` [n, n], the nearest ones first, in ``words`` [n]."""
    first, second = np.nonzero(np.triu(np.isfinite(distance), 1))
    for k in np.argsort(distance[first, second], kind="stable"):
        one, other = words[first[k]], words[second[k]]
        if one is not other and one.may_join(other):
            _join(words, one, other)


def _join(words: list[_Word], one: _Word, other: _Word) -> None:
    both = one.joined(other)
    for mark in both.marks:
        words[mark] = both


def _nearest(words: list[_Word], distance: Floats32, depth: float) -> int | None:
    """Return the nearest mark whose word may have a mark of this ``depth``; None if none at a ``distance`` [n] has."""
    near = np.flatnonzero(np.isfinite(distance))
    near = near[np.argsort(distance[near], kind="stable")]
    return next((int(mark) for mark in near if words[mark].may_reach(depth)), None)
