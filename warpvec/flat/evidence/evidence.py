"""How far the pixels of a picture may lie from its drawing: by rounding, noise and the steps of a JPEG."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from warpvec.arrays import Floats, Floats32
from warpvec.condition.jpeg import Jpeg
from warpvec.condition.noise import white_noise
from warpvec.condition.unrounding import JpegRounding
from warpvec.image.alpha import is_transparent, over

ROUNDING = 1.0 / 12.0
"""Squared deviation of a value that was rounded to whole levels."""

LEVEL_COUNT = 256.0

FREQUENCY = np.hypot(*np.indices((8, 8)))
"""The frequency of each value [8, 8] of a block's cosine transform, in half periods a block."""

CHANNEL_WEIGHTS = (1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0)
"""Share of the squared deviation of the brightness and of both colours of a JPEG in a channel of RGB, on average."""


@dataclass(frozen=True, eq=False)
class Evidence:
    """What a picture says, and how sure it is of that. It is made once, and never changes.

    Attributes:
        levels: the picture over white [h, w, 3], in [0, 255].
        sigma: standard deviation [3] in levels of a pixel from its drawing.
        jpeg: what the picture was saved as; None for no JPEG that is known.
    """

    levels: Floats
    sigma: Floats
    jpeg: Jpeg | None = None

    @staticmethod
    def of(image: Floats32, jpeg: Jpeg | None = None) -> Evidence:
        """Return what ``image`` [h, w, 3 or 4] in [0, 1], with straight alpha, says if it was saved as ``jpeg``."""
        levels = 255.0 * (over(image, 1.0) if is_transparent(image) else image).astype(np.float64)
        if jpeg is not None:
            stored = float(_variance_of(levels, jpeg, are_zeros_known=True).mean())
            return Evidence(levels, np.full(3, math.sqrt(stored)), jpeg)
        return Evidence(levels, np.sqrt(ROUNDING + np.square(white_noise(levels))))

    @cached_property
    def literal_nats(self) -> float:
        """Nats of a pixel that is stated by itself, over those of one that a drawing shows exactly.

        It may have any of 256 levels in each channel; the drawing leaves those within the deviation.
        """
        found = np.log(np.maximum(LEVEL_COUNT / (self.sigma * math.sqrt(2.0 * math.pi)), 1.0))
        return float(found.sum())

    @cached_property
    def variance(self) -> Floats:
        """Squared deviation in levels of each pixel of a JPEG from its drawing [h, w], a mean over the channels.

        It is that of the block, which is high at edges and low in even areas.
        """
        assert self.jpeg is not None
        return _variance_of(self.levels, self.jpeg)

    def misfit(self, shown: Floats) -> Floats:
        """Return the nats [h, w] by which a drawing ``shown`` [h, w, 3], in [0, 255], misses each pixel.

        They are half of the squared distance over the variance. The errors of a JPEG depend on each other, and those of
        its cosine transform do not, so that a block is judged by its transform, and its pixels share the result. No
        pixel costs more than one that is stated by itself.
        """
        off = shown - self.levels
        nats = np.square(off / self.sigma).sum(2) / 2.0 if self.jpeg is None else self._misfit_of_blocks(off)
        return np.minimum(nats, self.literal_nats)

    def _misfit_of_blocks(self, off: Floats) -> Floats:
        """Return the nats [h, w] of the differences ``off`` [h, w, 3], the same for all pixels of a block."""
        assert self.jpeg is not None
        height, width = off.shape[:2]
        rounding, nats = JpegRounding(off, self.jpeg), np.zeros((height, width))
        for values, steps in zip(rounding.transforms_of(off), rounding.steps, strict=True):
            of_block = np.square(values / np.sqrt(np.square(steps) / 12.0 + ROUNDING)).sum((2, 3)) / 2.0
            side = 8 * -(-width // (8 * of_block.shape[1]))
            nats += _spread(of_block, height, width) / side**2
        return nats


def _variance_of(levels: Floats, jpeg: Jpeg, *, are_zeros_known: bool = False) -> Floats:
    """Return the squared deviation in levels that the steps of ``jpeg`` leave in each pixel [h, w].

    It is the same in a block. A value of the transform that is stored as 0 was less than half a step, and at an edge as
    large as the stored ones let expect, since the transform of an edge falls with the frequency. For all of a picture
    ``are_zeros_known``: there most of them are even areas, which have none.
    """
    height, width = levels.shape[:2]
    rounding, variance = JpegRounding(levels, jpeg), np.full((height, width), ROUNDING)
    transforms = rounding.transforms_of(levels - 128.0)
    for weight, values, steps in zip(CHANNEL_WEIGHTS, transforms, rounding.steps, strict=True):
        size, is_stored = np.abs(values), np.abs(values) > steps / 2.0
        edge = np.where(is_stored, size * FREQUENCY, 0.0).max((2, 3), keepdims=True)
        hidden = 0.0 if are_zeros_known else np.minimum(steps / 2.0, edge / np.maximum(FREQUENCY, 1.0))
        of_block = np.mean(np.square(np.where(is_stored, steps / 2.0, hidden)) / 3.0, (2, 3))
        variance += weight * _spread(of_block, height, width)
    return variance


def _spread(of_block: Floats, height: int, width: int) -> Floats:
    """Return a value of each block [rows, columns] at all its pixels [h, w]."""
    side = 8 * -(-width // (8 * of_block.shape[1]))
    return of_block.repeat(side, 0).repeat(side, 1)[:height, :width]
