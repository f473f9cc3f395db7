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
            return Evidence(levels, np.full(3, _deviation_of(levels, jpeg)), jpeg)
        return Evidence(levels, np.sqrt(ROUNDING + np.square(white_noise(levels))))

    @cached_property
    def literal_nats(self) -> float:
        """Nats of a pixel that is stated by itself, over those of one that a drawing shows exactly.

        It may have any of 256 levels in each channel; the drawing leaves those within the deviation.
        """
        found = np.log(np.maximum(LEVEL_COUNT / (self.sigma * math.sqrt(2.0 * math.pi)), 1.0))
        return float(found.sum())

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
            spread = of_block.repeat(side, 0).repeat(side, 1)[:height, :width]
            nats += spread / side**2
        return nats


def _deviation_of(levels: Floats, jpeg: Jpeg) -> float:
    """Return the deviation in levels that the steps of ``jpeg`` leave in a picture [h, w, 3].

    A value of the transform that is stored as 0 was small, and hardly changed.
    """
    rounding = JpegRounding(levels, jpeg)
    squares = [
        float(np.mean(np.square(steps) / 12.0 * (np.abs(values) > steps / 2.0)))
        for values, steps in zip(rounding.transforms_of(levels - 128.0), rounding.steps, strict=True)
    ]
    return math.sqrt(ROUNDING + (squares[0] + 2.0 * squares[1] + 2.0 * squares[2]) / 3.0)
