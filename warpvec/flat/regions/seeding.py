"""The starts of regions: areas of pure pixels that one paint explains."""

from __future__ import annotations

import numpy as np

from warpvec.arrays import Floats32, Integers32, Mask
from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.regions.noise import Tolerances
from warpvec.flat.regions.paint_fitting import fit_areas
from warpvec.flat.regions.region_growing import NONE, grow_seeds, pixels_of, without_small
from warpvec.flat.regions.shading_joining import join_shading
from warpvec.flat.regions.surface_growing import grow_by_surface
from warpvec.watch.watch import UNWATCHED, Watch


def find_seeds(
    picture: Floats32, image: Floats32, tolerances: Tolerances, watch: Watch = UNWATCHED, follows_shading: bool = False
) -> Integers32:
    """Return the areas of pure pixels [h, w], ``NONE`` elsewhere. Noise has none.

    Args:
        picture: premultiplied RGBA [h, w, 4].
        image: the same with straight alpha [h, w, 4].
        tolerances: those of the picture.
        watch: the watch over the run. When it is over, flat areas must do.
        follows_shading: whether areas of a clean picture grow where their shading goes on.
    """
    seen = picture @ tolerances.metric
    if tolerances.noise > 0:
        seeds = without_small(grow_seeds(seen, tolerances.step, REGIONS.noisy_seed_width), REGIONS.noisy_seed_area)
    else:
        flat, steep = (
            without_small(grow_seeds(seen, tolerances.step, REGIONS.clean_seed_width, ramps), REGIONS.clean_seed_area)
            for ramps in (False, True)
        )
        seeds = _without_edges(image, flat, steep, tolerances, watch)
        if follows_shading:
            seeds = join_shading(grow_by_surface(seeds, picture, watch), image, watch)
    if (picture[..., 3] == 0).any():
        seeds[_is_tip(seeds, picture[..., 3])] = NONE
    return without_small(seeds, 1)


def _without_edges(
    image: Floats32, flat: Integers32, steep: Integers32, tolerances: Tolerances, watch: Watch
) -> Integers32:
    """Return the areas ``steep`` [h, w], with the areas ``flat`` in place of those that no paint explains."""
    flat_numbers = flat.ravel()
    areas = [pixels for pixels in pixels_of(steep) if np.ptp(flat_numbers[pixels]) > 0 or flat_numbers[pixels[0]] < 0]
    fits = fit_areas(areas, image.reshape(-1, 4), flat.shape[1], tolerances, watch)
    seeds = steep.copy()
    for pixels, error in zip(areas, fits.errors, strict=True):
        if error > REGIONS.steep_ramp_error:
            numbers = flat_numbers[pixels]
            seeds.reshape(-1)[pixels] = np.where(numbers == NONE, NONE, numbers + steep.max() + 1)
    return seeds


def _is_tip(seeds: Integers32, alpha: Floats32) -> Mask:
    """Return the pixels [h, w] of small areas that look translucent, but are the tips of opaque shapes."""
    count = np.bincount(seeds[seeds != NONE], minlength=seeds.max() + 1)
    is_small = np.append(count < REGIONS.translucent_area_min, False)  # The last is for the pixels of no area.
    return is_small[seeds] & (alpha > 0) & (alpha < 1)
