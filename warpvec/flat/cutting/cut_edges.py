"""Pieces of curves between parts of different owners, each made once for both sides."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from warpvec.arrays import Floats, Integers, Mask
from warpvec.flat.constants.cutting import CUTTING
from warpvec.flat.cutting.fewest_parts import CurvePart, fewest_parts
from warpvec.flat.cutting.planar_map import PlanarMap
from warpvec.watch.watch import UNWATCHED, Watch

_SAME_T = 1e-7
"""Two parameters of a curve that differ by less are the same place."""


_Ends = tuple[int, int]
"""The first and the last half-edge of a chain, or of a part of a curve."""


class Chain(NamedTuple):
    """An edge between two parts of a drawing.

    Attributes:
        parts: consecutive parts of curves.
        start, end: vertices of the map at its ends.
        is_closed: whether it is a loop without a junction.
    """

    parts: list[CurvePart]
    start: int
    end: int
    is_closed: bool


class CutEdges:
    """The edges of ``mapped`` between faces of different ``owners`` [F], joined to parts of ``cubics`` [R, 4, 2].

    Points are rounded to multiples of ``tick``, across and down. Once the ``watch`` is over, parts are not joined.
    """

    def __init__(
        self,
        mapped: PlanarMap,
        owners: Integers,
        cubics: Floats,
        is_line: Mask,
        tick: tuple[float, float] | None = None,
        watch: Watch = UNWATCHED,
    ) -> None:
        self._mapped, self._watch = mapped, watch
        self._tick = None if tick is None else np.array(tick)
        self._cubics = cubics
        self._is_line = is_line
        self._owner = owners[mapped.face]
        self._twin = np.arange(len(mapped.tail)) ^ 1
        self._is_cut = self._owner != self._owner[self._twin]
        self._is_junction, self._is_break = self._breaks()
        self._chains = self._made_chains()

    def loops(self, owner: int) -> list[list[CurvePart]]:
        """Return the closed loops of parts around all parts of ``owner``."""
        loops = []
        for loop in self._loops(np.flatnonzero(self._is_cut & (self._owner == owner))):
            parts = [part for chain in self._split(loop) for part in self._sides[chain[0], chain[-1]]]
            has_length = np.ptp([part.cubic for part in parts], axis=1).any(1)
            joined = [part for part, counts in zip(parts, has_length.tolist(), strict=True) if counts]
            loops += [joined] if len(joined) > 1 else []
        return loops

    def chains(self) -> Iterator[Chain]:
        """Yield each edge once, from junction to junction, with all parts of curves that it follows."""
        tail = self._mapped.tail
        for (first, last), parts in self._chains.items():
            start, end = int(tail[first]), int(tail[last ^ 1])
            yield Chain(parts, start, end, start == end and not self._is_junction[start])

    def _loops(self, half_edges: Integers) -> Iterator[list[int]]:
        """Yield the closed loops of ``half_edges``."""
        following, done = self._following, set[int]()
        for first in half_edges.tolist():
            if first in done:
                continue
            loop, half_edge = [first], following[first]
            while half_edge != first:
                loop.append(half_edge)
                half_edge = following[half_edge]
            done.update(loop)
            yield loop

    @cached_property
    def _following(self) -> list[int]:
        """The half-edge after each one on the outline of its owner [2 E]; -1 for those of no outline."""
        cut = np.flatnonzero(self._is_cut)
        found = self._mapped.following[cut]
        while len(rest := np.flatnonzero(~self._is_cut[found])):
            found[rest] = self._mapped.following[found[rest] ^ 1]
        following = np.full(len(self._is_cut), -1)
        following[cut] = found
        result: list[int] = following.tolist()
        return result

    @cached_property
    def _sides(self) -> dict[_Ends, list[CurvePart]]:
        """The few parts of each chain, and back along it, by its first and its last half-edge."""
        sides = {}
        fewer = fewest_parts(list(self._chains.values()), self._watch)
        rounded = iter(self._on_ticks([part for parts in fewer for part in parts]))
        for (first, last), chain in zip(self._chains, fewer, strict=True):
            parts = [next(rounded) for _ in chain]
            sides[first, last] = parts
            sides[last ^ 1, first ^ 1] = [part.reversed() for part in parts[::-1]]
        return sides

    def _made_chains(self) -> dict[_Ends, list[CurvePart]]:
        """Return the parts of each chain, once for both sides, by its first and its last half-edge."""
        found: dict[_Ends, list[_Ends]] = {}
        for loop in self._loops(np.flatnonzero(self._is_cut)):
            for chain in self._split(loop):
                if (chain[-1] ^ 1, chain[0] ^ 1) not in found:
                    found[chain[0], chain[-1]] = self._parts(chain)
        made = iter(self._made([ends for parts in found.values() for ends in parts]))
        return {key: [next(made) for _ in parts] for key, parts in found.items()}

    def _split(self, loop: list[int]) -> list[list[int]]:
        """Return the chains of a closed ``loop`` of half-edges, from junction to junction."""
        tail = self._mapped.tail
        starts = [k for k, half_edge in enumerate(loop) if self._is_junction[tail[half_edge]]]
        if not starts:
            starts = [self._sharpest(loop)]
        turned = loop[starts[0] :] + loop[: starts[0]]
        places = [start - starts[0] for start in starts]
        return [turned[start:stop] for start, stop in pairwise([*places, len(loop)])]

    def _sharpest(self, loop: list[int]) -> int:
        """Return the place in ``loop`` of the node with the sharpest turn, or of those the first vertex.

        Both sides of an edge rank nodes alike.
        """
        vertices = self._mapped.tail[loop]
        points = self._mapped.vertex[vertices].astype(np.float64)
        come, go = points - np.roll(points, 1, 0), np.roll(points, -1, 0) - points
        dot, squares = (come * go).sum(1), (come * come).sum(1) * (go * go).sum(1)
        cosine = dot / np.sqrt(squares)
        places = np.flatnonzero(self._is_break[vertices])
        return int(places[np.lexsort((vertices[places], cosine[places]))[0]])

    def _parts(self, chain: list[int]) -> list[_Ends]:
        """Return the first and the last half-edge of each part of a curve along a ``chain`` of half-edges."""
        is_break = self._is_break[self._mapped.tail[chain]]
        starts = [0, *(np.flatnonzero(is_break[1:]) + 1).tolist()]
        return [(chain[start], chain[stop - 1]) for start, stop in pairwise([*starts, len(chain)])]

    def _made(self, parts: list[_Ends]) -> list[CurvePart]:
        """Return the parts with these first and last half-edges."""
        if not parts:
            return []
        mapped, (first, last) = self._mapped, np.array(parts).T
        curve = mapped.curve[first // 2]
        start, end = (mapped.vertex[mapped.tail[each]] / CUTTING.units for each in (first, last ^ 1))
        made = line_cubics(start, end)
        bends = np.flatnonzero(~self._is_line[curve])
        t_first, t_last = mapped.t[first // 2, first % 2], mapped.t[last // 2, 1 - last % 2]
        cubic = between(self._cubics[curve[bends]], t_first[bends], t_last[bends])
        # The ends lie on the grid, where all pieces meet.
        made[bends, 1] = cubic[:, 1] + (start[bends] - cubic[:, 0])
        made[bends, 2] = cubic[:, 2] + (end[bends] - cubic[:, 3])
        made[bends, 3] = end[bends]
        return [CurvePart(cubic, line) for cubic, line in zip(made, self._is_line[curve].tolist(), strict=True)]

    def _on_ticks(self, parts: list[CurvePart]) -> list[CurvePart]:
        """Return ``parts`` with points on ticks; the handles of lines are at thirds."""
        if self._tick is None or not parts:
            return parts
        cubics = np.rint(np.stack([part.cubic for part in parts]) / self._tick) * self._tick
        is_line = [part.is_line for part in parts]
        cubics[is_line] = line_cubics(cubics[is_line, 0], cubics[is_line, 3])
        return [CurvePart(cubic, line) for cubic, line in zip(cubics, is_line, strict=True)]

    def _breaks(self) -> tuple[Mask, Mask]:
        """Return the vertices [V] where more than two outlines meet or one ends, and all where a part of a curve ends.

        The latter are also those where one curve follows another.
        """
        mapped = self._mapped
        cut = np.flatnonzero(self._is_cut)
        cut = cut[np.argsort(mapped.tail[cut], kind="stable")]
        tail, curve, t = mapped.tail[cut], mapped.curve[cut // 2], mapped.t[cut // 2, cut % 2]
        is_junction = np.bincount(tail, minlength=len(mapped.vertex)) != 2
        is_break = is_junction.copy()
        differs = (curve[1:] != curve[:-1]) | (np.abs(np.diff(t)) > _SAME_T)
        is_break[tail[1:][differs & (tail[1:] == tail[:-1])]] = True
        return is_junction, is_break


def line_cubics(start: Floats, end: Floats) -> Floats:
    """Return the control points [P, 4, 2] of lines from ``start`` to ``end`` [P, 2]."""
    return start[:, None] + np.linspace(0, 1, 4)[:, None] * (end - start)[:, None]


def between(cubics: Floats, first: Floats, last: Floats) -> Floats:
    """Return the control points [P, 4, 2] of the parts of ``cubics`` from parameters ``first`` to ``last`` [P]."""

    def blossom(*parameters: Floats) -> Floats:
        points = cubics
        for u in parameters:
            points = points[:, :-1] + u[:, None, None] * (points[:, 1:] - points[:, :-1])
        return points[:, 0]

    return np.stack([blossom(*[first] * (3 - k), *[last] * k) for k in range(4)], 1)
