"""Outlines of thin parts on a grid finer than pixels: a stroke narrower than a pixel may cover no pixel by half.

The sub-pixels of a smooth field are full above its half level and empty below. The field is corrected until those of
each pixel have its coverage. Source of the idea: sub-pixel mapping in remote sensing, Atkinson, 1997.
"""

from __future__ import annotations

import numpy as np
from PIL import Image

from warpvec.arrays import Floats
from warpvec.flat.constants.lettering import LETTERING
from warpvec.flat.curves.contours import interpolated_contours

_MARGIN = 2
"""Pixels around the coverage, so that the smooth field falls to nothing there."""


def fine_contours_of(coverage: Floats) -> list[Floats]:
    """Return the closed contours [n, 2] of ``coverage`` [h, w] as `warpvec.flat.curves.contours.contours_of` does."""
    return interpolated_contours(fine_field(np.pad(coverage, _MARGIN)), _MARGIN, LETTERING.fineness)


def fine_field(coverage: Floats) -> Floats:
    """Return a field [f h, f w] of sub-pixels, whose area above 0.5 in each pixel is its ``coverage`` [h, w]."""
    field = _enlarged(coverage)
    for _ in range(LETTERING.rounds):
        full = np.clip(0.5 + LETTERING.steepness * (field - 0.5), 0.0, 1.0)
        field += _enlarged(coverage - _means(full)) / LETTERING.steepness
    return field


def _enlarged(values: Floats) -> Floats:
    """Return ``values`` [h, w] interpolated at the sub-pixels of their pixels [f h, f w]."""
    height, width = values.shape
    size = LETTERING.fineness * width, LETTERING.fineness * height
    image = Image.fromarray(values.astype(np.float32)).resize(size, Image.Resampling.BICUBIC)
    return np.asarray(image, np.float64)


def _means(field: Floats) -> Floats:
    """Return the means [h, w] of the sub-pixels of each pixel of ``field`` [f h, f w]."""
    fine = LETTERING.fineness
    height, width = field.shape
    return np.asarray(field.reshape(height // fine, fine, width // fine, fine).mean((1, 3)))
