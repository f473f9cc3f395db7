"""Bands of colour for areas that no paint of a drawing shows: ramps of opacity, and ramps of other shapes."""

from __future__ import annotations

import numpy as np

from warpvec.arrays import Floats32, Integers32, Places
from warpvec.flat.constants.regions import REGIONS


def band_numbers(colors: Floats32) -> Integers32:
    """Return the bands [N], from 0, of premultiplied colours [N, 4] along the line on which these vary most."""
    offset = colors - colors.mean(0)
    axis = np.linalg.eigh(np.einsum("ni,nj->ij", offset, offset))[1][:, -1]
    places = offset @ axis
    extent = float(np.ptp(places))
    count = int(np.clip(np.ceil(extent / REGIONS.band_width), 1, REGIONS.bands_max))
    scaled = (places - places.min()) / max(extent, 1.0e-6) * count
    return np.minimum(scaled.astype(np.int32), count - 1)


def split_into_bands(areas: list[Places], colors: Floats32, errors: list[float], noise: float) -> list[Places]:
    """Return ``areas``, with those whose paint leaves too large an error divided into bands.

    The first band takes the place of the area; the others come at the end.

    Args:
        areas: pixels of each area.
        colors: premultiplied colours of all pixels of the picture [h w, 4].
        errors: root mean square that the paint of each area leaves.
        noise: noise of the picture.
    """
    kept, added = list(areas), []
    for index, (pixels, error) in enumerate(zip(areas, errors, strict=True)):
        if error > REGIONS.band_error_min + noise:
            number = band_numbers(colors[pixels])
            bands = [pixels[number == band] for band in np.unique(number)]
            kept[index] = bands[0]
            added += bands[1:]
    return kept + added
