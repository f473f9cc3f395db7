"""Pieces of curves between parts of different owners, each made once for both sides."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warpvec.arrays import Floats, Integers, Mask
from warpvec.flat.constants.cutting import CUTTING
from warpvec.flat.cutting.planar_map import PlanarMap

_SAME_T = 1e-7
"""Two parameters of a curve that differ by less are the same place."""


class CurvePart(NamedTuple):
    """A part of a curve: its control points [4, 2] in pixels, and whether it is a line."""

    cubic: Floats
    is_line: bool


_Ends = tuple[int, int]
"""The first and the last half-edge of a piece."""


class CutEdges:
    """The edges of ``mapped`` between faces of different ``owners`` [F], joined to pieces of ``cubics`` [R, 4, 2].

    Points are rounded to multiples of ``tick``, across and down.
    """

    def __init__(
        self,
        mapped: PlanarMap,
        owners: Integers,
        cubics: Floats,
        is_line: Mask,
        tick: tuple[float, float] | None = None,
    ) -> None:
        self._mapped = mapped
        self._tick = None if tick is None else np.array(tick)
        self._cubics = cubics
        self._is_line = is_line
        self._owner = owners[mapped.face]
        self._twin = np.arange(len(mapped.tail)) ^ 1
        self._is_cut = self._owner != self._owner[self._twin]
        self._is_break = self._breaks()
        self._pieces: dict[_Ends, CurvePart] = {}
        self._points: set[_Ends] = set()  # pieces without length

    def loops(self, owner: int) -> list[list[CurvePart]]:
        """Return the closed loops of pieces around all parts of ``owner``."""
        waiting = dict.fromkeys(np.flatnonzero(self._is_cut & (self._owner == owner)).tolist())
        loops: list[list[_Ends]] = []
        while waiting:
            loop = [next(iter(waiting))]
            while (following := self._next(loop[-1])) != loop[0]:
                loop.append(following)
            for half_edge in loop:
                del waiting[half_edge]
            loops.append(self._joined(loop))
        self._make([ends for loop in loops for ends in loop])
        made = ([self._pieces[ends] for ends in loop if ends not in self._points] for loop in loops)
        return [pieces for pieces in made if len(pieces) > 1]

    def _next(self, half_edge: int) -> int:
        """Return the half-edge after ``half_edge`` on the outline of its owner."""
        found = int(self._mapped.following[half_edge])
        while not self._is_cut[found]:
            found = int(self._mapped.following[found ^ 1])
        return found

    def _joined(self, loop: list[int]) -> list[_Ends]:
        """Return the first and the last half-edge of each piece of a closed ``loop`` of half-edges."""
        breaks = np.flatnonzero(self._is_break[self._mapped.tail[loop]]).tolist()
        return [(loop[k], loop[stop - 1]) for k, stop in zip(breaks, breaks[1:] + breaks[:1], strict=True)]

    def _make(self, pieces: list[_Ends]) -> None:
        """Make those of ``pieces``, from the tail of the first to the head of the last, that the other side lacks."""
        missing: dict[_Ends, None] = {}
        for first, last in pieces:
            if (first, last) not in self._pieces and (last ^ 1, first ^ 1) not in missing:
                missing[first, last] = None
        if not missing:
            return
        cubics, is_line = self._made(np.array(list(missing)))
        is_point = (cubics == cubics[:, :1]).all((1, 2))
        for ends, cubic, line, point in zip(missing, cubics, is_line.tolist(), is_point.tolist(), strict=True):
            other = (ends[1] ^ 1, ends[0] ^ 1)  # the other side runs back along the same points
            self._pieces[ends], self._pieces[other] = CurvePart(cubic, line), CurvePart(cubic[::-1], line)
            if point:
                self._points |= {ends, other}

    def _made(self, ends: Integers) -> tuple[Floats, Mask]:
        """Return the control points [P, 4, 2] of pieces with these first and last half-edges [P, 2], and the lines."""
        mapped, (first, last) = self._mapped, ends.T
        curve = mapped.curve[first // 2]
        start, end = (self._rounded(mapped.vertex[mapped.tail[each]] / CUTTING.units) for each in (first, last ^ 1))
        made = start[:, None] + np.linspace(0, 1, 4)[:, None] * (end - start)[:, None]
        bends = np.flatnonzero(~self._is_line[curve])
        t_first, t_last = mapped.t[first // 2, first % 2], mapped.t[last // 2, 1 - last % 2]
        cubic = _between(self._cubics[curve[bends]], t_first[bends], t_last[bends])
        # The ends lie on the grid, where all pieces meet.
        made[bends, 1] = self._rounded(cubic[:, 1] + (start[bends] - cubic[:, 0]))
        made[bends, 2] = self._rounded(cubic[:, 2] + (end[bends] - cubic[:, 3]))
        made[bends, 3] = end[bends]
        return made, self._is_line[curve]

    def _rounded(self, points: Floats) -> Floats:
        return points if self._tick is None else np.rint(points / self._tick) * self._tick

    def _breaks(self) -> Mask:
        """Return the vertices [V] where a piece ends: junctions, and where one curve follows another."""
        mapped = self._mapped
        cut = np.flatnonzero(self._is_cut)
        cut = cut[np.argsort(mapped.tail[cut], kind="stable")]
        tail, curve, t = mapped.tail[cut], mapped.curve[cut // 2], mapped.t[cut // 2, cut % 2]
        is_break = np.bincount(tail, minlength=len(mapped.vertex)) != 2
        differs = (curve[1:] != curve[:-1]) | (np.abs(np.diff(t)) > _SAME_T)
        is_break[tail[1:][differs & (tail[1:] == tail[:-1])]] = True
        return is_break


def _between(cubics: Floats, first: Floats, last: Floats) -> Floats:
    """Return the control points [P, 4, 2] of the parts of ``cubics`` from parameters ``first`` to ``last`` [P]."""

    def blossom(*parameters: Floats) -> Floats:
        points = cubics
        for u in parameters:
            points = points[:, :-1] + u[:, None, None] * (points[:, 1:] - points[:, :-1])
        return points[:, 0]

    return np.stack([blossom(*[first] * (3 - k), *[last] * k) for k in range(4)], 1)
