"""Make outlines simple: none crosses itself or another loop of its path, in the coordinates that the file states.

The loops of a path that meet are laid into a planar map whose vertices are the ticks of the file, and what the path
fills is outlined once more. Curves stay but where they are cut. If a cut curve still meets another one, once it is
rounded, lines follow both its ends, where they part too slowly for the ticks, each round twice as far. Lines between
the vertices of such a map meet in their ends only.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import torch

from warpvec.arrays import Floats, Integers, Mask
from warpvec.flat.connected_parts import connected_parts
from warpvec.flat.constants.cutting import CUTTING
from warpvec.flat.cutting.cut_edges import between, line_cubics
from warpvec.flat.cutting.noding import Chords, chords_of, noded
from warpvec.flat.cutting.planar_map import PlanarMap, planar_map
from warpvec.geometry.bezier import whole_curves
from warpvec.geometry.crossings import FOLD_WIDTH
from warpvec.geometry.meetings import meeting_rows
from warpvec.geometry.scene import Scene, straightened
from warpvec.geometry.structure import Structure
from warpvec.geometry.walks import simple_walks

ROUNDS_MAX = 8
"""Most times that lines follow the curves which still meet further; the last time they follow all of the path."""

EVERYTHING = np.iinfo(np.int64).max
"""The count of chords at each end of a curve that are lines if all are."""


class _Loop(NamedTuple):
    """A closed loop.

    Attributes:
        cubics: its curves in ticks [k, 4, 2].
        is_line: which of them are lines [k].
        source: the curve of the path that each follows [k].
    """

    cubics: Floats
    is_line: Mask
    source: Integers


def with_simple_outlines(scene: Scene, tick: tuple[float, float]) -> Scene:
    """Return ``scene``, whose points are multiples of ``tick`` pixels, across and down, with simple outlines.

    What a path fills stays, but for crumbs that nobody sees: see `crossings.FOLD_WIDTH`. A path of crumbs is left out.
    Strokes and forms stay.
    """
    meets = meeting_rows(scene)
    if not meets.any():
        return scene
    owner = scene.structure.segment_path.cpu().numpy()
    rows = np.unique(owner[meets])
    some = scene.select(torch.from_numpy(rows).to(scene.segments.device))
    paths = [_Path(some.select(torch.tensor([k])), meets[owner == row], tick) for k, row in enumerate(rows.tolist())]
    loops = [path.loops() for path in paths]
    for left in reversed(range(ROUNDS_MAX)):
        meets = meeting_rows(_with_loops(some, dict(enumerate(loops)), tick))
        if not meets.any():
            break
        ends = np.cumsum([sum(len(loop.cubics) for loop in own) for own in loops])
        for path, own, met in zip(paths, loops, np.split(meets, ends[:-1]), strict=True):
            path.follow(own, met, is_last=left <= 1)
        loops = [path.loops() for path in paths]
    return _with_loops(scene, dict(zip(rows.tolist(), loops, strict=True)), tick)


class _Path:
    """A path while it becomes simple: its loops that meet are outlined once more, the others stay.

    Args:
        one: a scene of this path.
        meets: its curves that meet others [R].
        tick: see `with_simple_outlines`.
    """

    def __init__(self, one: Scene, meets: Mask, tick: tuple[float, float]) -> None:
        self._cubics = whole_curves(one).double().cpu().numpy() / tick
        self._is_line, self._tick = one.structure.lines.cpu().numpy(), tick
        self._first = one.structure.loop_first_segment.cpu().numpy().astype(np.int64)
        self._loop = np.repeat(np.arange(len(self._first) - 1), np.diff(self._first))
        # Chords on a grid whose units are ticks.
        self._chords = chords_of(self._cubics / CUTTING.units, self._is_line, 1.0 / CUTTING.units)
        self._line_count = np.zeros(len(meets), np.int64)
        self._outline(np.isin(self._loop, self._loop[meets]))

    def loops(self) -> list[_Loop]:
        """Return its loops, without crumbs."""
        return self._others + self._outlines.loops(self._line_count)

    def follow(self, loops: list[_Loop], meets: Mask, *, is_last: bool) -> None:
        """Let lines follow the curves that in ``loops`` still meet others further, or all curves if ``is_last``."""
        if not meets.any():
            return
        source = np.unique(np.concatenate([loop.source for loop in loops])[meets])
        self._line_count[source] = np.maximum(2 * self._line_count[source], 1)
        if is_last:
            self._line_count[:] = EVERYTHING
        if is_last or not self._is_met[source].all():
            self._outline(np.ones_like(self._is_met))

    def _outline(self, is_met: Mask) -> None:
        """Outline the curves of the loops that meet [R] once more; all if others lie where they are wound twice."""
        self._is_met, is_own = is_met, is_met[self._chords.curve]
        own, rest = self._chords.select(is_own), self._chords.select(~is_own)
        self._outlines = _Outlines(noded(own), rest, self._cubics, self._is_line, self._turn(), self._tick)
        others = [slice(a, b) for a, b in pairwise(self._first.tolist()) if not is_met[a]]
        self._others = [_Loop(self._cubics[a], self._is_line[a], np.arange(a.start, a.stop)) for a in others]
        begins = np.searchsorted(rest.curve, [each.start for each in others])
        begins = begins[begins < len(rest.curve)]  # a loop of one point has no chord
        places = (rest.start[begins] + rest.end[begins]) / 2.0
        if (_windings(own.start, own.end, places) != _windings(*self._outlines.edges(), places)).any():
            self._outline(np.ones_like(is_met))

    def _turn(self) -> int:
        """Return 1 if the largest loop runs around its area as edges of a planar map do, else -1."""
        a, b = self._chords.start.astype(np.float64), self._chords.end.astype(np.float64)
        loop = self._loop[self._chords.curve]
        areas = np.bincount(loop, a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
        return 1 if areas[np.argmax(np.abs(areas))] >= 0.0 else -1


def _is_crumb(corners: Floats) -> bool:
    """Return whether nobody sees a polygon of ``corners`` [k, 2] in pixels, since it is small or thin."""
    after = np.roll(corners, -1, 0)
    area = 0.5 * abs(float((corners[:, 0] * after[:, 1] - corners[:, 1] * after[:, 0]).sum()))
    half = 0.5 * float(np.hypot(*(after - corners).T).sum())
    return area <= FOLD_WIDTH * max(1.0, half)


def _windings(start: Integers, end: Integers, places: Floats) -> Integers:
    """Return how often closed polygons of the edges from ``start`` to ``end`` [K, 2] wind around ``places`` [n, 2]."""
    found = np.zeros(len(places), np.int64)
    for k, (x, y) in enumerate(places):
        rises = (start[:, 1] <= y).astype(np.int64) - (end[:, 1] <= y)
        near = np.flatnonzero(rises)
        a, b = start[near], end[near]
        side = (b[:, 0] - a[:, 0]) * (y - a[:, 1]) - (x - a[:, 0]) * (b[:, 1] - a[:, 1])
        found[k] = rises[near][np.sign(side) == rises[near]].sum()
    return found


class _Outlines:
    """The outlines of what a path fills, along those of its ``chords`` that were outlined once more.

    Args:
        chords: those that meet in their ends only.
        rest: the chords of its other loops.
        cubics, is_line: its curves in ticks [R, 4, 2], and which are lines [R].
        turn: 1, or -1 to run the other way.
        tick: in pixels, across and down.
    """

    def __init__(
        self, chords: Chords, rest: Chords, cubics: Floats, is_line: Mask, turn: int, tick: tuple[float, float]
    ) -> None:
        mapped = planar_map(chords, np.zeros(len(cubics), np.int64), 1)
        self._mapped, self._cubics, self._is_line, self._turn = mapped, cubics, is_line, turn
        is_inside = mapped.winding[mapped.face, 0] + _around(mapped, rest) != 0
        self._is_edge = is_inside & ~is_inside[np.arange(len(is_inside)) ^ 1]
        tails = mapped.tail[self._is_edge]
        self._is_junction = np.bincount(tails, minlength=len(mapped.vertex)) > 1
        walks = (np.array(walk) for walk in self._walked())
        parts = [walk[part] for walk in walks for part in simple_walks(mapped.tail[walk].tolist())]
        self._walks = [part for part in parts if not _is_crumb(mapped.vertex[mapped.tail[part]] * tick)]

    def edges(self) -> tuple[Integers, Integers]:
        """Return the start and the end of each edge [K, 2] in ticks."""
        ends = self._mapped.vertex[self._mapped.tail].reshape(-1, 2, 2)
        both = np.stack([ends, ends[:, ::-1]], 1).reshape(-1, 2, 2)[self._is_edge]
        both = both[:, :: self._turn]
        return both[:, 0], both[:, 1]

    def loops(self, line_count: Integers) -> list[_Loop]:
        """Return the loops; at each end of a curve, ``line_count`` [R] of its chords take its place."""
        return [self._loop(walk, line_count) for walk in self._walks]

    def _walked(self) -> list[list[int]]:
        """Return the closed walks of half-edges around each area, which may pass a vertex more than once."""
        following, is_edge = self._mapped.following.tolist(), self._is_edge.tolist()
        walks, done = [], set[int]()
        for first in np.flatnonzero(self._is_edge).tolist():
            walk, half_edge = [], first
            while half_edge not in done:
                done.add(half_edge)
                walk.append(half_edge)
                half_edge = following[half_edge]
                while not is_edge[half_edge]:
                    half_edge = following[half_edge ^ 1]
            walks += [walk] if walk else []
        return walks

    def _loop(self, walk: Integers, line_count: Integers) -> _Loop:
        """Return the loop along a closed ``walk``, with a curve for each run of chords that follow one."""
        mapped, goes_on = self._mapped, self._goes_on(walk)
        begin = int(np.argmin(goes_on))
        walk, goes_on = np.roll(walk, -begin), np.roll(goes_on, -begin)
        side, curve, vertex = walk % 2, mapped.curve[walk // 2], mapped.tail[walk]
        first, last = mapped.t[walk // 2, side], mapped.t[walk // 2, 1 - side]
        is_chord = _from_ends(goes_on) < line_count[curve]
        starts = np.flatnonzero(~goes_on | is_chord | np.roll(is_chord, 1))
        if not len(starts):  # one closed curve
            starts = np.zeros(1, np.int64)
        source, stops = curve[starts], np.append(starts[1:], starts[0]) - 1
        start, end = mapped.vertex[vertex[starts]], mapped.vertex[np.roll(vertex[starts], -1)]
        cubics = line_cubics(start.astype(np.float64), end.astype(np.float64))
        is_line = self._is_line[source] | is_chord[starts]
        bends = np.flatnonzero(~is_line)
        cut = between(self._cubics[source[bends]], first[starts[bends]], last[stops[bends]])
        cubics[bends, 1] = np.rint(cut[:, 1] + start[bends] - cut[:, 0])
        cubics[bends, 2] = np.rint(cut[:, 2] + end[bends] - cut[:, 3])
        return (
            _Loop(cubics, is_line, source) if self._turn > 0 else _Loop(cubics[::-1, ::-1], is_line[::-1], source[::-1])
        )

    def _goes_on(self, walk: Integers) -> Mask:
        """Return which half-edges of a closed ``walk`` [n] go on along the curve of the one before."""
        mapped, side = self._mapped, walk % 2
        curve, first, last = mapped.curve[walk // 2], mapped.t[walk // 2, side], mapped.t[walk // 2, 1 - side]
        is_same = (curve == np.roll(curve, 1)) & (first == np.roll(last, 1))
        return np.asarray(is_same & ~self._is_junction[mapped.tail[walk]])


def _from_ends(goes_on: Mask) -> Integers:
    """Return how many members lie between each one of runs and the nearer end of its run [n].

    A member that ``goes_on`` [n] belongs to the run of the one before; the first does not.
    """
    place = np.arange(len(goes_on))
    starts = np.flatnonzero(~goes_on) if not goes_on.all() else np.zeros(1, np.int64)
    lengths = np.diff(np.append(starts, len(goes_on)))
    from_start = place - np.repeat(starts, lengths)
    return np.minimum(from_start, np.repeat(lengths, lengths) - 1 - from_start)


def _around(mapped: PlanarMap, rest: Chords) -> Integers:
    """Return how often ``rest``, which meets nothing of ``mapped``, winds around each half-edge [2 E]."""
    part = connected_parts(mapped.tail[::2], mapped.tail[1::2], len(mapped.vertex))[mapped.tail]
    ends = mapped.vertex[mapped.tail].reshape(-1, 2, 2)
    number, first, own = np.unique(part[::2], return_index=True, return_inverse=True)
    around = _windings(rest.start, rest.end, ends[first].mean(1)) if len(number) else np.zeros(0, np.int64)
    return np.repeat(around[own], 2)


def _with_loops(scene: Scene, loops: dict[int, list[_Loop]], tick: tuple[float, float]) -> Scene:
    """Return ``scene`` with ``loops`` in place of those of some paths; paths without any are left out."""
    structure, is_line = scene.structure, scene.structure.lines.cpu().numpy()
    segments, end_rows = scene.segments.double().cpu().numpy(), structure.end_rows.cpu().numpy()
    first = structure.loop_first_segment.cpu().numpy().astype(np.int64)
    rows, lines, ends, counts = [np.zeros((0, 3, 2))], [np.zeros(0, bool)], [], []
    for path, (start, stop) in enumerate(pairwise(structure.path_first_loop.tolist())):
        made = loops.get(path)
        if made is None:
            own = slice(first[start], first[stop])
            rows.append(segments[own])
            lines.append(is_line[own])
            ends += end_rows[first[start + 1 : stop + 1] - 1].tolist()
            counts.append(np.diff(first[start : stop + 1]).tolist())
        elif made:
            rows += [loop.cubics[:, :3] * tick for loop in made]
            lines += [loop.is_line for loop in made]
            ends += [False] * len(made)
            counts.append([len(loop.cubics) for loop in made])
    kept = [path for path in range(len(scene)) if loops.get(path) != []]
    has_line, is_open = torch.from_numpy(np.concatenate(lines)), torch.tensor(ends, dtype=torch.bool)
    made_of = Structure.of_loops(counts, has_line if has_line.any() else None, is_open if is_open.any() else None)
    chosen = scene.select(torch.tensor(kept, dtype=torch.int64, device=scene.segments.device))
    placed = torch.from_numpy(np.concatenate(rows)).to(scene.segments)
    return replace(chosen, segments=straightened(placed, made_of.to(placed.device)), structure=made_of)
