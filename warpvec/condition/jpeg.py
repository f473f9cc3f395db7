"""The quality that a picture was saved with as JPEG, and whether its colours have half of the resolution.

JPEG rounds the cosine transform of each block of 8 x 8 pixels to multiples of the steps of a table, which one number
scales, the quality. Decoded, the transform still lies near these multiples. Source: Fan and de Queiroz, Identification
of bitmap compression history, 2003; the table: ITU-T T.81, annex K; its scale: libjpeg.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec.arrays import Floats
from warpvec.condition.constants import CONDITION
from warpvec.condition.enlargement import busiest
from warpvec.condition.resampling import Upsampling
from warpvec.image.luma import LUMA

_STEPS = np.array([
    [16, 11, 10, 16, 24, 40, 51, 61], [12, 12, 14, 19, 26, 58, 60, 55], [14, 13, 16, 24, 40, 57, 69, 56],
    [14, 17, 22, 29, 51, 87, 80, 62], [18, 22, 37, 56, 68, 109, 103, 77], [24, 35, 55, 64, 81, 104, 113, 92],
    [49, 64, 78, 87, 103, 121, 120, 101], [72, 92, 95, 98, 112, 100, 103, 99],
])  # fmt: skip
"""Steps of brightness at quality 50, by vertical and horizontal frequency."""

_COLOR_STEPS = np.full((8, 8), 99)
"""Steps of the colour differences at quality 50."""

_COLOR_STEPS[:4, :4] = [[17, 18, 24, 47], [18, 21, 26, 66], [24, 26, 56, 99], [47, 66, 99, 99]]

_LUMA = np.array(LUMA)
_COLOR = np.array([[-0.168736, -0.331264, 0.5], [0.5, -0.418688, -0.081312]])
JFIF = np.concatenate([_LUMA[None], _COLOR])
"""Weights of red, green and blue in the brightness and the two colour differences of JFIF [3, 3]."""


@dataclass(frozen=True)
class Jpeg:
    """What is known of the JPEG that a picture was saved as.

    Attributes:
        quality: from 1 to 100, as libjpeg counts it.
        is_subsampled: whether the colours were stored with half of the resolution along both axes.
    """

    quality: int
    is_subsampled: bool


def steps_of(quality: int) -> Floats:
    """Return the steps [8, 8] of brightness at a ``quality`` from 1 to 100, as libjpeg scales them."""
    return _scaled(_STEPS, quality)


def color_steps_of(quality: int) -> Floats:
    """Return the steps [8, 8] of both colour differences at a ``quality`` from 1 to 100, as libjpeg scales them."""
    return _scaled(_COLOR_STEPS, quality)


def _scaled(steps: NDArray[np.int64], quality: int) -> Floats:
    scale = 5000 // quality if quality < 50 else 200 - 2 * quality
    return np.clip((steps * scale + 50) // 100, 1, 255).astype(np.float64)


def find_jpeg(levels: Floats) -> Jpeg | None:
    """Return the JPEG that ``levels`` [h, w, 3] in [0, 255] were saved as; None if they were not, or hardly changed.

    The grid of blocks is looked for at the upper left corner, not in cropped pictures.
    """
    quality = _quality_of(levels)
    return None if quality is None else Jpeg(quality, _is_subsampled(levels))


def _quality_of(levels: Floats) -> int | None:
    """Return the quality by the brightness of ``levels`` [h, w, 3]; None if it was not rounded."""
    blocks = _telling_blocks(levels)
    if (np.diff(blocks, axis=2) == 0.0).sum() > CONDITION.jpeg_equal_max * 56 * len(blocks):
        return None  # a block that JPEG has changed has ringing, not areas of one level
    from scipy.fft import dctn  # a tenth of a second, which clean pictures need not

    transform = np.abs(dctn(blocks, axes=(1, 2), norm="ortho"))
    order = np.add.outer(range(8), range(8))
    rows, columns = np.nonzero((order > 0) & (order <= CONDITION.jpeg_frequency_max))
    # Equal blocks, such as those along a level edge, are one witness.
    found = [np.unique(np.round(transform[:, row, column], 1)) for row, column in zip(rows, columns, strict=True)]
    found = [values[values > CONDITION.jpeg_rounding] for values in found]
    values, place = np.concatenate(found), np.repeat(np.arange(len(found)), [len(each) for each in found])
    if len(values) < CONDITION.jpeg_values_min:
        return None
    scores = [_score(values / steps_of(quality)[rows, columns][place]) for quality in _QUALITIES]
    best = int(np.argmax(scores))
    least = CONDITION.jpeg_score_min + 1.0 / np.sqrt(len(values))
    return _QUALITIES[best] if scores[best] >= least else None


_QUALITIES = range(5, 96)


def _score(multiples: Floats) -> float:
    """Return how near ``multiples`` [N] of steps are to whole ones: 1 at best, about 0 by chance.

    Those that would have been rounded to 0 count as chance.
    """
    return float(np.where(multiples > 0.5, np.cos(2.0 * np.pi * multiples), 0.0).mean())


def _telling_blocks(levels: Floats) -> Floats:
    """Return the brightness [N, 8, 8] of the blocks of the grid of JPEG that tell most: those of ``levels`` [h, w, 3].

    They change much, and few of their pixels touch the range's ends, at which a decoder cuts the picture off.
    """
    rows, columns = levels.shape[0] // 8, levels.shape[1] // 8

    def blocks_of(plane: NDArray[Any]) -> NDArray[Any]:
        cut = plane[: 8 * rows, : 8 * columns].reshape(rows, 8, columns, 8)
        return cut.transpose(0, 2, 1, 3).reshape(-1, 8, 8)

    luma = blocks_of(levels @ _LUMA)
    channels = list(np.moveaxis(levels, -1, 0))
    is_cut_off = (np.maximum.reduce(channels) >= 255.0) | (np.minimum.reduce(channels) <= 0.0)
    cut_off = blocks_of(is_cut_off).mean((1, 2))
    change = np.ptp(luma, axis=(1, 2)) if len(luma) else np.zeros(0)
    whole = change * (cut_off <= CONDITION.jpeg_cut_off_max)
    if (whole > CONDITION.jpeg_change_min).sum() < CONDITION.jpeg_whole_blocks_min:
        whole = change * (1.0 - 0.9 * cut_off)
    order = np.argsort(-whole, kind="stable")[: CONDITION.jpeg_blocks]
    return luma[order[whole[order] > 0]]


def _is_subsampled(levels: Floats) -> bool:
    """Return whether the colour differences of ``levels`` [h, w, 3] were enlarged twice, as decoders do it."""
    planes = [levels @ weights for weights in _COLOR]
    rows = busiest(max(planes, key=lambda plane: float(np.abs(np.diff(plane, axis=1)).sum())))
    rows = rows[: len(rows) // 2 * 2]
    change = float(np.sqrt((np.diff(rows, axis=0) ** 2).mean()))
    return (
        change > 0.0
        and Upsampling(len(rows), len(rows) // 2, "bilinear").unexplained(rows) <= CONDITION.jpeg_color_max * change
    )
