"""Dashes of straight lines: a short way to state equal lines that follow each other on one line.

A dashed line goes from a place to another in ticks, units of the last decimal. It stands for lines whose ends are
rounded to ticks, so a scene knows nothing of dashes: the writer states them where the lines of a path are those of a
dashed one, and the reader gives the lines back.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from warpvec.geometry.scene import Scene
from warpvec.svg.path_data import OWN_NUMBER, Loop, decimals_of, format_path, is_own_data, read_loops, with_points

Ticks = NDArray[np.int64]
Floats = NDArray[np.float64]

COUNT_MIN, COUNT_MAX = 3, 2**12
"""Fewest and most dashes of a line."""

_KINDS = 2
"""Most kinds of dashes that take turns."""


class Dashes(NamedTuple):
    """A dashed line: its ends [2] and the lengths of dashes and gaps in turn, in ticks."""

    start: Ticks
    end: Ticks
    lengths: tuple[int, ...]


def paths_of_lines(scene: Scene) -> dict[int, slice]:
    """Return the paths that are at least ``COUNT_MIN`` stroked lines, and their rows: two for each line."""
    structure, strokes = scene.structure, scene.strokes
    if strokes is None or structure.is_open is None or structure.is_line is None:
        return {}
    first_loop, first_row = structure.path_first_loop.tolist(), structure.loop_first_segment.cpu().numpy()
    is_plain = (
        structure.is_open.cpu().numpy() & (np.diff(first_row) == 2) & structure.is_line.cpu().numpy()[first_row[:-1]]
    )
    is_free = (strokes.is_stroked if scene.forms is None else strokes.is_stroked & ~scene.forms.is_form).tolist()
    return {
        path: slice(int(first_row[start]), int(first_row[stop]))
        for path, (start, stop) in enumerate(pairwise(first_loop))
        if is_free[path] and stop - start >= COUNT_MIN and is_plain[start:stop].all()
    }


def dash_ends(dashes: Dashes) -> Ticks:
    """Return the ends [n, 2, 2] of the lines that ``dashes`` stand for, in ticks; the last one may be cut."""
    way = (dashes.end - dashes.start).astype(np.float64)
    length = float(np.hypot(*way))
    places = np.append(0.0, np.cumsum(dashes.lengths))
    count = max(1, math.ceil(length / places[-1]))
    begins = (np.arange(count)[:, None] * places[-1] + places[:-1:2]).ravel()
    ends = (np.arange(count)[:, None] * places[-1] + places[1::2]).ravel()
    is_there = begins < length - 0.5  # no dash is shorter than half of a tick
    along = np.stack([begins, np.minimum(ends, length)], 1)[is_there]
    found: Ticks = dashes.start + np.rint(along[..., None] * (way / max(length, 1e-9))).astype(np.int64)
    found[-1, 1] = dashes.end if ends[is_there][-1] > length - 0.5 else found[-1, 1]
    return found


def dashes_of(lines: Ticks) -> Dashes | None:
    """Return the dashed line that ``lines`` [n, 2, 2] are exactly, in ticks, in the fewest digits; None for none."""
    if not COUNT_MIN <= len(lines) <= COUNT_MAX:
        return None
    start, end = lines[0, 0], lines[-1, 1]
    way = (end - start).astype(np.float64)
    length = float(np.hypot(*way))
    if length == 0.0:
        return None
    low, high = _along(lines, start, way / length)
    for kinds in range(1, _KINDS + 1):
        lengths = _lengths(low, high, kinds)
        if lengths is not None:
            found = Dashes(start, end, lengths)
            if np.array_equal(dash_ends(found), lines):
                return found
    return None


def read_dashes(loops: list[Loop], array: str, decimals: int) -> list[Loop] | None:
    """Return the dashes of a line, the only one of ``loops``, by the lengths that its file states; None if not ours."""
    words = array.split(" ")
    is_line = len(loops) == 1 and loops[0].is_open and len(loops[0].ticks) == 2 and bool(loops[0].is_line[0])
    if not is_line or len(words) % 2 or not all(map(OWN_NUMBER.fullmatch, words)):
        return None
    lengths = tuple(round(float(word) * 10**decimals) for word in words)
    start, end = loops[0].ticks[:, 0]
    turn_count = float(np.hypot(*(end - start).astype(np.float64))) / max(sum(lengths), 1)
    if min(lengths) <= 0 or turn_count * len(words) / 2.0 > COUNT_MAX:
        return None
    ends = np.repeat(dash_ends(Dashes(start, end, lengths))[:, :, None], 3, 2)
    return [Loop(ticks, np.array([True, True]), is_open=True) for ticks in ends]


def plain_data(data: str, array: str) -> str | None:
    """Return the data of the dashes of a path with ``data`` and the dashes ``array``; None if that is not ours."""
    if not is_own_data(data, is_stroke=True):
        return None
    decimals = max(map(decimals_of, (data, array)))
    loops = read_dashes(read_loops(with_points(data), decimals), array, decimals)
    return None if loops is None else format_path(loops, decimals)


def near_dashes(lines: Floats, miss_max: float) -> Dashes | None:
    """Return a dashed line whose dashes are at most ``miss_max`` off those of ``lines`` [n, 2, 2]; None for none.

    All are in ticks. The last dash may be cut.
    """
    if not COUNT_MIN <= len(lines) <= COUNT_MAX:
        return None
    way = lines[-1, 1] - lines[0, 0]
    way = way / max(float(np.hypot(*way)), 1e-9)
    places, number = (lines - lines[0, 0]) @ way, np.arange(len(lines))
    for kinds in range(1, _KINDS + 1):
        turn, kind = number // kinds, number % kinds
        if turn[-1] == 0:
            return None
        period = round(float((places[turn[-1] * kinds, 0] - places[0, 0]) / turn[-1]))
        own = places - period * turn[:, None]
        own[-1, 1] = np.nan
        usual = np.rint(np.concatenate([np.nanmedian(own[kind == k], 0) for k in range(kinds)]))
        sides = np.diff([*usual, usual[0] + period])
        if not sides.min() > 0.0:  # or nobody knows them
            continue
        begins = period * turn + usual[0::2][kind] - usual[0]
        start = np.rint(lines[0, 0] + np.median(places[:, 0] - begins) * way)
        last = min(float(places[-1, 1] - places[-1, 0]), float(sides[0::2][kind[-1]]))
        end = np.rint(start + (begins[-1] + last) * way)
        found = Dashes(start.astype(np.int64), end.astype(np.int64), tuple(sides.astype(np.int64).tolist()))
        drawn = dash_ends(found)
        if drawn.shape == lines.shape and np.abs(drawn - lines).max() <= miss_max:
            return found
    return None


def _along(lines: Ticks, start: Ticks, way: Floats) -> tuple[Floats, Floats]:
    """Return the least and largest distance [n, 2] from ``start`` along ``way`` [2] that is rounded to each end."""
    off = (lines - start)[..., way != 0.0].astype(np.float64)
    bounds = np.sort(np.stack([off - 0.5, off + 0.5]) / way[way != 0.0], axis=0)
    return bounds[0].max(-1), bounds[1].min(-1)


def _lengths(low: Floats, high: Floats, kinds: int) -> tuple[int, ...] | None:
    """Return the lengths of ``kinds`` of dashes and of their gaps by the bounds [n, 2] of their ends; None if none fit.

    The last dash may be shorter, so that its end says nothing.
    """
    number = np.arange(len(low))
    turn, kind = number // kinds, number % kinds
    if turn[-1] == 0:
        return None
    period = _shortest(*(bound[(kind == 0) & (turn > 0), 0] / turn[(kind == 0) & (turn > 0)] for bound in (low, high)))
    if period is None:
        return None
    places = []
    for k in range(kinds):
        own = kind == k
        begin = _shortest(*(bound[own, 0] - turn[own] * period for bound in (low, high))) if k else 0
        whole = own & (number < len(low) - 1)
        end = _shortest(*(bound[whole, 1] - turn[whole] * period for bound in (low, high)))
        if begin is None or end is None:
            return None
        places += [begin, end]
    sides = np.diff([*places, period]).tolist()
    return tuple(sides) if min(sides) > 0 else None


def _shortest(low: Floats, high: Floats) -> int | None:
    """Return the roundest whole number within all bounds [n]; None if there is none."""
    least, most = float(low.max()), float(high.min())
    for unit in (1000, 100, 10, 1):
        nearest = round((least + most) / 2.0 / unit) * unit
        if least < nearest < most:
            return nearest
    return None
