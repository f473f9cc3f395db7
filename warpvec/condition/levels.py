"""How many colours a picture has, and whether dots of them stand for others."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warpvec.arrays import Floats
from warpvec.condition.constants import CONDITION


@dataclass(frozen=True)
class Palette:
    """The few colours of a picture.

    Attributes:
        color_count: number of different colours.
        is_dithered: whether single pixels of them stand for colours in between.
    """

    color_count: int
    is_dithered: bool

    @property
    def has_two_levels(self) -> bool:
        """Whether the picture has two colours, without any between."""
        return self.color_count == 2


def find_palette(levels: Floats) -> Palette | None:
    """Return the palette of ``levels`` [h, w, channels], whole numbers in [0, 255]; None for many colours."""
    if len(np.unique(_codes(levels[:: CONDITION.palette_step]))) > CONDITION.palette_max:
        return None
    count = len(np.unique(_codes(levels)))
    return Palette(count, _is_dithered(levels)) if count <= CONDITION.palette_max else None


def _codes(levels: Floats) -> NDArray[np.uint32]:
    """Return a number for the colour of each pixel [h, w]."""
    codes = np.zeros(levels.shape[:2], np.uint32)
    for channel in np.moveaxis(levels, -1, 0):
        codes = codes * np.uint32(256) + np.rint(channel).astype(np.uint32)
    return codes


def _is_dithered(levels: Floats) -> bool:
    """Return whether many pixels of ``levels`` [h, w, channels] stand out of neighbours in a row that are alike."""
    if min(levels.shape[:2]) < CONDITION.dither_side_min:
        return False
    left, middle, right = levels[:, :-2], levels[:, 1:-1], levels[:, 2:]
    stands_out = _largest(np.abs(middle - left)) >= CONDITION.dither_step
    is_alike = _largest(np.abs(right - left)) < CONDITION.dither_step / 2.0
    return float((stands_out & is_alike).mean()) >= CONDITION.dither_share_min


def _largest(values: Floats) -> Floats:
    """Return the largest of the channels of ``values`` [h, w, channels], which NumPy's reduction finds slowly."""
    return np.maximum.reduce(list(np.moveaxis(values, -1, 0)))
