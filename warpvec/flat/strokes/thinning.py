"""Thin a mask to a skeleton one pixel wide.

Source: Z. Guo and R. W. Hall, "Parallel thinning with two-subiteration algorithms" (1989). Unlike the older one of
Zhang and Suen, it keeps diagonal lines of even width. Only pixels that are left are looked at, so large pictures of
thin lines take little time.
"""

from __future__ import annotations

import numpy as np

from warpvec.arrays import Mask
from warpvec.flat.strokes.skeleton import AROUND


def thinned(mask: Mask) -> Mask:
    """Return the skeleton of ``mask`` [h, w], with as many parts and holes."""
    image = np.pad(mask, 1)
    flat, width = image.reshape(-1), image.shape[1]
    around = np.array([row * width + column for row, column in AROUND])
    left = np.flatnonzero(flat)
    while True:
        before = len(left)
        for phase in (0, 1):
            gone = _removable(flat[left + around[:, None]], phase)
            flat[left[gone]] = False
            left = left[~gone]
        if len(left) == before:
            return image[1:-1, 1:-1]


def _removable(p: Mask, phase: int) -> Mask:
    """Return which pixels go [K] in one of the two phases, by their neighbours ``p`` [8, K]."""
    after = [p[(k + 1) % 8] for k in range(8)]
    turns = sum((~p[k] & (after[k] | p[(k + 2) % 8])).astype(np.int8) for k in (0, 2, 4, 6))
    first = sum((p[k - 1] | p[k]).astype(np.int8) for k in (0, 2, 4, 6))
    second = sum((p[k] | after[k]).astype(np.int8) for k in (0, 2, 4, 6))
    count = np.minimum(first, second)
    up, corner, right, other = (p[(k + 4 * phase) % 8] for k in (0, 1, 2, 3))
    is_held = (up | corner | ~other) & right
    found: Mask = (turns == 1) & (count >= 2) & (count <= 3) & ~is_held
    return found
