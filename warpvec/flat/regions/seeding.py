"""The starts of regions: areas of pure pixels that one paint explains."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from warpvec.flat.regions.denoising import Tolerances
from warpvec.flat.regions.paint_fitting import fit_areas
from warpvec.flat.regions.region_growing import NONE, grow_seeds, pixels_of, without_small

Floats = NDArray[np.float32]
Integers = NDArray[np.int32]

CLEAN_WIDTH, NOISY_WIDTH = 2, 3
"""Sides in pixels of squares of pure pixels in clean and in noisy pictures."""

CLEAN_AREA, NOISY_AREA = 4, 12
"""Smaller areas of pure pixels are not trusted: one square of two pixels in clean pictures, more in noisy ones."""

TRANSLUCENT_AREA_MIN = 24
"""Smaller translucent areas of pure pixels are not trusted: tips of shapes cover pixels by half for a while."""

RAMP_ERROR = 2.5 / 255
"""Root mean square up to which a paint explains an area with steep parts. If none does, the steep parts are edges."""


def find_seeds(picture: Floats, image: Floats, tolerances: Tolerances, is_over: Callable[[], bool] = bool) -> Integers:
    """Return the areas of pure pixels [h, w], ``NONE`` elsewhere. Noise has none.

    Args:
        picture: premultiplied RGBA [h, w, 4].
        image: the same with straight alpha [h, w, 4].
        tolerances: those of the picture.
        is_over: says whether flat areas must do.
    """
    seen = picture @ tolerances.metric
    if tolerances.noise > 0:
        seeds = without_small(grow_seeds(seen, tolerances.step, NOISY_WIDTH), NOISY_AREA)
    else:
        flat, steep = (
            without_small(grow_seeds(seen, tolerances.step, CLEAN_WIDTH, ramps), CLEAN_AREA) for ramps in (False, True)
        )
        seeds = _without_edges(image, flat, steep, tolerances, is_over)
    if (picture[..., 3] == 0).any():
        seeds[_is_tip(seeds, picture[..., 3])] = NONE
    return without_small(seeds, 1)


def _without_edges(
    image: Floats, flat: Integers, steep: Integers, tolerances: Tolerances, is_over: Callable[[], bool]
) -> Integers:
    """Return the areas ``steep`` [h, w], with the areas ``flat`` in place of those that no paint explains."""
    flat_numbers = flat.ravel()
    areas = [pixels for pixels in pixels_of(steep) if np.ptp(flat_numbers[pixels]) > 0 or flat_numbers[pixels[0]] < 0]
    fits = fit_areas(areas, image.reshape(-1, 4), flat.shape[1], tolerances, is_over)
    seeds = steep.copy()
    for pixels, error in zip(areas, fits.errors, strict=True):
        if error > RAMP_ERROR:
            numbers = flat_numbers[pixels]
            seeds.reshape(-1)[pixels] = np.where(numbers == NONE, NONE, numbers + steep.max() + 1)
    return seeds


def _is_tip(seeds: Integers, alpha: Floats) -> NDArray[np.bool_]:
    """Return the pixels [h, w] of small areas that look translucent, but are the tips of opaque shapes."""
    count = np.bincount(seeds[seeds != NONE], minlength=seeds.max() + 1)
    is_small = np.append(count < TRANSLUCENT_AREA_MIN, False)  # The last is for the pixels of no area.
    return is_small[seeds] & (alpha > 0) & (alpha < 1)
