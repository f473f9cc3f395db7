"""Spurs: places where a part runs out between two outlines that nearly coincide, too narrow to be cut."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from warpvec.arrays import Floats, Integers, Mask, interpolated
from warpvec.flat.constants.cutting import CUTTING
from warpvec.flat.cutting.planar_map import PlanarMap


def spur_mouths(mapped: PlanarMap, owners: Integers) -> Floats:
    """Return a line [M, 2, 2] in pixels across the mouth of each spur.

    Args:
        mapped: the map of the outlines.
        owners: owner of each face [F].
    """
    is_cut = owners[mapped.face] != owners[mapped.face[np.arange(len(mapped.tail)) ^ 1]]
    following = outline_order(mapped, is_cut)
    before = np.full(len(following), -1)
    before[following[is_cut]] = np.flatnonzero(is_cut)
    places = mapped.vertex / CUTTING.units
    tail, head = places[mapped.tail], places[mapped.tail[np.arange(len(mapped.tail)) ^ 1]]
    length, after, back = mapped.lengths().tolist(), following.tolist(), before.tolist()
    mouths = []
    for last_edge, first in _tips(np.flatnonzero(is_cut), following, head - tail):
        for reach in CUTTING.spur_search:
            there = _walked([tail[first], *(head[each] for each in _chain(first, after, length, reach))], reach)
            here = _walked([head[last_edge], *(tail[each] for each in _chain(last_edge, back, length, reach))], reach)
            steps = min(len(there), len(here))
            is_wide = np.hypot(*(there[:steps] - here[:steps]).T) > CUTTING.sliver_width
            if is_wide.any():
                break
        last = (int(is_wide.argmax()) if is_wide.any() else steps) - 1
        if last * CUTTING.spur_step >= CUTTING.spur_length:
            mouths.append([there[last], here[last]])
    return np.array(mouths).reshape(-1, 2, 2)


def _tips(cut: Integers, following: Integers, along: Floats) -> Iterator[tuple[int, int]]:
    """Yield the half-edges before and after each tip, where an outline turns back within the width of a spur."""
    length = np.hypot(*along.T)
    current, gap = following[cut], np.zeros(len(cut))
    for _ in range(CUTTING.spur_tip_edges):
        cosine = -(along[cut] * along[current]).sum(1) / np.maximum(length[cut] * length[current], 1e-12)
        found = (cosine >= CUTTING.spur_cosine) & (gap <= CUTTING.sliver_width)
        yield from zip(cut[found].tolist(), current[found].tolist(), strict=True)
        gap = gap + length[current]
        current = following[current]


def outline_order(mapped: PlanarMap, is_cut: Mask) -> Integers:
    """Return the half-edge after each one that ``is_cut`` on the outline of its owner [2 E]; others stay."""
    found = np.where(is_cut, mapped.following, np.arange(len(is_cut)))
    waiting = np.flatnonzero(is_cut & ~is_cut[found])
    while len(waiting):
        found[waiting] = mapped.following[found[waiting] ^ 1]
        waiting = waiting[~is_cut[found[waiting]]]
    return found


def _chain(first: int, following: list[int], length: list[float], reach: float) -> list[int]:
    """Return consecutive half-edges from ``first`` on, ``reach`` pixels long or more."""
    chain: list[int] = []
    walked = 0.0
    while walked < reach and first not in chain[:1]:
        chain.append(first)
        walked += length[first]
        first = following[first]
    return chain


def _walked(points: list[Floats], reach: float) -> Floats:
    """Return places [K, 2] at equal steps along a line through ``points``, up to ``reach`` pixels."""
    line = np.array(points)
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    steps = np.arange(0.0, min(along[-1], reach), CUTTING.spur_step)
    return interpolated(steps, along, line)
