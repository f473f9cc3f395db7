"""Find what is symmetric about an upright or level axis: one half of it is said, and the other is its mirror image."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from warpvec.arrays import Floats
from warpvec.flat.chains.chain import Chain
from warpvec.flat.cutting.cut_edges import between
from warpvec.flat.simplification.outline_samples import cubic_points

OFF_RMS, OFF_MAX = 1.5, 8.0
"""Distances of a mirror image from what it mirrors, in details: root mean square and largest."""

FAR = 3.0
"""Pixels from a chain beyond which a mirrored point has no counterpart."""

STUB = 0.5
"""Pixels from a node up to which a chain crosses the axis in it: corners on an axis are off by less than outlines."""

UPRIGHT, LEVEL = 0, 1
"""Axes: the coordinate that they mirror."""


class Fold(NamedTuple):
    """A chain that is mirrored.

    Attributes:
        chain: half of a symmetric loop, from axis to axis or from an end to the axis; or one of two loops.
        axis: the coordinate that is mirrored.
        place: where the axis is.
        twin: the loop that is the mirror image; None for half of a loop.
        shared: whether the axis is that of the drawing.
    """

    chain: Chain
    axis: int
    place: float
    twin: int | None
    shared: bool


def folds_of(chains: dict[int, Chain], fixed: Floats, detail: float) -> dict[int, list[Fold]]:
    """Return for loops how they may be folded; those that are twins of others are not among them.

    A loop that has a half has two, of which the cheaper may be taken.

    Args:
        chains: the chains by their loops.
        fixed: points [K, 2] of other outlines, which are symmetric too if the drawing is.
        detail: root mean square in pixels by which an outline may move.
    """
    whole = np.concatenate([chain.points for chain in chains.values()] + [fixed])
    for axis in (UPRIGHT, LEVEL):
        place = float(whole[:, axis].min() + whole[:, axis].max()) / 2.0
        matched = {loop: _match(loop, chains, axis, place, detail) for loop in chains}
        if all(twin is not None for twin in matched.values()) and _is_mirrored(fixed, axis, place):
            return _folds(chains, {k: v for k, v in matched.items() if v is not None}, axis, place, True)
    found: dict[int, list[Fold]] = {}
    for loop, chain in chains.items():
        for axis in (UPRIGHT, LEVEL):
            place = float(chain.points[:, axis].min() + chain.points[:, axis].max()) / 2.0
            if loop not in found and _match(loop, {loop: chain}, axis, place, detail) == loop:
                found |= _folds({loop: chain}, {loop: loop}, axis, place, False)
    return found


def _match(loop: int, chains: dict[int, Chain], axis: int, place: float, detail: float) -> int | None:
    """Return the loop whose chain is the mirror image of that of ``loop``, which may be itself."""
    points = mirrored(chains[loop].points, axis, place)
    low, high = points.min(0), points.max(0)
    for other, chain in chains.items():
        if max(np.abs(chain.points.min(0) - low).max(), np.abs(chain.points.max(0) - high).max()) > OFF_MAX * detail:
            continue
        if chain.is_closed != chains[loop].is_closed:
            continue
        off = _distances(points, chain)
        if np.sqrt(np.mean(np.square(off))) <= OFF_RMS * detail and off.max() <= OFF_MAX * detail:
            return other
    return None


def _distances(points: Floats, chain: Chain) -> Floats:
    """Return how far ``points`` [K, 2] are from a chain; infinity beyond ``FAR``."""
    line = chain.dense
    _, near = cKDTree(line).query(points)
    found = np.full(len(points), np.inf)
    for start, stop in ((near - 1, near), (near, near + 1)):
        a, b = (line[np.clip(each, 0, len(line) - 1)] for each in (start, stop))
        way = b - a
        share = np.clip(((points - a) * way).sum(1) / np.maximum(np.square(way).sum(1), 1e-12), 0.0, 1.0)
        found = np.minimum(found, np.linalg.norm(a + share[:, None] * way - points, axis=1))
    return np.where(found > FAR, np.inf, found)


def _is_mirrored(fixed: Floats, axis: int, place: float) -> bool:
    """Return whether each of the points ``fixed`` [K, 2] has a counterpart."""
    if not len(fixed):
        return True
    off = np.linalg.norm(mirrored(fixed, axis, place)[:, None] - fixed, axis=2).min(1)
    return bool((off <= FAR / 2.0).all())


def _folds(
    chains: dict[int, Chain], twins: dict[int, int], axis: int, place: float, shared: bool
) -> dict[int, list[Fold]]:
    found: dict[int, list[Fold]] = {}
    for loop, twin in twins.items():
        if twin == loop:
            halves = [Fold(half, axis, place, None, shared) for half in halves_of(chains[loop], axis, place)]
            if halves:
                found[loop] = halves
        elif twins.get(twin) == loop and loop < twin:
            found[loop] = [Fold(chains[loop], axis, place, twin, shared)]
    return found


def mirrored(points: Floats, axis: int, place: float) -> Floats:
    """Return ``points`` [..., 2] mirrored at the axis at ``place``."""
    found = points.copy()
    found[..., axis] = 2.0 * place - found[..., axis]
    return found


def halves_of(chain: Chain, axis: int, place: float) -> list[Chain]:
    """Return both halves of a symmetric chain that crosses the axis as often as its kind must, else none.

    One that lies along the axis has none.
    """
    if np.abs(chain.points[:, axis] - place).max() <= STUB:
        return []
    side = np.where(chain.points[:, axis] >= place, 1.0, -1.0)
    crossings = np.flatnonzero(side[1:] != side[:-1]).tolist()
    if len(crossings) != (2 if chain.is_closed else 1):
        return []
    cuts = [_crossing(chain, crossing, axis, place) for crossing in crossings]
    count = float(len(chain.curves))
    spans = [(cuts[0], cuts[-1]), (cuts[-1], cuts[0])] if chain.is_closed else [(0.0, cuts[0]), (cuts[0], count)]
    found = []
    for start, stop in spans:
        half = _between(chain.curves, start, stop)
        if start in cuts:
            half[0, 0, axis] = place
        if stop in cuts:
            half[-1, 3, axis] = place
        own = chain.of_curves(half, is_closed=False)
        found.append(own if chain.freed is None else own.freed_in(_mirrored_boxes(chain.freed, axis, place)))
    return found


def _mirrored_boxes(boxes: Floats, axis: int, place: float) -> Floats:
    """Return ``boxes`` [B, 2, 2] mirrored at the axis at ``place``."""
    found = mirrored(boxes, axis, place)
    return np.stack([found.min(1), found.max(1)], 1)


def _between(curves: Floats, start: float, stop: float) -> Floats:
    """Return the ``curves`` [S, 4, 2] of a loop from one place to another: the number of a curve, and its parameter."""
    stop += len(curves) if stop <= start else 0.0
    number = np.arange(int(start), int(np.ceil(stop)))
    return between(curves[number % len(curves)], np.maximum(start - number, 0.0), np.minimum(stop - number, 1.0))


def _crossing(chain: Chain, point: int, axis: int, place: float) -> float:
    """Return where a chain crosses the axis, between a point and the next: in a node if that is near."""
    number, (low, high) = int(chain.curve[point]), chain.parameters[point].tolist()
    curve = chain.curves[number]
    sign = 1.0 if chain.points[point, axis] >= place else -1.0
    for _ in range(40):
        t = (low + high) / 2.0
        low, high = (t, high) if sign * (cubic_points(curve, np.array([t]))[0, axis] - place) > 0.0 else (low, t)
    near = np.linalg.norm(curve[[0, 3]] - cubic_points(curve, np.array([low])), axis=1) <= STUB
    return float((number + (0.0 if near[0] else 1.0 if near[1] else low)) % len(chain.curves))
