"""Necks: places where a part between two wide areas is too narrow to be cut."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from warpvec.arrays import Floats, Integers, Mask, counted
from warpvec.flat.constants.cutting import CUTTING
from warpvec.flat.cutting.planar_map import PlanarMap
from warpvec.flat.cutting.spurs import outline_order

_OWNER_GAP = 10.0
"""Distance that is added between samples of different owners, which never face each other."""

_DIRECTION_GAP = 0.1
"""Distance in pixels that a turn by 60 degrees counts as: samples of one side are then 0.2 from being opposite, beyond
the width of a neck, and those of both sides 0.045 at most."""

_TIP_SAMPLES = 5
"""Samples around the tip of a spur, where both sides meet."""


def neck_mouths(mapped: PlanarMap, owners: Integers) -> Floats:
    """Return a line [M, 2, 2] in pixels across both ends of each neck.

    Args:
        mapped: the map of the outlines.
        owners: owner of each face [F].
    """
    is_cut = owners[mapped.face] != owners[mapped.face[np.arange(len(mapped.tail)) ^ 1]]
    order, loop = _in_order(outline_order(mapped, is_cut), is_cut & (owners[mapped.face] > 0))
    if not len(order):
        return np.zeros((0, 2, 2))
    places, along, row = _samples(mapped, order)
    mate = _mates(places, along, owners[mapped.face[order]][row])
    outlines = _Outlines(loop[row])
    mouths = []
    for first, last in outlines.runs(mate >= 0):
        ends = np.array([first, last])
        is_tip = outlines.steps(ends, mate[ends]).min() <= _TIP_SAMPLES  # a spur
        is_long = np.hypot(*(places[last] - places[first])) >= CUTTING.spur_length
        # Each side of a neck finds it, and begins where the other ends.
        if is_long and not is_tip and first < mate[last]:
            mouths += [[places[each], places[mate[each]]] for each in ends]
    return np.array(mouths).reshape(-1, 2, 2)


class _Outlines:
    """Samples in the order of their closed outlines.

    Args:
        loop: outline of each sample [S], in ascending order.
    """

    def __init__(self, loop: Integers) -> None:
        self._loop = loop
        begin, size = np.unique(loop, return_index=True, return_counts=True)[1:]
        self._begin, self._size = begin[loop], size[loop]

    def runs(self, is_narrow: Mask) -> list[tuple[int, int]]:
        """Return the first and the last sample of each run of narrow ones; an outline without others has none."""
        place = np.arange(len(is_narrow)) - self._begin
        starts = np.flatnonzero(is_narrow & ~is_narrow[self._begin + (place - 1) % self._size])
        stops = np.flatnonzero(is_narrow & ~is_narrow[self._begin + (place + 1) % self._size])
        after = np.searchsorted(stops, starts)
        ends = self._begin + self._size
        is_over_seam = np.append(stops, len(self._loop))[after] >= ends[starts]
        after[is_over_seam] = np.searchsorted(stops, self._begin[starts[is_over_seam]])
        return list(zip(starts.tolist(), stops[after].tolist(), strict=True))

    def steps(self, one: Integers, two: Integers) -> Integers:
        """Return the number of samples from one to the other by the shorter way [n]; very many between outlines."""
        gap = np.abs(one - two)
        gap = np.minimum(gap, self._size[one] - gap)
        return np.where(self._loop[one] == self._loop[two], gap, len(self._loop))


def _in_order(following: Integers, is_kept: Mask) -> tuple[Integers, Integers]:
    """Return the half-edges that are kept [n] in the order of their closed outlines, and the outline of each [n].

    An outline begins at its lowest half-edge, and outlines follow by these. Where each half-edge knows the one ``2**k``
    steps ahead, the next round knows the one ``2**(k + 1)`` steps ahead.
    """
    kept = np.flatnonzero(is_kept)
    place = np.full(len(following), -1)
    place[kept] = np.arange(len(kept))
    after = place[following[kept]]
    lowest, ahead = np.arange(len(kept)), after
    for _ in range(len(kept).bit_length()):
        lowest, ahead = np.minimum(lowest, lowest[ahead]), ahead[ahead]
    # Steps back to the lowest one, which stays where it is.
    back = np.empty_like(after)
    back[after] = np.arange(len(kept))
    is_first = lowest == np.arange(len(kept))
    back[is_first] = np.flatnonzero(is_first)
    steps = (~is_first).astype(np.int64)
    for _ in range(len(kept).bit_length()):
        steps, back = steps + steps[back], back[back]
    order = np.lexsort((steps, lowest))
    return kept[order], np.cumsum(is_first[order]) - 1


def _samples(mapped: PlanarMap, order: Integers) -> tuple[Floats, Floats, Integers]:
    """Return places along the half-edges ``order`` [S, 2], their directions [S, 2], and rows of ``order`` [S]."""
    vertex = mapped.vertex / CUTTING.units
    start, end = vertex[mapped.tail[order]], vertex[mapped.tail[order ^ 1]]
    length = np.hypot(*(end - start).T)
    counts = np.ceil(length / CUTTING.spur_step).astype(np.int64)
    row = np.repeat(np.arange(len(order)), counts)
    share = (counted(counts) + 0.5) / counts[row]
    along = (end - start) / length[:, None]
    return start[row] + share[:, None] * (end - start)[row], along[row], row


def _mates(places: Floats, along: Floats, owner: Integers) -> Integers:
    """Return the nearest sample on the other side of a neck for each [S]; -1 for none."""
    found = np.full(len(places), -1)
    some = _near_opposite(places, along, owner)
    if not len(some):
        return found
    tree = cKDTree(np.concatenate([places, _OWNER_GAP * owner[:, None]], 1))
    gap, near = tree.query(tree.data[some], CUTTING.neck_neighbours, distance_upper_bound=CUTTING.sliver_width)
    near = np.where(np.isfinite(gap), near, some[:, None])
    inward = np.stack([-along[some, 1], along[some, 0]], 1)
    is_opposite = (along[near] * along[some, None]).sum(2) <= -CUTTING.spur_cosine
    faces = is_opposite & (((places[near] - places[some, None]) * inward[:, None]).sum(2) > 0.0)
    found[some] = np.where(faces.any(1), near[np.arange(len(near)), faces.argmax(1)], -1)
    return found


def _near_opposite(places: Floats, along: Floats, owner: Integers) -> Integers:
    """Return the samples [n] that may have a mate: one of their owner, near in place and in the opposite direction.

    The direction, times ``_DIRECTION_GAP``, is part of the place, so that samples of their own side are far from them.
    """
    turned = _DIRECTION_GAP * along
    samples = np.concatenate([places, _OWNER_GAP * owner[:, None], turned], 1)
    tree = cKDTree(samples, balanced_tree=False, compact_nodes=False)
    reach = np.hypot(CUTTING.sliver_width, _DIRECTION_GAP * np.sqrt(2.0 - 2.0 * CUTTING.spur_cosine)) + 1e-9
    gap, _ = tree.query(np.concatenate([samples[:, :3], -turned], 1), distance_upper_bound=reach)
    return np.flatnonzero(np.isfinite(gap))
