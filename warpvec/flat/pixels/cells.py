"""The cells of pixel art: a colour for each, of a few."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from warpvec.arrays import Floats32, Integers
from warpvec.flat.constants.pixels import PIXELS


@dataclass(frozen=True, eq=False)
class Cells:
    """A picture of few colours.

    Attributes:
        label: number of the colour of each pixel [h, w].
        colors: straight RGBA of each colour [C, 4], whole levels in [0, 255]; what is invisible is 0.
    """

    label: Integers
    colors: Integers

    @property
    def counts(self) -> Integers:
        """Number of pixels of each colour [C]."""
        return np.bincount(self.label.ravel(), minlength=len(self.colors)).astype(np.int64)


def find_cells(image: Floats32, tolerance: int = 0, color_count: int = PIXELS.colors_max) -> Cells:
    """Return the cells of ``image`` [h, w, 3 or 4] in [0, 1], with straight alpha if it has four channels.

    Args:
        image: a pixel for each cell.
        tolerance: largest difference of a channel, in levels, between colours that were one.
        color_count: most colours; more are reduced to as many by median cuts.
    """
    levels = np.rint(255.0 * image).astype(np.int64)
    if levels.shape[2] == 3:
        levels = np.concatenate([levels, np.full_like(levels[..., :1], 255)], 2)
    levels[levels[..., 3] == 0] = 0
    colors, label, counts = np.unique(levels.reshape(-1, 4), axis=0, return_inverse=True, return_counts=True)
    label = label.reshape(levels.shape[:2])
    if tolerance:
        colors, label = _merged(colors, label, counts, tolerance)
    if len(colors) > color_count:
        colors, label = _reduced(levels, color_count)
    return Cells(label.astype(np.int64), colors.astype(np.int64))


def _merged(
    colors: NDArray[np.int64], label: NDArray[np.int64], counts: NDArray[np.int64], tolerance: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the ``colors`` [C, 4] and ``label`` [h, w] with each colour given to a frequent one near it.

    The colour of a group is the median of its pixels.
    """
    order = np.argsort(-counts, kind="stable")
    centers: list[int] = []
    group = np.zeros(len(colors), np.int64)
    for color in order.tolist():
        distance = np.abs(colors[centers] - colors[color]).max(1) if centers else np.zeros(0)
        if len(centers) and distance.min() <= tolerance:
            group[color] = int(distance.argmin())
        else:
            group[color] = len(centers)
            centers.append(color)
    # A rare colour beside a frequent one is rather JPEG's than the artist's.
    sizes = np.bincount(group, counts)
    is_rare = sizes < PIXELS.jpeg_rare_share * counts.sum()
    target = np.arange(len(centers))
    for rare in np.flatnonzero(is_rare):
        distance = np.abs(colors[centers] - colors[centers[rare]]).max(1)
        distance[is_rare] = 256
        if distance.min() <= 2 * tolerance:
            target[rare] = int(distance.argmin())
    _, group = np.unique(target[group], return_inverse=True)
    levels, owner = np.repeat(colors, counts, axis=0), np.repeat(group, counts)
    medians = [np.median(levels[owner == number], axis=0) for number in range(int(group.max()) + 1)]
    return np.rint(medians).astype(np.int64), group[label]


def _reduced(levels: NDArray[np.int64], count: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return ``count`` colours [C, 4] for the ``levels`` [h, w, 4], and the number of each pixel's [h, w]."""
    picture = Image.fromarray(levels.astype(np.uint8), "RGBA")
    reduced = picture.quantize(count, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE).convert("RGBA")
    again = np.asarray(reduced).astype(np.int64)
    again[again[..., 3] == 0] = 0
    colors, label = np.unique(again.reshape(-1, 4), axis=0, return_inverse=True)
    return colors, label.reshape(levels.shape[:2])
