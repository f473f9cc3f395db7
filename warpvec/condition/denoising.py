"""The picture before its noise: each pixel is the mean of those whose surroundings look alike.

The surroundings of two pixels differ by twice the variance of the noise if the drawing is the same there, so that the
measured noise says how alike is alike. Along an edge, pixels with the same mix of two colours find each other, and the
edge stays as sharp as it was. Source: Buades, Coll and Morel, A non-local algorithm for image denoising, 2005.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import uniform_filter

from warpvec.arrays import Floats, Floats32
from warpvec.condition.constants import CONDITION


def before_noise(pixels: Floats32, noise: tuple[float, ...]) -> Floats32:
    """Return ``pixels`` [h, w, 3] in [0, 1] without their ``noise``: its deviation in levels, for each channel."""
    deviation = np.maximum(np.array(noise, np.float32), CONDITION.denoised_min)
    levels = _mean_of_alike((np.float32(255.0) * pixels / deviation).astype(np.float32)) * deviation
    channels = [_before_cut_off(levels[..., k], float(deviation[k])) for k in range(levels.shape[2])]
    return np.asarray(np.stack(channels, -1) / 255.0, np.float32)


def _mean_of_alike(values: Floats32) -> Floats32:
    """Return for each pixel of ``values`` [h, w, channels], whose noise is 1, the mean of those like it nearby."""
    height, width = values.shape[:2]
    reach = min(CONDITION.alike_reach, height - 1, width - 1)
    total, weight = values.copy(), np.ones((height, width, 1), np.float32)
    shifts = [
        (down, right) for down in range(reach + 1) for right in range(-reach, reach + 1) if (down, right) > (0, 0)
    ]
    for down, right in shifts:
        # Two pixels that are alike are so from either side: half of the shifts tell all.
        here = np.s_[: height - down, max(0, -right) : width - max(0, right)]
        there = np.s_[down:, max(0, right) : width + min(0, right)]
        difference = np.square(values[there] - values[here]).mean(2)
        beyond_noise = uniform_filter(difference, CONDITION.alike_side, mode="nearest") - np.float32(2.0)
        alike = np.exp(beyond_noise.clip(0.0) * np.float32(-1.0 / CONDITION.alike_spread**2))[..., None]
        total[here] += alike * values[there]
        total[there] += alike * values[here]
        weight[here] += alike
        weight[there] += alike
    return np.asarray(total / weight, np.float32)


def _before_cut_off(mean: Floats32, deviation: float) -> Floats:
    """Return the levels whose noisy copies, cut off at 0 and 255, have the ``mean`` [h, w]: white becomes white."""
    levels = np.arange(256.0)
    means = levels + _shift(levels / deviation) * deviation - _shift((255.0 - levels) / deviation) * deviation
    return np.interp(mean, means, levels)


def _shift(distance: Floats) -> Floats:
    """Return by how much the mean of normal noise moves when it is cut off at so many deviations below the mean."""
    from scipy.special import ndtr  # a tenth of a second, which clean pictures need not

    return np.exp(-0.5 * distance**2) / np.sqrt(2.0 * np.pi) - distance * ndtr(-distance)
