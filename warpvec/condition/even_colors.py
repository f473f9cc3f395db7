"""The colours of even areas, and which pixels beside edges show nothing but one of them and a rim.

A kernel with negative weights makes a rim at each edge: the even colour there goes on beyond itself, away from what
lies on the other side. So a rim is told from a thin line by the direction of its colour, not by its strength alone.
Colours have C channels: three, or four premultiplied ones.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats32, Integers, Mask
from warpvec.condition.constants import CONDITION
from warpvec.image.spread import largest_channel, spread


class EvenAreas(NamedTuple):
    """The even areas of a picture.

    Attributes:
        is_inside: pixels [h, w] in a square of one colour.
        is_still: those, and the inside of gradients [h, w]: no rim reaches them.
        colors: the most frequent colours [n, C] of even areas, in [0, 1].
    """

    is_inside: Mask
    is_still: Mask
    colors: Floats32

    @property
    def gradient_share(self) -> float:
        """The share of gradients in what is still."""
        return 1.0 - float(self.is_inside.sum()) / max(float(self.is_still.sum()), 1.0)


def find_even_areas(pixels: Floats32) -> EvenAreas:
    """Return the even areas of ``pixels`` [h, w, C], in [0, 1]."""
    is_even = ndimage.maximum_filter(spread(pixels) <= CONDITION.even_range, 3)
    bend = np.zeros(pixels.shape[:2], np.float32)
    bend[:, 1:-1] = largest_channel(np.abs(np.diff(pixels, 2, axis=1)))
    bend[1:-1] = np.maximum(bend[1:-1], largest_channel(np.abs(np.diff(pixels, 2, axis=0))))
    is_straight = ndimage.maximum_filter(bend, 3) <= CONDITION.still_bend
    return EvenAreas(is_even, is_even | is_straight, _frequent_colors(pixels[is_even]))


def _frequent_colors(colors: Floats32) -> Floats32:
    """Return the most frequent of the ``colors`` [N, C], the first one first; those next to a more frequent one go."""
    channels = colors.shape[1]
    steps = 256 ** np.arange(channels)[::-1]
    codes, counts = np.unique(np.rint(255.0 * colors).astype(np.int64) @ steps, return_counts=True)
    order = np.argsort(-counts, kind="stable")[: 4 * CONDITION.even_colors_max]
    kept: list[Integers] = []
    for code, count in zip(codes[order], counts[order], strict=True):
        color = code // steps % 256
        is_apart = all(np.abs(color - each).max() > CONDITION.even_apart for each in kept)
        if count >= CONDITION.even_pixels_min and is_apart and len(kept) < CONDITION.even_colors_max:
            kept.append(color)
    return np.array(kept, np.float32).reshape(-1, channels) / np.float32(255)


def on_even_colors(pixels: Floats32, given: Floats32, areas: EvenAreas) -> tuple[Floats32, Mask]:
    """Put each pixel that shows an even colour, or a rim of one, on that colour.

    Return the picture [h, w, C], and which of its pixels [h, w] are on an even colour.

    Args:
        pixels: the picture, or one that has lost some of its rims [h, w, C].
        given: the picture [h, w, C], which is as it is where it is still.
        areas: its even areas.
    """
    result = np.where(areas.is_still[..., None], given, pixels)
    rows, columns = np.nonzero(~areas.is_still)
    around = _around(result, rows, columns)
    values, nearest = result[rows, columns], np.full(len(rows), np.inf, np.float32)
    found = values.copy()
    for color in areas.colors:
        is_shown = areas.is_inside & (np.abs(given - color).max(2) <= CONDITION.even_range)
        is_near = ndimage.maximum_filter(is_shown, 2 * CONDITION.even_reach + 1)[rows, columns]
        distance = np.abs(values - color).max(1)
        chosen = np.flatnonzero(is_near & (distance <= CONDITION.rim_share) & (distance < nearest))
        chosen = chosen[_shows(color, values[chosen], around[:, chosen])]
        found[chosen], nearest[chosen] = color, distance[chosen]
    result[rows, columns] = found
    is_on = areas.is_inside.copy()
    is_on[rows, columns] |= np.isfinite(nearest)
    return result, is_on


def _around(pixels: Floats32, rows: Integers, columns: Integers) -> Floats32:
    """Return the colours [P, N, C] of the square of pixels around each of N pixels."""
    reach = CONDITION.rim_reach
    padded = np.pad(pixels, ((reach, reach), (reach, reach), (0, 0)), mode="edge")
    steps = range(2 * reach + 1)
    return np.stack([padded[rows + down, columns + right] for down in steps for right in steps])


def _shows(color: Floats32, values: Floats32, around: Floats32) -> Mask:
    """Return which of the colours ``values`` [N, C] are about ``color`` [C], or a rim of it against one ``around``.

    Args:
        color: an even colour.
        values: colours of pixels.
        around: the colours around each of them [P, N, C].
    """
    beyond = values - color
    length = np.linalg.norm(beyond, axis=1)
    is_rim = np.zeros(len(values), bool)
    for other in around - color:
        against, far = -(other * beyond).sum(1), np.linalg.norm(other, axis=1)
        is_rim |= (against >= CONDITION.rim_cosine * length * far) & (length <= CONDITION.rim_share * far)
    return is_rim | (np.abs(beyond).max(1) <= CONDITION.even_snap)


def limits(pixels: Floats32, is_on: Mask) -> tuple[Floats32, Floats32]:
    """Return the least and the largest value of each channel [h, w, C] that an even colour beside a pixel allows.

    That is 0 or 1 where the pixels around go beyond all even colours.

    Args:
        pixels: the picture [h, w, C] on its even colours.
        is_on: which pixels [h, w] are on an even colour.
    """
    side = 2 * CONDITION.rim_reach + 1
    size, inside = (side, side, 1), is_on[..., None]
    least, most = ndimage.minimum_filter(pixels, size), ndimage.maximum_filter(pixels, size)
    lowest = ndimage.minimum_filter(np.where(inside, pixels, np.float32(2.0)), size)
    highest = ndimage.maximum_filter(np.where(inside, pixels, np.float32(-1.0)), size)
    low = np.where(lowest <= least + CONDITION.even_range, lowest, np.float32(0.0))
    return low, np.where(highest >= most - CONDITION.even_range, highest, np.float32(1.0))
