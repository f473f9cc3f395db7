"""The planar map of drawn paths: its edges, its faces, and which paths cover each face."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpvec.arrays import Floats, Integers, Mask
from warpvec.flat.connected_parts import connected_parts
from warpvec.flat.constants.cutting import CUTTING
from warpvec.flat.cutting.noding import Chords


@dataclass(frozen=True)
class PlanarMap:
    """E edges between V vertices, and the F faces between them.

    Half-edge 2 e runs along edge e, half-edge 2 e + 1 back. Each has its face on its left, in coordinates whose second
    axis points up; in a picture, where it points down, that is on its right.

    Attributes:
        vertex: places on the grid [V, 2].
        tail: vertex in which each half-edge begins [2 E].
        following: half-edge that goes on along the same face [2 E].
        face: face of each half-edge [2 E]; face 0 is the outside.
        winding: winding number of each path around each face [F, N].
        curve: row of the curve that each edge follows [E]; of several, that of the uppermost path.
        t: parameters of that curve at the tails of both half-edges [E, 2].
    """

    vertex: Integers
    tail: Integers
    following: Integers
    face: Integers
    winding: Integers
    curve: Integers
    t: Floats

    def lengths(self) -> Floats:
        """Return the length of each half-edge in pixels [2 E]."""
        along = self.vertex[self.tail.reshape(-1, 2)[:, 1]] - self.vertex[self.tail.reshape(-1, 2)[:, 0]]
        return np.repeat(np.hypot(*along.T) / CUTTING.units, 2)

    def areas(self) -> Floats:
        """Return the area of each face in square pixels [F]; that of the outside is negative."""
        return np.bincount(self.face, _twice_areas(self.vertex, self.tail), len(self.winding)) / 2 / CUTTING.units**2


def planar_map(chords: Chords, path_of_curve: Integers, path_count: int) -> PlanarMap:
    """Return the map of ``chords`` that meet in their ends only, which together form closed paths.

    Args:
        path_of_curve: path of each curve, from 0 at the bottom; -1 for a curve that only parts faces.
        path_count: number of paths, N.
    """
    ends = np.concatenate([chords.start, chords.end])
    vertex, index = _different_rows(ends)
    start, end = index.reshape(2, -1)
    pair = np.stack([np.minimum(start, end), np.maximum(start, end)], 1)
    pairs, edge = _different_rows(pair)
    delta = np.zeros((len(pairs), path_count), np.int64)
    path = path_of_curve[chords.curve]
    is_outline = path >= 0
    np.add.at(delta, (edge[is_outline], path[is_outline]), np.where(start < end, 1, -1)[is_outline])
    # The last chord in this order is that of the uppermost path.
    chosen = np.zeros(len(pairs), np.int64)
    order = np.argsort(path, kind="stable")
    chosen[edge[order]] = order
    forward = (start < end)[chosen]
    t = np.stack([np.where(forward, chords.t_start[chosen], chords.t_end[chosen]),
                  np.where(forward, chords.t_end[chosen], chords.t_start[chosen])], 1)  # fmt: skip
    matters: Mask = np.asarray(delta.any(1))
    matters[edge[~is_outline]] = True
    tail = pairs[matters].reshape(-1)
    following = _following(vertex, tail)
    face, winding = _faces(vertex, tail, following, delta[matters])
    return PlanarMap(vertex, tail, following, face, winding, chords.curve[chosen][matters], t[matters])


def _different_rows(values: Integers) -> tuple[Integers, Integers]:
    """Return the different rows of ``values`` [n, 2] in order, and the number of each row among them [n].

    It is `numpy.unique` along an axis, but five times as fast, since both columns make one number.
    """
    low = values.min(0, initial=0)
    span = int(values[:, 1].max(initial=0)) - int(low[1]) + 1
    keys, number = np.unique((values[:, 0] - low[0]) * span + values[:, 1] - low[1], return_inverse=True)
    return np.stack([keys // span, keys % span], 1) + low, number


def _following(vertex: Integers, tail: Integers) -> Integers:
    """Return the half-edge that follows each one around the face on its left [2 E]."""
    count = len(tail)
    twin = np.arange(count) ^ 1
    along = (vertex[tail[twin]] - vertex[tail]).astype(np.float64)
    order = np.lexsort((np.arctan2(along[:, 1], along[:, 0]), tail))
    # The half-edge before each one around the vertex where both begin.
    place = np.empty(count, np.int64)
    place[order] = np.arange(count)
    first = np.searchsorted(tail[order], np.arange(len(vertex)))
    stop = np.searchsorted(tail[order], np.arange(len(vertex)), side="right")
    before = place - 1
    wraps = place == first[tail]
    before[wraps] = stop[tail[wraps]] - 1
    return order[before][twin]


def _faces(vertex: Integers, tail: Integers, following: Integers, delta: Integers) -> tuple[Integers, Integers]:
    """Return the face of each half-edge [2 E], and the winding of each path around each face [F, N]."""
    orbit = connected_parts(np.arange(len(following)), following, len(following))
    orbit_count = int(orbit.max()) + 1 if len(orbit) else 0
    area = np.bincount(orbit, _twice_areas(vertex, tail), orbit_count)
    part = connected_parts(tail[::2], tail[1::2], len(vertex))[tail]
    part_of_orbit = np.zeros(orbit_count, np.int64)
    part_of_orbit[orbit] = part
    # Each connected part has one orbit around its outside, whose area is negative.
    face_of_orbit = np.where(area > 0, np.cumsum(area > 0), 0)
    winding = np.zeros((int((area > 0).sum()) + 1, delta.shape[1]), np.int64)
    outer = np.flatnonzero(area <= 0)
    around = {}
    for number in outer.tolist():
        inside = _around(vertex, tail, int(np.flatnonzero(orbit == number)[0]), part != part_of_orbit[number])
        turns = np.bincount(orbit, inside, orbit_count)
        holders = np.flatnonzero((turns != 0) & (area > 0))
        face_of_orbit[number] = face_of_orbit[holders[area[holders].argmin()]] if len(holders) else 0
        around[number] = inside[::2] @ delta
    _spread(winding, face_of_orbit, orbit, delta, around)
    return face_of_orbit[orbit], winding


def _around(vertex: Integers, tail: Integers, half_edge: int, counts: Mask) -> Integers:
    """Return how often each half-edge [2 E] that ``counts`` passes a ray to the right of that half-edge's tail.

    It is 1 where the winding number on the ray's side of it is larger, and -1 for its twin.
    """
    x, y = vertex[tail[half_edge]]
    a, b = vertex[tail], vertex[tail[np.arange(len(tail)) ^ 1]]
    rises, falls = (a[:, 1] <= y) & (b[:, 1] > y), (b[:, 1] <= y) & (a[:, 1] > y)
    side = (b[:, 0] - a[:, 0]) * (y - a[:, 1]) - (x - a[:, 0]) * (b[:, 1] - a[:, 1])
    found = np.where(rises & (side > 0), 1, 0) - np.where(falls & (side < 0), 1, 0)
    return np.where(counts, found, 0)


def _spread(
    winding: Integers, face_of_orbit: Integers, orbit: Integers, delta: Integers, around: dict[int, Integers]
) -> None:
    """Fill in the ``winding`` of all faces, from the outside of each part inwards."""
    by_orbit = np.argsort(orbit, kind="stable")
    first = np.searchsorted(orbit[by_orbit], np.arange(len(face_of_orbit) + 1))
    is_done = np.zeros(len(face_of_orbit), bool)
    for start, value in around.items():
        waiting = [(start, value)]
        is_done[start] = True
        while waiting:
            number, value = waiting.pop()
            if number not in around:
                winding[face_of_orbit[number]] = value
            for half_edge in by_orbit[first[number] : first[number + 1]].tolist():
                across = int(orbit[half_edge ^ 1])
                if not is_done[across]:
                    is_done[across] = True
                    # To the left of its edge a path winds once more.
                    sign = -1 if half_edge % 2 == 0 else 1
                    waiting.append((across, value + sign * delta[half_edge // 2]))


def _twice_areas(vertex: Integers, tail: Integers) -> Floats:
    """Return the cross product of the ends of each half-edge [2 E]; their sum along a cycle is twice its area."""
    a = vertex[tail].astype(np.float64)
    b = a.reshape(-1, 2, 2)[:, ::-1].reshape(-1, 2)
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
