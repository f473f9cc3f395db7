"""Uneven light on paper, and the picture as it would be in even light.

Paper is what most of each tile of the picture shows. Its level in the tiles, smoothed, is the light.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from PIL import Image
from scipy.ndimage import gaussian_filter, grey_closing, median_filter

from warpvec.arrays import Floats, Floats32
from warpvec.condition.constants import CONDITION


@dataclass(frozen=True, eq=False)
class Light:
    """The light on a sheet of paper.

    Attributes:
        tiles: level of the paper [rows, columns, 3] in [0, 255] in the tiles of the picture.
        range: difference in levels between the darkest and the lightest paper.
    """

    tiles: Floats
    range: float

    def at_pixels(self, height: int, width: int) -> Floats32:
        """Return the level of the paper [height, width, 3], in [0, 1]."""
        planes = (Image.fromarray((plane / 255.0).astype(np.float32)) for plane in np.moveaxis(self.tiles, -1, 0))
        return np.stack([np.asarray(plane.resize((width, height), Image.Resampling.BICUBIC)) for plane in planes], -1)


def find_uneven_light(levels: Floats) -> Light | None:
    """Return the light on the paper that ``levels`` [h, w, 3] in [0, 255] show; None if it is even, or no paper."""
    height, width = levels.shape[:2]
    if min(height, width) < CONDITION.paper_side_min or np.ptp(levels[::4, ::4], 2).mean() > CONDITION.paper_color_max:
        return None
    side = max(8, round(max(height, width) / CONDITION.paper_tiles))
    rows, columns, step = height // side, width // side, max(1, side // 8)
    cut = levels[: rows * side, : columns * side].reshape(rows, side, columns, side, 3)[:, ::step, :, ::step]
    tiles = cut.transpose(0, 2, 1, 3, 4).reshape(rows, columns, -1, 3)
    gray = tiles.mean(3)
    level = np.median(gray, axis=2)
    smooth = _smoothed(level)
    spread = float(np.quantile(gray.std(2), CONDITION.paper_quantile))
    reach = CONDITION.paper_deviations * spread + CONDITION.paper_levels
    near = (np.abs(gray - smooth[..., None]) <= reach).mean()
    brighter = (gray > smooth[..., None] + reach).mean()
    difference = float(np.ptp(smooth))
    if (
        spread > CONDITION.paper_grain_max
        or np.median(np.abs(np.diff(levels[::4].mean(2), 2, axis=1))) < CONDITION.paper_grain_min
        or difference < CONDITION.paper_range_min
        or near < CONDITION.paper_share_min
        or brighter > CONDITION.paper_brighter_max
        or smooth.min() < CONDITION.paper_dark_min
    ):
        return None
    channels = [_smoothed(np.median(tiles[..., k], axis=2)) for k in range(3)]
    return Light(np.stack(channels, -1), difference)


def _smoothed(level: Floats) -> Floats:
    """Return the level [rows, columns] of paper in tiles, by their ``level``: ink on some of them does not count."""
    reach = min(CONDITION.paper_window, *(side - 1 for side in level.shape))
    # Beyond the border the light goes on as it falls before it.
    wider = np.pad(median_filter(level, 3, mode="nearest"), reach, mode="reflect", reflect_type="odd")
    without_ink = gaussian_filter(grey_closing(wider, CONDITION.paper_window), 1.0)
    return np.asarray(without_ink[reach:-reach, reach:-reach].clip(0.0, 255.0))


def in_even_light(pixels: Floats32, light: Light) -> Floats32:
    """Return ``pixels`` [h, w, 3] in [0, 1] with white paper."""
    paper = light.at_pixels(*pixels.shape[:2])
    return (pixels / paper.clip(1.0 / 255.0)).clip(0.0, 1.0).astype(np.float32)
