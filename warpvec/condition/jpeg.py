"""The quality that a picture was saved with as JPEG, and whether its colours have half of the resolution.

JPEG rounds the cosine transform of each block of 8 x 8 pixels to multiples of the steps of a table, which one number
scales, the quality. So a decoded block, rounded to the same steps, stays as it is, and another does not. Source: Farid,
Exposing digital forgeries from JPEG ghosts, 2009; the table: ITU-T T.81, annex K; its scale: libjpeg.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from warpvec.arrays import Floats, Mask
from warpvec.condition.constants import CONDITION
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
    return None if quality is None else Jpeg(quality, _is_subsampled(levels, quality))


def _quality_of(levels: Floats) -> int | None:
    """Return the quality by the brightness of ``levels`` [h, w, 3]; None if it was not rounded."""
    blocks = _telling_blocks(levels, _LUMA)
    if (np.diff(blocks.values, axis=2) == 0.0).sum() > CONDITION.jpeg_equal_max * 56 * len(blocks.values):
        return None  # a block that JPEG has changed has ringing, not areas of one level
    witnesses = [_witnesses(blocks, steps_of(quality)) for quality in _QUALITIES]
    best = int(np.argmax([bits.sum() for bits in witnesses]))
    least = max(CONDITION.jpeg_blocks_min, CONDITION.jpeg_share_min * len(blocks.values))
    return _QUALITIES[best] if len(witnesses[best]) >= least else None


_QUALITIES = range(5, 96)


class _Blocks(NamedTuple):
    """Blocks of the grid of JPEG.

    Attributes:
        values: brightness, or one of the colour differences [N, 8, 8], about 0.
        is_cut: whether a channel of a pixel [N, 8, 8] is at an end of the range, at which a decoder cuts it off.
    """

    values: Floats
    is_cut: Mask


def _witnesses(blocks: _Blocks, steps: Floats) -> Floats:
    """Return the bits [M] by which each block says that it was rounded to multiples of ``steps`` [8, 8].

    A block says so if these multiples are decoded to exactly its pixels, apart from those that were cut off. Of those
    the decoded block knows more than the picture, so they are replaced and the block is rounded once more. A value of
    the transform that lies on a multiple by chance does so the more seldom the larger its step is, which makes the
    bits; a block with few pixels that were not cut off can meet them by chance, and says less.
    """
    from scipy.fft import dctn, idctn  # a tenth of a second, which clean pictures need not

    values = blocks.values
    for _ in range(CONDITION.jpeg_cut_rounds):
        multiples = np.rint(dctn(values, axes=(1, 2), norm="ortho") / steps)
        decoded = idctn(multiples * steps, axes=(1, 2), norm="ortho")
        values = np.where(blocks.is_cut, decoded, blocks.values)
    is_exact = (np.abs(decoded - values) <= CONDITION.jpeg_rounding).all((1, 2))
    bits_of_steps = np.log2(np.maximum(steps / (3.0 * CONDITION.jpeg_rounding), 1.0))
    bits_of_steps[0, 0] = 0.0  # the mean of a flat block lies anywhere
    bits = ((multiples != 0.0) * bits_of_steps).sum((1, 2)) * (~blocks.is_cut).mean((1, 2))
    return np.asarray(bits[is_exact & (bits >= CONDITION.jpeg_bits_min)])


def _telling_blocks(levels: Floats, weights: Floats) -> _Blocks:
    """Return the blocks that tell most, each once: they change much, and little of them is cut off.

    Args:
        levels: the picture [h, w, 3] in [0, 255].
        weights: of its channels [3], for the brightness or a colour difference.
    """
    values = _blocks_of((levels - 128.0) @ weights)
    is_cut = _blocks_of(np.asarray(((levels >= 255.0) | (levels <= 0.0)).any(2)))
    change = np.ptp(values, axis=(1, 2)) if len(values) else np.zeros(0)
    telling = np.where(change > CONDITION.jpeg_change_min, change * (~is_cut).mean((1, 2)), 0.0)
    order = np.argsort(-telling, kind="stable")[: CONDITION.jpeg_blocks]
    order = order[telling[order] > 0.0]
    # Equal blocks, such as those along a level edge or of mirrored corners, are one witness.
    keys = {_key(values[index].round(1)): index for index in order[::-1]}
    order = np.array(sorted(keys.values()), np.int64)
    return _Blocks(values[order], is_cut[order])


def _key(block: Floats) -> bytes:
    """Return what a block [8, 8] and its mirror images share: JPEG rounds all of them alike."""
    return min(each.tobytes() for half in (block, block[::-1]) for each in (half, half[:, ::-1]))


def _blocks_of(plane: NDArray[Any]) -> NDArray[Any]:
    """Return the whole blocks [N, 8, 8] of ``plane`` [h, w]."""
    rows, columns = plane.shape[0] // 8, plane.shape[1] // 8
    cut = plane[: 8 * rows, : 8 * columns].reshape(rows, 8, columns, 8)
    return cut.transpose(0, 2, 1, 3).reshape(-1, 8, 8)


def _is_subsampled(levels: Floats, quality: int) -> bool:
    """Return whether the colours of ``levels`` [h, w, 3] were stored with half of the resolution at a ``quality``.

    Then they change, but no block says that they were rounded at full resolution.
    """
    blocks = [_telling_blocks(levels, weights) for weights in _COLOR]
    witnesses = [_witnesses(each, color_steps_of(quality)) for each in blocks]
    return any(len(each.values) for each in blocks) and not any(map(len, witnesses))
