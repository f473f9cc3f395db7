"""Which two regions a pixel is a mix of, and their shares."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from warpvec.flat.paints import Paints
from warpvec.flat.region_growing import NONE

Floats = NDArray[np.float32]
Integers = NDArray[np.int32]

CANDIDATE_COUNT = 4
"""Nearest regions of a pixel whose mixes in pairs are compared. More than four hardly meet within two pixels."""

RADIUS = 3
"""Largest distance in pixels, along each axis, of a region that can have a share in a pixel."""


@dataclass(frozen=True, eq=False)
class Mixes:
    """The best mix of two regions in each of N pixels.

    Attributes:
        label: region with the larger share [N].
        other: region with the rest [N].
        share: share of ``label`` [N], in [0.5, 1].
        residual: root mean square over the channels of what the mix does not explain [N].
    """

    label: Integers
    other: Integers
    share: Floats
    residual: Floats


def nearest_labels(labels: Integers, rows: Integers, columns: Integers, radius: int = RADIUS) -> Integers:
    """Return up to ``CANDIDATE_COUNT`` different labels [N, C] near pixels, nearest first, filled up with ``NONE``."""
    steps = np.arange(-radius, radius + 1)
    dy, dx = (grid.ravel() for grid in np.meshgrid(steps, steps, indexing="ij"))
    order = np.argsort(dy**2 + dx**2, kind="stable")
    padded = np.pad(labels, radius, constant_values=NONE)
    window = padded[rows[:, None] + dy[order] + radius, columns[:, None] + dx[order] + radius]
    found = np.full((len(rows), CANDIDATE_COUNT), NONE, np.int32)
    row = np.arange(len(rows))
    for slot in range(CANDIDATE_COUNT):
        first = (window != NONE).argmax(1)
        found[:, slot] = window[row, first]
        window[window == found[:, slot, None]] = NONE
    return found


def best_mixes(picture: Floats, paints: Paints, candidates: Integers, rows: Integers, columns: Integers) -> Mixes:
    """Return the mix of two of ``candidates`` [N, C] that comes closest to each pixel, by least squares."""
    color = picture[rows, columns]
    x, y = ((place + 0.5).astype(np.float32) for place in (columns, rows))
    values = [paints.at(np.maximum(candidates[:, slot], 0), x, y) for slot in range(candidates.shape[1])]
    best = Mixes(
        candidates[:, 0].copy(), candidates[:, 0].copy(), np.ones(len(rows), np.float32), _rms(color - values[0])
    )
    for first, second in combinations(range(candidates.shape[1]), 2):
        difference = values[first] - values[second]
        squared = np.maximum((difference**2).sum(-1), 1.0e-9)
        share = np.clip(((color - values[second]) * difference).sum(-1) / squared, 0.0, 1.0)
        residual = _rms(color - values[second] - share[:, None] * difference)
        is_better = (candidates[:, second] != NONE) & (residual < best.residual)
        best.label[is_better] = candidates[is_better, first]
        best.other[is_better] = candidates[is_better, second]
        best.share[is_better] = share[is_better]
        best.residual[is_better] = residual[is_better]
    return _larger_first(best)


def _rms(values: Floats) -> Floats:
    return np.sqrt((values**2).mean(-1))


def _larger_first(mixes: Mixes) -> Mixes:
    """Return the mixes with the larger share named first."""
    swap = mixes.share < 0.5
    label, other = np.where(swap, mixes.other, mixes.label), np.where(swap, mixes.label, mixes.other)
    share = np.where(swap, 1.0 - mixes.share, mixes.share).astype(np.float32)
    other = np.where(share >= 1.0, label, other)
    return Mixes(label.astype(np.int32), other.astype(np.int32), share, mixes.residual)
