"""Regions that look like lines: bands of one width that are much longer than wide."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from warpvec.arrays import Integers32, Mask
from warpvec.flat.constants.layers import LAYERS
from warpvec.watch.watch import UNWATCHED, Watch


def line_regions(label: Integers32, count: int, watch: Watch = UNWATCHED) -> Mask:
    """Return which of ``count`` regions of the map ``label`` [h, w] are bands of one width, long for that width [K].

    The ridge of the distance from the edge runs along the middle of a band. There, the distance is half the width.
    Once the ``watch`` is over, the regions that are left are no lines.
    """
    is_line = np.zeros(count, bool)
    for region, box in enumerate(ndimage.find_objects(label + 1, count)):
        if watch.is_over():
            break
        if box is not None:
            is_line[region] = _is_line(np.pad(label[box] == region, 1))
    return is_line


def _is_line(inside: Mask) -> bool:
    """Return whether the pixels ``inside`` [h, w] are a line."""
    distance = ndimage.distance_transform_edt(inside)
    # Steps of pixels along the edge have small ridges of their own.
    is_deep = distance >= LAYERS.line_depth_min * distance.max()
    ridge = distance[is_deep & (distance >= ndimage.maximum_filter(distance, 3))]
    half = float(np.median(ridge))
    near = np.abs(ridge - half) <= max(LAYERS.line_width_share * half, LAYERS.line_width_error)
    width = 2.0 * half - 1.0
    return bool(near.mean() >= LAYERS.line_share and inside.sum() >= LAYERS.line_length_min * width**2)
