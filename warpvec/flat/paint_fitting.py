"""The paints that the pure pixels of areas show."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from warpvec.flat.denoising import Tolerances
from warpvec.flat.paints import Paints
from warpvec.flat.region_growing import NONE

Floats = NDArray[np.float32]
Integers = NDArray[np.int32]

SAMPLES_MAX = 4096
"""Pixels of an area that its paint is fitted to, evenly taken from all of them."""


def fit_paints(image: Floats, labels: Integers, tolerances: Tolerances) -> Paints:
    """Return the paints of the areas ``labels`` [h, w] of ``image`` [h, w, 4], sRGB with straight alpha."""
    order = np.argsort(labels.ravel(), kind="stable")
    count = np.bincount(labels[labels != NONE], minlength=labels.max() + 1)
    stop = (labels == NONE).sum() + np.cumsum(count)
    colors = image.reshape(-1, 4)
    values = np.zeros((len(count), 4), np.float32)
    for index, (size, end) in enumerate(zip(count.tolist(), stop.tolist(), strict=True)):
        pixels = order[end - size : end : -(-size // SAMPLES_MAX)]
        values[index] = np.median(colors[pixels], 0)
    return flat_paints(values)


def flat_paints(values: Floats) -> Paints:
    """Return flat paints of sRGB and straight alpha [K, 4], rounded to 8 bits."""
    values = np.round(values * 255).astype(np.float32) / np.float32(255)
    values[values[:, 3] == 0] = 0
    color, count = values[:, :3], len(values)
    return Paints(color, values[:, 3], np.zeros(count, np.int32), np.zeros((count, 4), np.float32), color.copy())
