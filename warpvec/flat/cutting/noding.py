"""Break curves where they cross or touch, so that they meet only in common vertices on a fine grid.

Curves are followed as short chords, each of which knows its part of its curve. Chords are rounded to the grid and
broken until none crosses another and none passes a vertex at less than a unit of the grid. This is snap rounding:
Hobby, "Practical segment intersection with finite precision output", 1999.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from warpvec.arrays import Floats, Integers, Mask, counted
from warpvec.flat.constants.cutting import CUTTING


@dataclass(frozen=True)
class Chords:
    """K directed chords on the grid.

    Attributes:
        start, end: ends in units of the grid [K, 2].
        curve: row of the curve that the chord follows [K].
        t_start, t_end: parameters of the curve at the ends [K].
    """

    start: Integers
    end: Integers
    curve: Integers
    t_start: Floats
    t_end: Floats

    def __len__(self) -> int:
        return len(self.curve)

    def select(self, rows: NDArray[np.generic]) -> Chords:
        """Return the chords ``rows``, indices or a mask."""
        return Chords(self.start[rows], self.end[rows], self.curve[rows], self.t_start[rows], self.t_end[rows])

    def joined(self, other: Chords, curve_count: int) -> Chords:
        """Return these chords and those of ``other``, whose curves come after ``curve_count`` curves."""
        names = ("start", "end", "t_start", "t_end")
        start, end, t_start, t_end = (np.concatenate([getattr(self, name), getattr(other, name)]) for name in names)
        return Chords(start, end, np.concatenate([self.curve, other.curve + curve_count]), t_start, t_end)


def chords_of(cubics: Floats, is_line: Mask, error: float = CUTTING.chord_error) -> Chords:
    """Return the chords of ``cubics`` [R, 4, 2] in pixels, on the grid; a line is one chord.

    Chords are at most ``error`` pixels from their curve.
    """
    bend = np.abs(cubics[:, :-2] - 2 * cubics[:, 1:-1] + cubics[:, 2:]).max(1)
    # The distance of n chords from a cubic is at most 6 / 8 of its largest second difference over n^2.
    counts = np.ceil(np.sqrt(0.75 * np.hypot(*bend.T) / error)).astype(np.int64)
    counts = np.where(is_line, 1, np.clip(counts, 1, 1000))
    curve = np.repeat(np.arange(len(cubics)), counts)
    number = counted(counts)
    t_start, t_end = number / counts[curve], (number + 1) / counts[curve]
    start, end = (np.rint(CUTTING.units * _points(cubics[curve], t)).astype(np.int64) for t in (t_start, t_end))
    return _without_empty(Chords(start, end, curve, t_start, t_end))


def noded(chords: Chords) -> Chords:
    """Return ``chords`` broken so that they meet in their ends only."""
    for _ in range(CUTTING.passes_max):
        rows, places = _breaks(chords)
        if not len(rows):
            return chords
        chords = _without_empty(_broken(chords, rows, places))
    return chords


def _points(cubics: Floats, t: Floats) -> Floats:
    """Return the point of each of ``cubics`` [K, 4, 2] at its parameter ``t`` [K]."""
    t = t[:, None]
    a, b, c, d = np.moveaxis(cubics, 1, 0)
    return (1 - t) ** 3 * a + 3 * (1 - t) ** 2 * t * b + 3 * (1 - t) * t**2 * c + t**3 * d


def _without_empty(chords: Chords) -> Chords:
    """Return the chords that have a length. The parameters that others leave out are given to those before them."""
    has_length = (chords.start != chords.end).any(1)
    if has_length.all():
        return chords
    kept = np.flatnonzero(has_length)
    result = chords.select(kept)
    t_end = result.t_end.copy()
    follows = np.append(result.curve[1:] == result.curve[:-1], False)
    t_end[follows] = result.t_start[1:][follows[:-1]]
    return Chords(result.start, result.end, result.curve, result.t_start, t_end)


def _breaks(chords: Chords) -> tuple[Integers, Integers]:
    """Return rows of chords [n] and the places [n, 2] on the grid where they must be broken."""
    one, two = _near_pairs(chords)
    crossing, place = _crossings(chords, one, two)
    rows, places = [one[crossing], two[crossing]], [place, place]
    for row, other in ((one, two), (two, one)):
        for vertex in (chords.start[other], chords.end[other]):
            near = _passes(chords.start[row], chords.end[row], vertex)
            rows.append(row[near])
            places.append(vertex[near])
    row, found = np.concatenate(rows), np.concatenate(places)
    is_end = (found == chords.start[row]).all(1) | (found == chords.end[row]).all(1)
    return row[~is_end], found[~is_end]


def _near_pairs(chords: Chords) -> tuple[Integers, Integers]:
    """Return the pairs of chords [n], [n] whose boxes, a unit larger on each side, overlap, in order of their left.

    The picture is divided into strips. Each box is compared with those of its strip that begin to the right of it.
    """
    if not len(chords):
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    low, high = np.minimum(chords.start, chords.end) - 1, np.maximum(chords.start, chords.end) + 1
    order = np.argsort(low[:, 0], kind="stable")
    low, high = low[order], high[order]
    first, last = low[:, 1] // CUTTING.strip_units, high[:, 1] // CUTTING.strip_units
    row = np.repeat(np.arange(len(order)), last - first + 1)
    strip = first[row] + counted(last - first + 1)
    by_strip = np.argsort(strip, kind="stable")
    row, strip = row[by_strip], strip[by_strip]
    # One number holds a strip and a place across in it.
    base = (strip - strip[0]) * (high[:, 0].max() - low[0, 0] + 1) - low[0, 0]
    counts = np.searchsorted(base + low[row, 0], base + high[row, 0], side="right") - np.arange(len(row)) - 1
    pairs = []
    for part in _parts(counts):
        place = np.repeat(np.arange(part.start, part.stop), counts[part])
        one, two = row[place], row[place + 1 + counted(counts[part])]
        # A pair that is in several strips counts in the first.
        is_new = np.maximum(first[one], first[two]) == strip[place]
        overlap = is_new & (low[one, 1] <= high[two, 1]) & (low[two, 1] <= high[one, 1])
        pairs.append((one[overlap], two[overlap]))
    one, two = (np.concatenate(each) for each in zip(*pairs, strict=True))
    by_left = np.lexsort((two, one))
    return order[one[by_left]], order[two[by_left]]


def _parts(counts: Integers) -> Iterator[slice]:
    """Yield consecutive slices of ``counts`` [n], each with a sum that takes little memory, or one entry."""
    total = np.cumsum(counts)
    start = 0
    while start < len(counts):
        before = total[start - 1] if start else 0
        stop = max(start + 1, int(np.searchsorted(total, before + CUTTING.pairs_at_once, side="right")))
        yield slice(start, stop)
        start = stop


def _crossings(chords: Chords, one: Integers, two: Integers) -> tuple[Mask, Integers]:
    """Return which pairs cross inside of both chords, and where those do, on the grid."""
    a, c = chords.start[one], chords.start[two]
    along, other = chords.end[one] - a, chords.end[two] - c
    cross = along[:, 0] * other[:, 1] - along[:, 1] * other[:, 0]
    between = c - a
    with np.errstate(divide="ignore", invalid="ignore"):
        share = (between[:, 0] * other[:, 1] - between[:, 1] * other[:, 0]) / cross
        shared = (between[:, 0] * along[:, 1] - between[:, 1] * along[:, 0]) / cross
        crossing = (cross != 0) & (share > 0) & (share < 1) & (shared > 0) & (shared < 1)
    place = a[crossing] + share[crossing, None] * along[crossing]
    return crossing, np.rint(place).astype(np.int64)


def _passes(start: Integers, end: Integers, vertex: Integers) -> Mask:
    """Return which chords [n] pass their ``vertex`` [n, 2] between their ends."""
    along, away = end - start, vertex - start
    length_squared = (along**2).sum(1)
    forward = (along * away).sum(1)
    across = along[:, 0] * away[:, 1] - along[:, 1] * away[:, 0]
    inside = (forward > 0) & (forward < length_squared)
    return inside & (np.abs(across) <= CUTTING.vertex_near * np.sqrt(length_squared))


def _broken(chords: Chords, rows: Integers, places: Integers) -> Chords:
    """Return ``chords`` with each of ``rows`` [n] broken at its ``places`` [n, 2]."""
    along = chords.end - chords.start
    share = ((places - chords.start[rows]) * along[rows]).sum(1) / (along[rows] ** 2).sum(1)
    everything = np.concatenate([np.arange(len(chords)), rows])
    shares = np.concatenate([np.zeros(len(chords)), np.clip(share, 1e-9, 1 - 1e-9)])
    order = np.lexsort((shares, everything))
    row, share = everything[order], shares[order]
    start = np.concatenate([chords.start, places])[order]
    t = chords.t_start[row] + share * (chords.t_end - chords.t_start)[row]
    # A part ends where the next part of the same chord begins.
    follows = np.append(row[1:] == row[:-1], False)
    end, t_end = chords.end[row], chords.t_end[row]
    end[follows], t_end[follows] = start[1:][follows[:-1]], t[1:][follows[:-1]]
    return Chords(start, end, chords.curve[row], t, t_end)
