"""Words of a picture whose letters are too small to be drawn legibly."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from warpvec.flat.constants.lettering import LETTERING
from warpvec.flat.regions.regions import Regions


def small_word_count(regions: Regions) -> int:
    """Return how many words have letters of which most are lower than can be read."""
    if regions.is_lettering is None:
        return 0
    return sum(_is_small(regions, int(word)) for word in np.flatnonzero(regions.is_lettering))


def _is_small(regions: Regions, word: int) -> bool:
    """Return whether a region is a small word: some marks in a row, no single sign."""
    inked, _ = ndimage.label((regions.label == word) | (regions.other == word), np.ones((3, 3), bool))
    heights = [rows.stop - rows.start for rows, _ in ndimage.find_objects(inked)]
    return len(heights) >= LETTERING.word_marks_min and bool(np.median(heights) < LETTERING.legible_height)
