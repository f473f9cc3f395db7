"""Points of outlines where a curve may begin: corners, whose rounding by pixels is undone, and smooth places."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from warpvec.arrays import Floats, Integers, Mask, blocks, interpolated
from warpvec.flat.constants.curves import CURVES
from warpvec.flat.curves.stroke_ends import stroke_ends


class Samples(NamedTuple):
    """Samples of all loops at even distances.

    Attributes:
        xy: samples of one loop after the other [M, 2].
        first: first sample of each loop [L + 1].
        step: distance between samples along each loop in pixels [L].
    """

    xy: Floats
    first: Integers
    step: Floats


@dataclass(frozen=True)
class Nodes:
    """N places where a curve may begin, loop by loop and along each loop.

    Attributes:
        first: first node of each loop [L + 1].
        sample: sample of its loop at the node [N], counted from the loop's first.
        point: the node [N, 2]; a corner lies outside of the rounded outline.
        direction: unit vector along the outline [N, 2]; of a corner, the mean of both sides.
        is_corner: corners [N].
    """

    first: Integers
    sample: Integers
    point: Floats
    direction: Floats
    is_corner: Mask


_LoopNodes = tuple[NDArray[Any], ...]
"""The fields of `Nodes` of one loop, but ``first``."""


def sample_loops(loops: Sequence[Floats]) -> Samples:
    """Return even samples of closed polylines [n, 2], at least three different points each."""
    parts, steps = [], []
    for loop in loops:
        closed = np.concatenate([loop, loop[:1]])
        length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(closed, axis=0).T))])
        count = max(CURVES.sample_count_min, round(length[-1] / CURVES.sample_step))
        places = np.arange(count) * (length[-1] / count)
        parts.append(interpolated(places, length, closed))
        steps.append(length[-1] / count)
    first = np.concatenate([[0], np.cumsum([len(part) for part in parts])]).astype(np.int64)
    return Samples(np.concatenate(parts), first, np.array(steps))


def roughness(samples: Samples) -> Floats:
    """Return how far the samples of each loop [L] are from a smooth curve, in pixels: as much as noise moves them.

    It is the lower quartile of their distances from parabolas through some pixels on either side, so that corners do
    not count. Loops too short to tell noise from shape have 0.
    """
    weights = _parabola(np.arange(-CURVES.smooth_reach, CURVES.smooth_reach + 1))[0]
    found = []
    for start, stop in pairwise(samples.first):
        xy = samples.xy[start:stop]
        parts = blocks(len(xy), CURVES.samples_at_once)
        off = np.concatenate([_off_parabolas(xy, weights, np.arange(part.start, part.stop)) for part in parts])
        quartile = float(np.quantile(np.hypot(off[:, 0], off[:, 1]), 0.25))
        found.append(quartile if len(xy) >= CURVES.rough_samples_min else 0.0)
    return np.array(found)


def _off_parabolas(xy: Floats, weights: Floats, places: Integers) -> Floats:
    """Return how far the parabolas around ``places`` of a loop, by their ``weights`` [2 reach + 1], are from it."""
    rows = (places[:, None] + np.arange(-CURVES.smooth_reach, CURVES.smooth_reach + 1)) % len(xy)
    return np.einsum("l,nlc->nc", weights, xy[rows]) - xy[places]


def find_nodes(samples: Samples, is_late: bool = False) -> Nodes:
    """Return the places of all loops where a curve may begin; if it ``is_late``, corners only where chords turn."""
    found = [
        _nodes_of_loop(samples.xy[start:stop], float(step), is_late)
        for (start, stop), step in zip(pairwise(samples.first), samples.step, strict=True)
    ]
    first = np.concatenate([[0], np.cumsum([len(sample) for sample, *_ in found])]).astype(np.int64)
    return Nodes(first, *(np.concatenate(values) for values in zip(*found, strict=True)))


def _nodes_of_loop(xy: Floats, step: float, is_late: bool) -> _LoopNodes:
    corners = _corners(xy, step, np.flatnonzero(_chords_turn(xy)) if is_late else np.arange(len(xy)))
    smooth = _smooth_nodes(xy, step, corners[0])
    order = np.argsort(np.concatenate([corners[0], smooth[0]]), kind="stable")
    return tuple(np.concatenate(values)[order] for values in zip(corners, smooth, strict=True))


class Side(NamedTuple):
    """The outline on one side of each sample: a point [n, 2] on it near the sample, and its direction away from it."""

    point: Floats
    away: Floats


def _chords_turn(xy: Floats) -> Mask:
    """Return at which samples [n] of a loop the chords on either side turn by half as much as at a corner."""
    reach = CURVES.corner_gap + CURVES.short_side
    ahead, behind = (np.roll(xy, shift, 0) - xy for shift in (-reach, reach))
    cross = ahead[:, 1] * behind[:, 0] - ahead[:, 0] * behind[:, 1]
    turn = np.arctan2(np.abs(cross), -(ahead * behind).sum(1))
    return np.asarray(turn > CURVES.corner_turn_min / 2.0)


def _corners(xy: Floats, step: float, places: Integers) -> _LoopNodes:
    """Return the corners of a loop of even samples [n, 2] among those at ``places``."""
    ahead, behind = sides_of(xy, places)
    turn = np.zeros(len(xy))
    turn[places] = turns_of(ahead, behind)
    even = 2 * CURVES.corner_gap * 2.0 * np.pi / len(xy)  # what a circle of this length turns between both sides
    is_chosen = (_is_peak(turn) & (turn > even + CURVES.corner_turn_min))[places]
    chosen = places[is_chosen]
    turn = turn[chosen]
    ahead, behind = (Side(side.point[is_chosen], side.away[is_chosen]) for side in (ahead, behind))
    if len(xy) >= 4 * (CURVES.sharp_gap + CURVES.short_side):
        far_ahead, far_behind = (_side(xy, sign, CURVES.sharp_gap, chosen) for sign in (1, -1))
        ahead = _where_sharp(turn, far_ahead, ahead)
        behind = _where_sharp(turn, far_behind, behind)
    reach = min(CURVES.corner_reach_max, CURVES.corner_reach_share * len(xy) * step)
    point = _intersections(xy, ahead, behind, chosen, reach)
    direction = unit(ahead.away - behind.away)
    ends = stroke_ends(xy, step, chosen, turn)
    chosen = np.concatenate([chosen[ends.is_kept], ends.sample.ravel()])
    point = np.concatenate([point[ends.is_kept], ends.point.reshape(-1, 2)])
    direction = np.concatenate([direction[ends.is_kept], ends.direction.reshape(-1, 2)])
    return chosen, point, direction, np.ones(len(chosen), bool)


def sides_of(xy: Floats, chosen: Integers | None = None) -> tuple[Side, Side]:
    """Return where a loop of even samples [n, 2] goes ahead of and behind the ``chosen`` ones, or each of them.

    It is without what corners round.
    """
    return _side(xy, 1, CURVES.corner_gap, chosen), _side(xy, -1, CURVES.corner_gap, chosen)


def turns_of(ahead: Side, behind: Side) -> Floats:
    """Return by how much a loop turns at each sample [n], in radians."""
    return np.arccos(np.clip(-(ahead.away * behind.away).sum(1), -1.0, 1.0))


def _where_sharp(turn: Floats, far: Side, near: Side) -> Side:
    """Return ``near``, and where corners are sharp ``far``."""
    is_sharp = (turn > CURVES.sharp_turn)[:, None]
    return Side(np.where(is_sharp, far.point, near.point), np.where(is_sharp, far.away, near.away))


def _side(xy: Floats, sign: int, gap: int, chosen: Integers | None = None) -> Side:
    """Return where the outline lies ahead of (``sign`` 1) or behind (-1) the ``chosen`` samples, beyond the gap."""
    places = np.arange(len(xy)) if chosen is None else chosen
    parts = [_side_of(xy, sign, gap, places[part]) for part in blocks(len(places), CURVES.samples_at_once)]
    return parts[0] if len(parts) == 1 else Side(*(np.concatenate(values) for values in zip(*parts, strict=True)))


def _side_of(xy: Floats, sign: int, gap: int, places: Integers) -> Side:
    count = len(xy)
    long = min(CURVES.long_side, max(CURVES.short_side, count // 6))
    rows = (places + sign * np.arange(gap, gap + long)[:, None]) % count
    near = np.ascontiguousarray(xy.T[:, rows])  # [2, long, n]: einsum is ten times as fast along long rows
    offsets = np.arange(long)
    basis = np.stack([offsets**0, offsets, offsets**2], 1).astype(np.float64)
    parabola = np.einsum("kl,cln->ckn", _parabola(offsets), near)
    residual = near - np.einsum("lk,ckn->cln", basis, parabola)
    line = np.einsum("kl,cln->ckn", np.linalg.pinv(basis[: CURVES.short_side, :2]), near[:, : CURVES.short_side])
    is_bent = np.sqrt((residual**2).sum(0).mean(0)) > CURVES.parabola_residual_max
    point, away = np.where(is_bent, line, parabola[:, :2]).transpose(1, 2, 0)
    return Side(np.ascontiguousarray(point), unit(away))


def _is_peak(values: Floats) -> Mask:
    """Return which values of a cycle are the largest within ``corners_apart`` samples; of equal ones the first."""
    is_peak = np.ones(len(values), bool)
    for shift in range(1, CURVES.corners_apart + 1):
        is_peak &= (values >= np.roll(values, -shift)) & (values > np.roll(values, shift))
    return is_peak


def _intersections(xy: Floats, ahead: Side, behind: Side, chosen: Integers, reach: float) -> Floats:
    """Return where the lines of both sides meet, at most ``reach`` pixels from the outline."""
    between = behind.point - ahead.point
    cross = ahead.away[:, 0] * behind.away[:, 1] - ahead.away[:, 1] * behind.away[:, 0]
    share = (between[:, 0] * behind.away[:, 1] - between[:, 1] * behind.away[:, 0]) / np.where(cross == 0, 1.0, cross)
    point = ahead.point + share[:, None] * ahead.away
    middle = (ahead.point + behind.point) / 2.0
    point = np.where((cross == 0)[:, None], middle, point)
    away = point - xy[chosen]
    distance = np.linalg.norm(away, axis=1, keepdims=True)
    return xy[chosen] + away * np.minimum(1.0, reach / np.maximum(distance, 1e-9))


def _smooth_nodes(xy: Floats, step: float, corners: Integers) -> _LoopNodes:
    count = len(xy)
    length = count * step
    spacing = np.clip(length * CURVES.spacing_share, CURVES.spacing_min, CURVES.spacing_max)
    places = np.rint(np.arange(0, count, spacing / step)).astype(np.int64)
    distance = _distance_on_cycle(places[places < count], corners, count)
    places, distance = places[places < count][distance > CURVES.corner_gap], distance[distance > CURVES.corner_gap]
    reach = min(CURVES.smooth_reach, max(2, count // 8))
    offsets = np.arange(-reach, reach + 1)
    near = xy[(places[:, None] + offsets) % count]
    parabola = np.einsum("kl,nlc->nkc", _parabola(offsets), near)
    is_near = distance <= reach
    point = np.where(is_near[:, None], xy[places], parabola[:, 0])
    return places, point, unit(parabola[:, 1]), np.zeros(len(places), bool)


def _parabola(offsets: Integers) -> Floats:
    """Return the matrix [3, n] that gives the parabola closest to values at ``offsets`` [n], lowest power first."""
    return np.linalg.pinv(np.stack([offsets**0, offsets, offsets**2], 1).astype(np.float64))


def _distance_on_cycle(places: Integers, corners: Integers, count: int) -> Integers:
    """Return how many samples each of ``places`` [n] is from the nearest of ``corners`` [k] on a loop of ``count``."""
    if not len(corners):
        return np.full(len(places), count)
    known = np.sort(corners)
    around = np.concatenate([known[-1:] - count, known, known[:1] + count])
    after = np.searchsorted(around, places).clip(1, len(around) - 1)
    return np.minimum(np.abs(around[after] - places), np.abs(places - around[after - 1]))


def unit(vectors: Floats) -> Floats:
    """Return ``vectors`` [..., 2] with the length 1."""
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-12)
