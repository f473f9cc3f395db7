"""Which two regions a pixel is a mix of, and their shares."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from warpvec.arrays import Floats32, Integers32, Mask
from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.regions.region_growing import NONE

TINY = 1.0e-9


@dataclass(frozen=True, eq=False)
class Mixes:
    """The best mix of two regions in each of N pixels.

    Attributes:
        label: region with the larger share [N].
        other: region with the rest [N].
        share: share of ``label`` [N], in [0.5, 1].
        residual: root of the mean square of what the mix does not explain [N].
    """

    label: Integers32
    other: Integers32
    share: Floats32
    residual: Floats32


@dataclass(frozen=True, eq=False)
class Candidates:
    """Regions near N pixels, nearest first.

    Attributes:
        label: regions [N, C], filled up with ``NONE``.
        squared: squared distances in pixels [N, C].
    """

    label: Integers32
    squared: Floats32


def nearest_labels(labels: Integers32, rows: Integers32, columns: Integers32, radius: int) -> Candidates:
    """Return the ``candidate_count`` nearest different labels of the map ``labels`` [h, w] to N pixels."""
    steps = np.arange(-radius, radius + 1)
    dy, dx = (grid.ravel() for grid in np.meshgrid(steps, steps, indexing="ij"))
    order = np.argsort(dy**2 + dx**2, kind="stable")
    squared = (dy**2 + dx**2)[order].astype(np.float32)
    padded = np.pad(labels, radius, constant_values=NONE)
    place = (rows + radius) * padded.shape[1] + columns + radius
    window = padded.ravel()[place[:, None] + (dy * padded.shape[1] + dx)[order]]
    label = np.full((len(rows), REGIONS.candidate_count), NONE, np.int32)
    distance = np.zeros((len(rows), REGIONS.candidate_count), np.float32)
    row = np.arange(len(rows))
    for slot in range(REGIONS.candidate_count):
        first = (window != NONE).argmax(1)
        label[:, slot], distance[:, slot] = window[row, first], squared[first]
        window[window == label[:, slot, None]] = NONE
    return Candidates(label, distance)


def best_mixes(color: Floats32, values: Floats32, candidates: Candidates) -> Mixes:
    """Return the mix of two candidates that comes closest to each of N pixels, by least squares.

    Args:
        color: colours of the pixels [N, D].
        values: colours of the candidates there [N, C, D].
        candidates: the regions.
    """
    label = candidates.label
    share = np.ones(len(color), np.float32)
    residual = _rms(color - values[:, 0])
    first_best, second_best = label[:, 0].copy(), label[:, 0].copy()
    cost = residual + REGIONS.mix_distance_cost * candidates.squared[:, 0]
    for first, second in combinations(range(label.shape[1]), 2):
        usable = np.nonzero(label[:, second] != NONE)[0]
        one, two = values[usable, first], values[usable, second]
        part, rest = pair_shares(color[usable], one, two)
        new_cost = rest + REGIONS.mix_distance_cost * (
            candidates.squared[usable, first] + candidates.squared[usable, second]
        )
        is_better = new_cost < cost[usable]
        chosen = usable[is_better]
        cost[chosen], share[chosen], residual[chosen] = new_cost[is_better], part[is_better], rest[is_better]
        first_best[chosen], second_best[chosen] = label[chosen, first], label[chosen, second]
    return _larger_first(first_best, second_best, share, residual)


def pair_shares(color: Floats32, one: Floats32, two: Floats32) -> tuple[Floats32, Floats32]:
    """Return the share of ``one`` [...] in [0, 1] and the residual [...] of the best mix of two colours [..., D]."""
    difference = one - two
    squared = np.maximum((difference**2).sum(-1), TINY)
    share = np.clip(((color - two) * difference).sum(-1) / squared, 0.0, 1.0)
    return share, _rms(color - two - share[..., None] * difference)


def explain_by_three(mixes: Mixes, color: Floats32, values: Floats32, candidates: Candidates, far: Mask) -> Mixes:
    """Return ``mixes`` with those replaced that a mix of three candidates explains better.

    The two larger of the three shares are kept. ``far`` [N, C] are candidates that may have the least share only.
    """
    label, other = mixes.label.copy(), mixes.other.copy()
    share, residual = mixes.share.copy(), mixes.residual.copy()
    row = np.arange(len(color))
    limit = residual * REGIONS.triple_gain
    for triple in combinations(range(candidates.label.shape[1]), 3):
        chosen = list(triple)
        shares, rest = triple_shares(color, values[:, chosen])
        possible = (candidates.label[:, chosen] != NONE).all(1) & (shares >= 0).all(1)
        possible &= (np.where(far[:, chosen], shares, 0) <= REGIONS.far_share_max).all(1)
        order = np.argsort(-np.where(far[:, chosen], shares - 1, shares), 1)
        most, next_most = shares[row, order[:, 0]], shares[row, order[:, 1]]
        is_better = possible & (rest < limit)
        picked = candidates.label[:, chosen]
        label[is_better], other[is_better] = picked[row, order[:, 0]][is_better], picked[row, order[:, 1]][is_better]
        share[is_better] = (most / np.maximum(most + next_most, TINY))[is_better]
        residual[is_better] = rest[is_better]
        limit = np.where(is_better, rest, limit)
    return _larger_first(label, other, share, residual)


def triple_shares(color: Floats32, values: Floats32) -> tuple[Floats32, Floats32]:
    """Return the shares [N, 3], with sum 1, of three colours [N, 3, D] in ``color`` [N, D], and the residual [N]."""
    one, two = values[:, 0] - values[:, 2], values[:, 1] - values[:, 2]
    rest = color - values[:, 2]
    aa, bb, ab = (one * one).sum(-1), (two * two).sum(-1), (one * two).sum(-1)
    ac, bc = (one * rest).sum(-1), (two * rest).sum(-1)
    determinant = aa * bb - ab * ab
    flat = determinant < 1.0e-3 * aa * bb + TINY
    determinant = np.where(flat, 1.0, determinant)
    first, second = (ac * bb - bc * ab) / determinant, (bc * aa - ac * ab) / determinant
    residual = _rms(rest - first[:, None] * one - second[:, None] * two)
    shares = np.stack([first, second, 1 - first - second], 1)
    shares[flat] = -1.0
    return shares, residual


def _rms(values: Floats32) -> Floats32:
    return np.sqrt((values**2).mean(-1))


def _larger_first(first: Integers32, second: Integers32, share: Floats32, residual: Floats32) -> Mixes:
    """Return the mixes with the larger share named first."""
    swap = share < 0.5
    label, other = np.where(swap, second, first), np.where(swap, first, second)
    share = np.where(swap, 1.0 - share, share).astype(np.float32)
    other = np.where(share >= 1.0, label, other)
    return Mixes(label.astype(np.int32), other.astype(np.int32), share, residual.astype(np.float32))
