"""One exact node where lines meet: each line gets a node there, and ends are moved onto it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from warpvec.arrays import Floats, Integers, counted
from warpvec.flat.constants.lines import LINES
from warpvec.flat.lines.line import DrawnLine
from warpvec.flat.simplification.outline_samples import cubic_points
from warpvec.flat.strokes.line_fitting import Rows, curves_of


class _Pieces(NamedTuple):
    """Short pieces of all lines.

    Attributes:
        start, end: [K, 2] px.
        line: the line of each [K].
        place: its start along the line [K]: the number of the curve, plus the parameter there.
        step: how far it goes on by that measure [K].
        along: length of the line before it in pixels [K].
    """

    start: Floats
    end: Floats
    line: Integers
    place: Floats
    step: Floats
    along: Floats


@dataclass
class _Meeting:
    """A place [2] where lines meet: places along lines, by line, and ends: a line, and whether it is its start."""

    place: Floats
    cuts: dict[int, float] = field(default_factory=dict)
    ends: set[tuple[int, bool]] = field(default_factory=set)


def attached_ends(lines: list[DrawnLine]) -> set[tuple[int, bool]]:
    """Return the ends that lie on other lines: the number of the line, and whether it is its start."""
    if not lines:
        return set()
    pieces = _pieces(lines)
    crossings = _crossings(lines, pieces)
    ended = {end for meeting in crossings for end in meeting.ends}
    return ended | {end for meeting in _end_meetings(lines, pieces, ended, set()) for end in meeting.ends}


def with_shared_nodes(lines: list[DrawnLine], attached: set[tuple[int, bool]]) -> list[DrawnLine]:
    """Return ``lines`` with the very same node in all of them that meet at a place. Dots stay.

    Args:
        lines: in pixels.
        attached: the ends that lay on other lines before a fit. Their own line hides how far they reach.
    """
    if not lines:
        return lines
    pieces = _pieces(lines)
    meetings = _crossings(lines, pieces)
    ended = {end for meeting in meetings for end in meeting.ends}
    meetings += _end_meetings(lines, pieces, ended, attached)
    cuts: dict[int, list[tuple[float, Floats]]] = {}
    ends: dict[tuple[int, bool], Floats] = {}
    for meeting in _merged(lines, meetings):
        for line, place in meeting.cuts.items():
            cuts.setdefault(line, []).append((place, meeting.place))
        ends |= dict.fromkeys(meeting.ends, meeting.place)
    return [_changed(line, cuts.get(k, []), ends.get((k, True)), ends.get((k, False))) for k, line in enumerate(lines)]


def _pieces(lines: list[DrawnLine]) -> _Pieces:
    parts = []
    for number, line in enumerate(lines):
        curves = curves_of(line.rows)
        lengths = np.linalg.norm(np.diff(curves, axis=1), axis=2).sum(1)
        counts = np.maximum(np.ceil(lengths), 2).astype(np.int64) * (not line.is_dot)
        row = np.repeat(np.arange(len(curves)), counts)
        step = 1.0 / counts[row] if len(row) else np.zeros(0)
        t = counted(counts) * step
        start, end = (cubic_points(curves[row], each[:, None])[:, 0] for each in (t, t + step))
        gone = np.linalg.norm(end - start, axis=1)
        parts.append((start, end, np.full(len(row), number), row + t, step, np.cumsum(gone) - gone))
    return _Pieces(*(np.concatenate(each) for each in zip(*parts, strict=True)))


def _crossings(lines: list[DrawnLine], pieces: _Pieces) -> list[_Meeting]:
    """Return where lines cross. A line that goes on by very little ends there."""
    middle = (pieces.start + pieces.end) / 2.0
    reach = 1.05 * float(np.linalg.norm(pieces.end - pieces.start, axis=1).max(initial=0.0))
    pairs = cKDTree(middle).query_pairs(reach, output_type="ndarray") if len(middle) else np.zeros((0, 2), np.int64)
    a, b = pairs.T
    is_apart = (pieces.line[a] != pieces.line[b]) | (np.abs(pieces.along[a] - pieces.along[b]) > LINES.loop_min)
    a, b = a[is_apart], b[is_apart]
    u, v = pieces.end[a] - pieces.start[a], pieces.end[b] - pieces.start[b]
    gap = pieces.start[b] - pieces.start[a]
    det = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    is_steep = np.abs(det) > LINES.crossing_sine * np.linalg.norm(u, axis=1) * np.linalg.norm(v, axis=1)
    safe = np.where(is_steep, det, 1.0)
    s = (gap[:, 0] * v[:, 1] - gap[:, 1] * v[:, 0]) / safe
    t = (gap[:, 0] * u[:, 1] - gap[:, 1] * u[:, 0]) / safe
    found = []
    for k in np.flatnonzero(is_steep & (s >= 0.0) & (s <= 1.0) & (t >= 0.0) & (t <= 1.0)).tolist():
        meeting = _Meeting(pieces.start[a[k]] + s[k] * u[k])
        both = ((int(a[k]), float(s[k]), int(b[k])), (int(b[k]), float(t[k]), int(a[k])))
        for piece, share, other in both:
            line = int(pieces.line[piece])
            limit = LINES.overshoot * lines[int(pieces.line[other])].width
            is_start = _ends_within(lines[line], meeting.place, limit)
            if is_start is None:
                meeting.cuts[line] = float(pieces.place[piece] + share * pieces.step[piece])
            else:
                meeting.ends.add((line, is_start))
        found.append(meeting)
    return found


def _ends_within(line: DrawnLine, place: Floats, limit: float) -> bool | None:
    """Return whether the start of an open line is within ``limit`` px of ``place``, or its end; None if neither is."""
    if not line.rows.is_open:
        return None
    away = [float(np.linalg.norm(end - place)) for end in line.ends()]
    return None if min(away) > limit else away[0] <= away[1]


def _end_meetings(
    lines: list[DrawnLine], pieces: _Pieces, ended: set[tuple[int, bool]], attached: set[tuple[int, bool]]
) -> list[_Meeting]:
    """Return where the ends that are not yet ``ended`` lie on other lines, or on other parts of their own."""
    tree = cKDTree((pieces.start + pieces.end) / 2.0) if len(pieces.line) else None
    total = np.bincount(pieces.line, np.linalg.norm(pieces.end - pieces.start, axis=1), len(lines))
    found = []
    for number, line in enumerate(lines):
        if line.is_dot or not line.rows.is_open or tree is None:
            continue
        for is_start, end in zip((True, False), line.ends(), strict=True):
            if (number, is_start) in ended:
                continue
            is_attached = (number, is_start) in attached
            reach = (LINES.attached_reach if is_attached else LINES.node_reach) * line.width
            near = np.array(tree.query_ball_point(end, reach + 1.0), np.int64)
            along = pieces.along[near] if is_start else total[number] - pieces.along[near]
            near = near[(pieces.line[near] != number) | (along > LINES.loop_widths * line.width)]
            meeting = _end_meeting(lines, pieces, near, number, is_start, reach)
            if meeting is not None:
                found.append(meeting)
    return found


def _end_meeting(
    lines: list[DrawnLine], pieces: _Pieces, near: Integers, number: int, is_start: bool, reach: float
) -> _Meeting | None:
    """Return where an end of a line meets one of the pieces ``near`` it; None if none is within ``reach`` px."""
    end = lines[number].ends()[0 if is_start else 1]
    out = _outwards(lines[number], is_start)
    step = pieces.end[near] - pieces.start[near]
    share = ((end - pieces.start[near]) * step).sum(1) / np.maximum((step * step).sum(1), 1e-12)
    share = share.clip(0.0, 1.0)
    places = pieces.start[near] + share[:, None] * step
    away = np.linalg.norm(places - end, axis=1)
    if not len(near) or away.min() > reach:
        return None
    # Straight on, if that leads to the other line; else what is nearest.
    side = np.abs((places - end) @ np.array([-out[1], out[0]]))
    if (is_ahead := (side <= np.maximum(LINES.ahead_px, away * 0.1)) & (away <= reach)).any():
        away = np.where(is_ahead, away, np.inf)
    best = int(np.argmin(away))
    other = int(pieces.line[near[best]])
    meeting = _Meeting(places[best], ends={(number, is_start)})
    other_start = _ends_within(lines[other], places[best], LINES.node_reach * lines[other].width)
    if other_start is None:
        meeting.cuts[other] = float(pieces.place[near[best]] + share[best] * pieces.step[near[best]])
    else:
        meeting.ends.add((other, other_start))
        meeting.place = lines[other].ends()[0 if other_start else 1]
    return meeting


def _outwards(line: DrawnLine, is_start: bool) -> Floats:
    """Return the unit direction [2] in which an end of a line points."""
    curves = curves_of(line.rows)
    points = curves[0] if is_start else curves[-1, ::-1]
    out = next((points[0] - point for point in points[1:] if np.linalg.norm(point - points[0]) > 1e-2), np.zeros(2))
    return out / max(float(np.linalg.norm(out)), 1e-9)


def _merged(lines: list[DrawnLine], meetings: list[_Meeting]) -> list[_Meeting]:
    """Return ``meetings`` with one in place of those that share an end or lie near each other."""
    if not meetings:
        return []
    places = np.array([meeting.place for meeting in meetings])
    least = np.array([min(lines[k].width for k in [*m.cuts, *(line for line, _ in m.ends)]) for m in meetings])
    reach = LINES.same_node * least
    pairs = cKDTree(places).query_pairs(float(reach.max()), output_type="ndarray")
    away = np.linalg.norm(places[pairs[:, 0]] - places[pairs[:, 1]], axis=1)
    links = [tuple(pair) for pair in pairs[away <= np.minimum(reach[pairs[:, 0]], reach[pairs[:, 1]])].tolist()]
    owner: dict[tuple[int, bool], int] = {}
    for k, meeting in enumerate(meetings):
        links += [(owner.setdefault(end, k), k) for end in meeting.ends]
    row, column = np.array(links, np.int64).reshape(-1, 2).T
    size = (len(meetings), len(meetings))
    _, label = connected_components(coo_matrix((np.ones(len(row)), (row, column)), size), directed=False)
    return [_union([meetings[k] for k in np.flatnonzero(label == group)]) for group in np.unique(label)]


def _union(meetings: list[_Meeting]) -> _Meeting:
    """Return one meeting in place of several. Where a line goes through, it is on that line."""
    through = [meeting for meeting in meetings if meeting.cuts] or meetings
    found = _Meeting(np.mean([meeting.place for meeting in through], 0))
    for meeting in meetings:
        found.cuts = {**meeting.cuts, **found.cuts}
        found.ends |= meeting.ends
    return found


def _changed(line: DrawnLine, cuts: list[tuple[float, Floats]], start: Floats | None, end: Floats | None) -> DrawnLine:
    """Return a line with nodes at ``cuts``: places along it, and the places [2] px of their nodes; and other ends."""
    if line.form is not None or (not cuts and start is None and end is None):
        return line
    curves, is_line = curves_of(line.rows), line.rows.is_line
    parts, kinds = [], []
    for k, curve in enumerate(curves):
        own = sorted((place - k, node) for place, node in cuts if k <= place < k + 1)
        rest, before = curve, 0.0
        for t, node in own if own else []:
            share = (t - before) / max(1.0 - before, 1e-9)
            if share < LINES.cut_share or share > 1.0 - LINES.cut_share:
                continue
            first, rest = _split(rest, share)
            first[3] = rest[0] = node
            parts.append(first)
            kinds.append(bool(is_line[k]))
            before = t
        parts.append(rest)
        kinds.append(bool(is_line[k]))
    found = np.array(parts)
    for place, row, side in ((start, 0, 0), (end, -1, 3)):
        if place is not None:
            handle = 1 if side == 0 else 2
            found[row, handle] += place - found[row, side]
            found[row, side] = place
    return replace(line, rows=_rows(found, np.array(kinds), line.rows.is_open))


def _split(curve: Floats, share: float) -> tuple[Floats, Floats]:
    """Return the two parts [4, 2] of a cubic [4, 2]."""
    levels = [curve]
    while len(levels[-1]) > 1:
        levels.append(levels[-1][:-1] * (1.0 - share) + levels[-1][1:] * share)
    return np.array([level[0] for level in levels]), np.array([level[-1] for level in levels[::-1]])


def _rows(curves: Floats, is_line: np.ndarray, is_open: bool) -> Rows:
    control = curves[:, :3].copy()
    ends = curves[:, 3]
    straight = is_line[: len(curves)]
    control[straight, 1] = control[straight, 0] + (ends[straight] - control[straight, 0]) / 3.0
    control[straight, 2] = control[straight, 0] + (ends[straight] - control[straight, 0]) * 2.0 / 3.0
    if not is_open:
        return Rows(control, straight, False)
    return Rows(np.concatenate([control, np.repeat(ends[-1:, None], 3, 1)]), np.append(straight, True), True)
