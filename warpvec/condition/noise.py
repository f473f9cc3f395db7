"""How noisy a picture is, and whether it is noise at all: the same in every flat part, and white.

Each block of a picture is filtered by differences that neither a colour nor a ramp passes. In noise the blocks agree,
and so do two filters, because noise has no memory. The texture of a photo agrees in neither. Source of the filter:
Immerkaer, Fast noise variance estimation, 1996.
"""

from __future__ import annotations

import numpy as np

from warpvec.arrays import Floats, Mask
from warpvec.condition.constants import CONDITION


def measure_noise(levels: Floats) -> tuple[float, ...]:
    """Return the standard deviation of the noise of each channel of ``levels`` [h, w, channels] in [0, 255].

    It is 0 for each channel if the picture has so little that nobody sees it, or so much that it is the picture.
    """
    found = white_noise(levels)
    return found if CONDITION.noise_min <= max(found) <= CONDITION.noise_max else (0.0,) * len(found)


def white_noise(levels: Floats) -> tuple[float, ...]:
    """Return the standard deviation of what is white noise in each channel of ``levels`` [h, w, channels].

    It is 0 for each channel if blocks of the picture do not agree on any.
    """
    side = CONDITION.noise_block if min(levels.shape[:2]) >= CONDITION.noise_side else CONDITION.noise_small_block
    if min(levels.shape[:2]) < CONDITION.noise_rows_min * side:
        return (0.0,) * levels.shape[2]
    channels = [_Blocks(levels[..., k], side) for k in range(levels.shape[2])]
    together = np.sqrt(np.mean([each.deviation**2 for each in channels], 0))
    is_white = np.mean([each.memory for each in channels], 0) <= CONDITION.memory_max
    if is_white.mean() < CONDITION.noise_share_min:
        return (0.0,) * levels.shape[2]
    low = float(np.quantile(together[is_white], CONDITION.noise_quantile))
    is_near = (together >= low / CONDITION.noise_spread) & (together <= low * CONDITION.noise_spread_up)
    agrees = is_white & is_near
    if agrees.mean() < CONDITION.noise_share_min:
        return (0.0,) * levels.shape[2]
    return tuple(each.noise(agrees) for each in channels)


class _Blocks:
    """The blocks of a channel.

    Attributes:
        deviation: standard deviation [count] of each block as if it had nothing but noise.
    """

    def __init__(self, channel: Floats, side: int) -> None:
        """Cut a ``channel`` [h, w] into blocks of ``side`` pixels, spread over it."""
        rows, columns = channel.shape[0] // side, channel.shape[1] // side
        cut = channel[: rows * side, : columns * side].reshape(rows, side, columns, side)
        blocks = cut.transpose(0, 2, 1, 3).reshape(-1, side, side)
        blocks = blocks[:: 1 + len(blocks) // CONDITION.noise_blocks]
        mixed = np.diff(np.diff(blocks, 2, axis=1), 2, axis=2)  # of white noise it has 36 times the variance
        second = np.sqrt((mixed**2).mean((1, 2)) / 36.0)
        steps = [(np.diff(blocks, axis=axis) ** 2).mean((1, 2)) / 4.0 for axis in (1, 2)]
        dark, light = ((blocks == level).mean((1, 2)) for level in (0.0, 255.0))
        is_cut = np.maximum(dark, light) > CONDITION.cut_share
        self._is_spoiled = ~is_cut & (np.maximum(dark, light) > CONDITION.spoiled_share)
        # Half of the noise of black and white is cut off: the other half has half of its mean square.
        level = np.where(dark > light, 0.0, 255.0)
        halves = np.sqrt(2.0 * ((blocks - level[:, None, None]) ** 2).mean((1, 2)))
        self.deviation = np.where(is_cut, halves, second)
        self.memory = np.sqrt(steps[0] + steps[1]) / second.clip(1e-6)

    def noise(self, chosen: Mask) -> float:
        """Return the standard deviation of the noise of the ``chosen`` blocks [count], without that of rounding."""
        whole = chosen & ~self._is_spoiled
        squares = float(np.median(self.deviation[whole if whole.any() else chosen] ** 2)) - 1.0 / 12.0
        return float(np.sqrt(max(squares, 0.0)))
