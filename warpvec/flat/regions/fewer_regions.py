"""Bound the number of regions: noise and photos have thousands, which no drawing of few paths could keep."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats
from warpvec.flat.regions.regions import Regions, find_canvas


def with_fewer_regions(regions: Regions, count: int) -> Regions:
    """Return the ``count`` regions that show most; the pixels of the others go to the nearest one of these.

    A region shows more the larger it is, and the more its colour differs from those around it.
    """
    if len(regions) <= count:
        return regions
    keep = np.zeros(len(regions), bool)
    keep[np.argsort(-_prominence(regions), kind="stable")[:count]] = True
    number = (np.cumsum(keep) - 1).astype(np.int32)
    row, column = ndimage.distance_transform_edt(~keep[regions.label], return_distances=False, return_indices=True)
    label = regions.label[row, column]
    # A share stays in pixels that both of their regions keep.
    other = np.where(keep[regions.label] & keep[regions.other], regions.other, label)
    share = np.where(other == label, np.float32(1), regions.share)
    paints, label = regions.paints.select(np.flatnonzero(keep)), number[label]
    is_known = regions.canvas is not None and keep[regions.canvas]
    canvas = int(number[regions.canvas]) if is_known else find_canvas(label, paints)
    return Regions(label, number[other], share, paints, canvas, regions.lettering_among(keep), regions.noise)


def _prominence(regions: Regions) -> Floats:
    """Return the area of each region [K] times its mean squared difference of colour along its border."""
    mixed, label, count = regions.mixed().astype(np.float64), regions.label, len(regions)
    total, length = np.zeros(count), np.zeros(count)
    for near, far in ((np.s_[:, 1:], np.s_[:, :-1]), (np.s_[1:], np.s_[:-1])):
        is_border = label[near] != label[far]
        square = np.square(mixed[near] - mixed[far]).sum(-1)[is_border]
        for side in (near, far):
            owner = label[side][is_border]
            total += np.bincount(owner, square, count)
            length += np.bincount(owner, minlength=count)
    area = np.bincount(label.ravel(), minlength=count)
    return area * total / np.maximum(length, 1.0)
