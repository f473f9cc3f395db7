"""The inks of words: what their pixels show, or a known colour that their thin strokes nearly reach.

A word that shows its ink keeps it, however near another colour of the page may be. Thin strokes may have no pure pixel;
their ink is the nearest of the known ones that could be theirs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpvec.arrays import Floats32, Mask
from warpvec.flat.constants.lettering import LETTERING
from warpvec.flat.regions.marks import Mark
from warpvec.flat.regions.noise import Tolerances
from warpvec.flat.regions.paints import Paints
from warpvec.geometry.paints.registry import FLAT


@dataclass(frozen=True, eq=False)
class Ink:
    """The ink of a word: its premultiplied colour [4], and its distance from the ground."""

    value: Floats32
    depth: float


def find_inks(words: list[list[Mark]], paints: Paints, is_seen: Mask, tolerances: Tolerances) -> list[Ink]:
    """Return the ink of each of the ``words``: a known colour if the word nearly reaches it, or its purest colour.

    Known are the paints that ``is_seen`` [K] inside areas and the inks of other words on the same ground. Last come the
    other paints, for words that show them, or do not agree on their purest colour: those of thin lines, and of stems
    between two columns, which are no colour of the drawing.
    """
    is_flat, values = paints.kind == FLAT, paints.premultiplied()
    seen, others = values[is_flat & is_seen], values[is_flat & ~is_seen]
    known = {word[0].ground: seen for word in words}
    inks: dict[int, Ink] = {}
    order = [(not _shows_ink(word), -_deepest(word).depth, index) for index, word in enumerate(words)]
    for _, _, index in sorted(order):
        word = words[index]
        mark, near = _deepest(word), _nearness(word, tolerances)
        ink = _nearest(mark, known[mark.ground], near, 0.0, tolerances)
        if ink is None and (near < LETTERING.pure_share or _shows_ink(word)):
            beyond = 0.0 if _shows_ink(word) else LETTERING.ink_difference
            ink = _nearest(mark, others, near, beyond, tolerances)
        inks[index] = ink or Ink(mark.color + mark.depth * mark.direction, mark.depth)
        known[mark.ground] = np.concatenate([known[mark.ground], inks[index].value[None]])
    return [inks[index] for index in range(len(words))]


def _deepest(word: list[Mark]) -> Mark:
    return max(word, key=lambda mark: mark.depth)


def _shows_ink(word: list[Mark]) -> bool:
    """Return whether pixels of a ``word`` that are about as pure as its purest one are surely of pure ink."""
    least = _deepest(word).depth - LETTERING.ink_difference
    return any(mark.shows_ink and mark.depth >= least for mark in word)


def _agree_on_ink(word: list[Mark], tolerances: Tolerances) -> bool:
    """Return whether several marks of a ``word`` have as pure pixels: strokes narrower than a pixel seldom agree."""
    least = _deepest(word).depth - tolerances.paint
    counts = [int((mark.height >= least).sum()) for mark in word]
    return sum(counts) >= LETTERING.agreeing_pixels and sum(map(bool, counts)) >= LETTERING.agreeing_marks


def _nearness(word: list[Mark], tolerances: Tolerances) -> float:
    """Return the share of a known ink that the purest pixel of a ``word`` of this ink has at least."""
    if _shows_ink(word):
        return 1.0 - LETTERING.ink_difference / _deepest(word).depth
    if _agree_on_ink(word, tolerances):
        return LETTERING.pure_share
    if len(word) > 1:
        return LETTERING.ink_near
    is_sure = word[0].is_solid and not word[0].is_weak
    return LETTERING.pure_share if is_sure else LETTERING.lone_ink_near


def _nearest(mark: Mark, known: Floats32, near: float, beyond: float, tolerances: Tolerances) -> Ink | None:
    """Return the ink of a mark: the nearest ``known`` premultiplied colour [K, 4] of which it has the share ``near``.

    It is None if there is none, or if all are less than ``beyond`` farther from the ground than the mark.
    """
    offset = known - mark.color
    depth = offset @ mark.direction
    rest = np.abs(offset - depth[:, None] * mark.direction).max(1)
    is_near = (rest <= 2.0 * tolerances.mix) & (mark.depth >= near * depth)
    is_near &= depth >= (mark.depth + beyond if beyond else mark.depth - tolerances.paint)
    if not is_near.any():
        return None
    chosen = int(np.where(is_near, depth, np.inf).argmin())
    return Ink(known[chosen].astype(np.float32), float(depth[chosen]))
