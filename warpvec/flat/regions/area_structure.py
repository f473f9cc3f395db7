"""Refuse a picture whose areas of one paint have the texture of a photo: craters of the moon, clouds in a sky."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats, Floats32, Integers32, Mask
from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.regions.region_growing import NONE
from warpvec.flat.regions.regions import NotFlatArtError, Regions, premultiplied


def require_plain_areas(regions: Regions, image: Floats32) -> None:
    """Refuse ``image`` [h, w, 3 or 4] if its ``regions`` leave both structure and grain deep inside of areas.

    Traces of a JPEG and errors of a tracing lie along edges. Far from these, soft shading of a drawing leaves structure
    without grain, and noise leaves grain without structure. The texture of a photo leaves both.

    Raises:
        NotFlatArtError: they leave more than `REGIONS.structure_max` levels, and `REGIONS.grain_max` of grain.
    """
    is_shown = regions.label != (NONE if regions.canvas is None else regions.canvas)
    is_deep = is_shown & _deep_inside(regions)
    if is_deep.sum() <= REGIONS.deep_share_min * is_shown.sum():
        return
    off, sigma = 255.0 * (regions.mixed() - premultiplied(image))[..., :3], REGIONS.structure_blur
    smooth = ndimage.gaussian_filter(off, (sigma, sigma, 0.0))
    grain = float(np.mean((off - smooth)[is_deep] ** 2))
    structure = float(np.mean(_without_means(smooth[is_deep], regions.label[is_deep]) ** 2))
    structure -= grain / (4.0 * np.pi * sigma**2)  # the pixels over which the Gaussian averages the grain
    if grain > REGIONS.grain_max**2 and structure > REGIONS.structure_max**2:
        raise NotFlatArtError(f"areas of one paint leave {structure**0.5:.1f} levels of texture in them")


def _without_means(values: Floats32, label: Integers32) -> Floats:
    """Return the ``values`` [N, 3] without the mean of each region ``label`` [N]: an offset is no structure."""
    area = np.maximum(np.bincount(label), 1)
    means = np.stack([np.bincount(label, channel) / area for channel in values.T], 1)
    return np.asarray(values - means[label])


def _deep_inside(regions: Regions) -> Mask:
    """Return which pixels [h, w] lie far from all borders of ``regions``."""
    side = 2 * REGIONS.deep + 1
    least = ndimage.minimum_filter(np.minimum(regions.label, regions.other), side)
    most = ndimage.maximum_filter(np.maximum(regions.label, regions.other), side)
    return np.asarray(least == most)
