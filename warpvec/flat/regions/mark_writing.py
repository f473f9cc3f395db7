"""Make one region of the marks of a word, and join the parts into which letters divide their ground."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from warpvec.arrays import Floats32, Integers32, Mask, Places
from warpvec.flat.connected_parts import connected_parts
from warpvec.flat.regions.assignment import Assignment
from warpvec.flat.regions.paints import Paints


def write_mark(pixels: Places, beside: Integers32, covered: Floats32, region: int, result: Assignment) -> None:
    """Make a mark a part of the ``region``, in ``result``.

    Args:
        pixels: the pixels of the mark [n], numbered by rows.
        beside: region of the ground of each of them [n].
        covered: share of each that the mark has [n].
        region: number of the region.
        result: the mix that is changed.
    """
    is_own: Mask = covered > 0.5
    is_own[covered.argmax()] = True  # a mark that nowhere has more than its ground is still one
    place = np.unravel_index(pixels, result.label.shape)
    result.label[place] = np.where(is_own, region, beside)
    result.other[place] = np.where(is_own, beside, region)
    result.share[place] = np.where(is_own, np.maximum(covered, 0.5), 1.0 - covered)


def join_grounds(found: Assignment, beside: list[Integers32], paints: Paints) -> None:
    """Join the regions ``beside`` each mark that have the same flat paint: letters divide a narrow halo."""
    alike = paints.first_alike()
    pairs: list[Integers32] = []
    for regions in map(np.unique, beside):
        _, first, same = np.unique(alike[regions], return_index=True, return_inverse=True)
        pairs.append(np.stack([regions[first[same]], regions]))
    leader, second = np.concatenate(pairs, 1)
    if (leader == second).all():
        return
    group = connected_parts(leader, second, len(paints))
    least = np.full(int(group.max()) + 1, len(paints))
    np.minimum.at(least, group, np.arange(len(paints)))
    number = np.arange(int(max(found.label.max(), found.other.max())) + 1, dtype=np.int32)
    number[: len(paints)] = least[group]
    found.label[:], found.other[:] = number[found.label], number[found.other]


def without_unseen(found: Assignment, paints: Paints, is_lettering: Mask) -> tuple[Assignment, Paints, Mask]:
    """Return the regions, numbered anew without those that no pixel shows."""
    shown = np.bincount(found.label.ravel(), minlength=len(paints)) > 0
    number = (np.cumsum(shown) - 1).astype(np.int32)
    other = np.where(shown[found.other], found.other, found.label)
    share = np.where(other == found.label, np.float32(1), found.share)
    numbered = replace(found, label=number[found.label], other=number[other], share=share)
    return numbered, paints.select(np.flatnonzero(shown)), is_lettering[shown]
