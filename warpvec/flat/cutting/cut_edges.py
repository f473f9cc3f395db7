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
        self._pieces: dict[tuple[int, int], CurvePart] = {}

    def loops(self, owner: int) -> list[list[CurvePart]]:
        """Return the closed loops of pieces around all parts of ``owner``."""
        waiting = dict.fromkeys(np.flatnonzero(self._is_cut & (self._owner == owner)).tolist())
        loops = []
        while waiting:
            loop = [next(iter(waiting))]
            while (following := self._next(loop[-1])) != loop[0]:
                loop.append(following)
            for half_edge in loop:
                del waiting[half_edge]
            joined = [piece for piece in self._joined(loop) if np.ptp(piece.cubic, axis=0).any()]
            loops += [joined] if len(joined) > 1 else []
        return loops

    def _next(self, half_edge: int) -> int:
        """Return the half-edge after ``half_edge`` on the outline of its owner."""
        found = int(self._mapped.following[half_edge])
        while not self._is_cut[found]:
            found = int(self._mapped.following[found ^ 1])
        return found

    def _joined(self, loop: list[int]) -> list[CurvePart]:
        """Return the pieces of a closed ``loop`` of half-edges."""
        tail = self._mapped.tail
        breaks = [k for k, half_edge in enumerate(loop) if self._is_break[tail[half_edge]]]
        return [self._piece(loop[k], loop[stop - 1]) for k, stop in zip(breaks, breaks[1:] + breaks[:1], strict=True)]

    def _piece(self, first: int, last: int) -> CurvePart:
        """Return the piece from the tail of the half-edge ``first`` to the head of ``last``."""
        if (first, last) not in self._pieces:
            piece = self._made(first, last)
            self._pieces[first, last] = piece
            # The other side runs back along the same points.
            self._pieces[last ^ 1, first ^ 1] = CurvePart(piece.cubic[::-1], piece.is_line)
        return self._pieces[first, last]

    def _made(self, first: int, last: int) -> CurvePart:
        mapped = self._mapped
        curve = int(mapped.curve[first // 2])
        t_first, t_last = mapped.t[first // 2, first % 2], mapped.t[last // 2, 1 - last % 2]
        start, end = (self._rounded(mapped.vertex[mapped.tail[each]] / CUTTING.units) for each in (first, last ^ 1))
        if self._is_line[curve]:
            return CurvePart(start + np.linspace(0, 1, 4)[:, None] * (end - start), True)
        cubic = _between(self._cubics[curve], float(t_first), float(t_last))
        # The ends lie on the grid, where all pieces meet.
        handles = self._rounded(cubic[1:3] + np.stack([start - cubic[0], end - cubic[3]]))
        return CurvePart(np.stack([start, *handles, end]), False)

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


def _between(cubic: Floats, first: float, last: float) -> Floats:
    """Return the control points [4, 2] of the part of ``cubic`` from the parameter ``first`` to ``last``."""

    def blossom(*parameters: float) -> Floats:
        points = cubic
        for u in parameters:
            points = points[:-1] + u * (points[1:] - points[:-1])
        return points[0]

    return np.stack([blossom(*[first] * (3 - k), *[last] * k) for k in range(4)])
