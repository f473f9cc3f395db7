"""How blurred the edges of a picture are, beyond the anti-aliasing of a renderer.

The picture is blurred by two known amounts. At a straight edge that a Gaussian has blurred, the ratio of the two slopes
gives its deviation. Source: Zhuo and Sim, Defocus map estimation from a single image, 2011.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from scipy.ndimage import gaussian_filter, maximum_filter

from warpvec.arrays import Floats
from warpvec.condition.constants import CONDITION


class EdgeBlur(NamedTuple):
    """The blur of the edges of a picture.

    Attributes:
        deviation: standard deviation in pixels; 0 if edges are sharp.
        is_even: whether nearly all edges have it, so that it came over the whole picture, and was not drawn.
    """

    deviation: float
    is_even: bool


SHARP = EdgeBlur(0.0, False)
"""No blur."""


def measure_blur(gray: Floats, noise: float = 0.0) -> EdgeBlur:
    """Return the blur of ``gray`` [h, w] in [0, 255]; ``noise`` is the standard deviation of the picture's noise."""
    tiles = _tiles(gray)
    if not len(tiles):
        return SHARP
    usual, least = 0.0, math.nan
    for fine, coarse in CONDITION.blur_pairs:
        spreads = _spreads(tiles, fine, coarse, noise)
        if spreads is None:
            break
        low, middle = np.sqrt(np.maximum(spreads - CONDITION.antialiasing, 0.0)).tolist()
        usual = max(usual, middle)
        least = low if math.isnan(least) else least  # the finest pair tells best where edges are sharp
        if usual < fine * CONDITION.blur_reach:
            break
    if usual < CONDITION.blur_min:
        return SHARP
    return EdgeBlur(usual, least >= CONDITION.blur_even_share * usual)


def _tiles(gray: Floats) -> Floats:
    """Return the tiles [count, side, side] of ``gray`` [h, w] with the most edges."""
    side = min(CONDITION.blur_tile, *gray.shape)
    rows, columns = gray.shape[0] // side, gray.shape[1] // side
    if side < CONDITION.side_min:
        return np.zeros((0, side, side))
    cut = gray[: rows * side, : columns * side].reshape(rows, side, columns, side)
    tiles = cut.transpose(0, 2, 1, 3).reshape(-1, side, side)
    activity = (np.diff(tiles, axis=1) ** 2).sum((1, 2)) + (np.diff(tiles, axis=2) ** 2).sum((1, 2))
    chosen = np.argsort(-activity)[: CONDITION.blur_tiles]
    return tiles[np.sort(chosen[activity[chosen] > 0])]


def _spreads(tiles: Floats, fine: float, coarse: float, noise: float) -> Floats | None:
    """Return the least and the usual variance [2] of the edges of ``tiles`` [count, side, side]; None without edges."""
    slopes = [_slope(tiles, deviation) for deviation in (fine, coarse)]
    margin = round(coarse) + 1
    is_top = slopes[0] >= maximum_filter(slopes[0], (1, 3, 3)) * 0.98
    inner = np.zeros(tiles.shape, bool)
    inner[:, margin:-margin, margin:-margin] = True
    least = max(CONDITION.blur_slope_share * slopes[0].max(), CONDITION.blur_noise_factor * noise / fine**2, 1.0)
    chosen = is_top & inner & (slopes[0] > least)
    if chosen.sum() < CONDITION.blur_edges_min:
        return None
    ratio = (slopes[0][chosen] / slopes[1][chosen].clip(1e-6)) ** 2
    variance = (coarse**2 - ratio * fine**2) / (ratio - 1.0).clip(1e-3)
    return np.asarray(np.quantile(variance.clip(0.0, 400.0), [CONDITION.blur_least_quantile, CONDITION.blur_quantile]))


def _slope(tiles: Floats, deviation: float) -> Floats:
    across, down = (
        gaussian_filter(tiles, (0, deviation, deviation), order, truncate=3.0) for order in ((0, 0, 1), (0, 1, 0))
    )
    return np.asarray(np.hypot(across, down))
