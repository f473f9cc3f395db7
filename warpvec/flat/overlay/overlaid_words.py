"""Words over several grounds: each is a layer of its own, and what lies below is traced as if it were not there.

A name on a map lies across roads, their edges, and a wood. Traced together, each ground would be cut into pieces, and
each letter drawn in pieces. So the share of ink in each pixel is found first, and the picture without the ink.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats32, Integers32, Mask
from warpvec.flat.constants.lettering import LETTERING
from warpvec.flat.constants.overlay import OVERLAY
from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.overlay.filling import filled, ink_share
from warpvec.flat.overlay.marks import EIGHT_NEIGHBORS, Row, median_ground, rows_of
from warpvec.flat.regions.islands import find_grounds
from warpvec.flat.regions.noise import measure_tolerances
from warpvec.flat.regions.paint_fitting import flat_paints
from warpvec.flat.regions.region_growing import NONE
from warpvec.flat.regions.regions import Regions, premultiplied
from warpvec.geometry.paints.registry import FLAT
from warpvec.watch.watch import UNWATCHED, Watch


class Overlay(NamedTuple):
    """Words that lie over several grounds.

    Attributes:
        words: the words, on a clear canvas.
        ground: the picture as it would be without them [h, w, 3], sRGB-encoded in [0, 1].
    """

    words: Regions
    ground: Floats32


class _Word(NamedTuple):
    """A word: its ``ink`` [3], and its ``share`` [h, w] and the ``ground`` [h, w, 3] in the window of its ``row``."""

    row: Row
    ink: Floats32
    share: Floats32
    ground: Floats32


def find_overlay(image: Floats32, regions: Regions, watch: Watch = UNWATCHED) -> Overlay | None:
    """Return the words over several grounds of a sharp picture without noise; None if there are none.

    Args:
        image: picture [h, w, 3 or 4], sRGB-encoded in [0, 1], with straight alpha if it has four channels.
        regions: its regions.
        watch: the watch over the run. When it is over, the words found so far must do.
    """
    picture = premultiplied(image)
    if (picture[..., 3] < 1.0).any():
        return None
    inks = _inks(picture[..., :3], regions)
    tolerances = measure_tolerances(picture) if len(inks) else None
    if tolerances is None or tolerances.noise > LETTERING.noise_max or tolerances.reach > REGIONS.sharp_reach:
        return None
    grounds = find_grounds(picture, regions.label, regions.paints, tolerances).all
    if regions.is_lettering is not None:
        grounds[regions.is_lettering[regions.label]] = NONE
    found = list(_words(picture[..., :3].copy(), inks, grounds, watch))
    if not found:
        return None
    ground = picture[..., :3].copy()
    for word in found:
        has_ink = word.share > 0.0
        ground[word.row.window][has_ink] = word.ground[has_ink]
    return Overlay(_regions_of(found, regions.label.shape), ground)


def _inks(picture: Floats32, regions: Regions) -> Floats32:
    """Return the colours [n, 3] that may be inks: those of flat small regions and of words, the most frequent first."""
    is_small = np.bincount(regions.label.ravel(), minlength=len(regions)) < LETTERING.ground_area_min
    if regions.is_lettering is not None:
        is_small |= regions.is_lettering
    is_ink = (is_small & (regions.paints.kind == FLAT))[regions.label]
    color = regions.paints.color[regions.label[is_ink]]
    color = color[_is_at(picture[is_ink], color)]
    codes, counts = np.unique(np.round(255.0 * color).astype(np.int64) @ [65536, 256, 1], return_counts=True)
    chosen = np.argsort(-counts, kind="stable")[: OVERLAY.inks_max]
    codes = codes[chosen][counts[chosen] >= OVERLAY.ink_pixels_min]
    return np.stack([codes >> 16, codes >> 8 & 255, codes & 255], 1).astype(np.float32) / np.float32(255)


def _words(picture: Floats32, inks: Floats32, grounds: Integers32, watch: Watch) -> Iterator[_Word]:
    """Yield the words of the ``inks`` [n, 3] over several ``grounds`` [h, w]; ``picture`` [h, w, 3] loses them.

    Rows that show their ink come first. Where it is known from these, others need not show it.
    """
    around, tried = median_ground(picture), 0
    for ink in inks:
        is_apart = np.linalg.norm(ink - around, axis=-1) >= OVERLAY.contrast_min
        rows = list(rows_of(np.where(is_apart, ink_share(picture, around, ink), 0.0)))
        shown = [_is_at(picture[row.window], ink)[row.core].sum() >= OVERLAY.row_pixels_min for row in rows]
        is_known = False
        for row, shows_ink in sorted(zip(rows, shown, strict=True), key=lambda each: not each[1]):
            if not (shows_ink or is_known) or tried >= OVERLAY.pixels_max or watch.is_over():
                continue
            tried += int(row.core.sum())
            word = _word(picture, row, ink, grounds[row.window])
            if word is not None:
                is_known = True
                picture[row.window] = word.ground
                yield word


def _word(picture: Floats32, row: Row, ink: Floats32, grounds: Integers32) -> _Word | None:
    """Return the word of a ``row``, if it lies over several grounds and these and its ink explain all of its pixels."""
    part = picture[row.window]
    hidden = ndimage.binary_dilation(row.core, EIGHT_NEIGHBORS) & (row.core | (grounds == NONE))
    if hidden.sum() > OVERLAY.hidden_max or not _has_several_grounds(part, hidden, grounds, ink):
        return None
    for _ in range(OVERLAY.rounds):
        ground = filled(part, hidden, ink)
        share = np.where(hidden, ink_share(part, ground, ink), 0.0)
        is_free = (share < OVERLAY.free_share_max) & (np.abs(part - ground).max(-1) < OVERLAY.free_error_max)
        hidden &= row.core | ~is_free
    rest = np.abs(part - ground - share[..., None] * (ink - ground)).max(-1)
    if (rest[hidden] <= OVERLAY.rest_max).mean() < OVERLAY.explained_min or share.max() < OVERLAY.purest_min:
        return None
    return _Word(row, ink, np.where(share >= OVERLAY.least_share, share, 0.0), ground)


def _is_at(picture: Floats32, color: Floats32) -> Mask:
    """Return which pixels [...] of ``picture`` [..., 3] have this ``color`` [..., 3]."""
    return np.asarray(np.abs(picture - color).max(-1) <= REGIONS.paint[0] / 255)


def _has_several_grounds(part: Floats32, hidden: Mask, grounds: Integers32, ink: Floats32) -> bool:
    """Return whether the pixels beside those that are ``hidden`` [h, w] show several ``grounds``, but no ``ink``."""
    beside = ndimage.binary_dilation(hidden, EIGHT_NEIGHBORS, 2) & (grounds != NONE) & ~hidden
    is_ink = np.linalg.norm(part[beside] - ink, axis=-1) < OVERLAY.contrast_min
    counts = np.sort(np.unique(grounds[beside], return_counts=True)[1])
    is_apart = is_ink.sum() <= OVERLAY.ring_ink_max * len(is_ink)
    return is_apart and bool(counts[:-1].sum() >= max(OVERLAY.ring_share_min * counts.sum(), 1))


def _regions_of(words: list[_Word], shape: tuple[int, ...]) -> Regions:
    """Return the ``words`` as regions of a picture of this ``shape``, on a clear canvas, which is the first region."""
    label, other = np.zeros((2, *shape), np.int32)
    share = np.ones(shape, np.float32)
    for number, word in enumerate(words, 1):
        has_ink = word.share > 0.0
        is_most = word.share > 0.5
        is_most.flat[word.share.argmax()] = True
        window = word.row.window
        label[window][has_ink & is_most] = number
        other[window][has_ink & ~is_most] = number
        share[window][has_ink] = np.where(is_most, np.maximum(word.share, 0.5), 1.0 - word.share)[has_ink]
    colors = np.array([[0.0, 0.0, 0.0, 0.0], *([*word.ink, 1.0] for word in words)], np.float32)
    return Regions(label, other, share, flat_paints(colors), 0, np.arange(len(colors)) > 0)
