"""The centre lines of a shape that is a stroke: from its skeleton, as exact as the disks inside its outline."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import sparse
from scipy.sparse import csgraph
from scipy.spatial import cKDTree

from warpvec.arrays import Floats, Mask, reached
from warpvec.flat.constants.strokes import STROKES
from warpvec.flat.simplification.outline_samples import cubic_points
from warpvec.flat.strokes.inner_disks import Boundary, Disks
from warpvec.flat.strokes.joint_choice import Stem, chosen_joint
from warpvec.flat.strokes.joints import Arm, End, Joint, Shape, arms_of, bridge_of, usual_joint
from warpvec.flat.strokes.line_fitting import Line, Rows, curves_of
from warpvec.flat.strokes.skeleton import Graph, graph_of
from warpvec.flat.strokes.thinning import thinned
from warpvec.geometry.strokes import BUTT, MITER, ROUND

_CELLS = 10.0
"""Cells of the grid of a skeleton across a stroke."""

_ARM_PLACES = 2
"""Fewest places of a branch between those next to its ends: two tell its direction."""

_CAP_STEP = 5.0
"""Degrees of a circle that are outline if one point of the outline lies there."""

_SAMPLES = (np.arange(16) + 0.5) / 16
"""Places along curves that tell what they cover."""

_Side = tuple[int, bool]
"""A branch and a side of it: whether its start, or whether it is followed forwards."""

_Ends = tuple[int, int] | None
"""The junctions at both ends of a branch, as in `Graph`."""


class CenterLines(NamedTuple):
    """The lines of a component, their caps, and how many ends show theirs."""

    lines: list[Line]
    cap: int
    cap_count: int


def center_lines(boundary: Boundary, disks: Disks, has_width: Mask, width: float) -> CenterLines | None:
    """Return the centre lines of a component; None if it has none."""
    shape = Shape(boundary, cKDTree(boundary.points), cKDTree(disks.centers[has_width]), width)
    graph, scale, origin = _skeleton(shape)
    ridges = [(branch[:, ::-1] + 0.5) / scale + origin for branch in graph.branches]
    places = [_snapped(shape, ridge, scale) for ridge in ridges]
    ends, junctions = _merged(places, graph.ends, (graph.junctions[:, ::-1] + 0.5) / scale + origin)
    places = [_to_junction(_cleared(own, both), both, junctions) for own, both in zip(places, ends, strict=True)]
    kept = [k for k, both in enumerate(ends) if len(places[k]) > 1 and not _is_spur(shape, places[k], both, junctions)]
    if not kept:
        return None
    stems = [_stem(shape, ridges[k], both, k) for k, both in enumerate(ends) if both is not None]
    return joined(shape, places, [ends[k] for k in kept], kept, junctions, [stem for stem in stems if stem is not None])


def _skeleton(shape: Shape) -> tuple[Graph, float, Floats]:
    """Return the skeleton of the ridge of a shape, the cells of its grid per pixel, and the grid's origin."""
    scale = _CELLS / shape.width
    low, high = shape.boundary.points.min(0), shape.boundary.points.max(0)
    columns, rows = np.ceil((high - low) * scale).astype(int) + 1
    x, y = (np.arange(columns) + 0.5) / scale + low[0], (np.arange(rows) + 0.5) / scale + low[1]
    grid = np.stack(np.meshgrid(x, y), -1).reshape(-1, 2)
    distance, nearest = shape.tree.query(grid)
    away = grid - shape.boundary.points[nearest]
    is_inside = (away * shape.boundary.inward[nearest]).sum(1) > 0.0
    ridge = is_inside & (distance >= shape.width / 2.0 - STROKES.ridge / scale)
    return graph_of(thinned(ridge.reshape(rows, columns))), scale, low


def _snapped(shape: Shape, places: Floats, scale: float) -> Floats:
    """Return the centres nearest to places of a skeleton, without those that have none near and that go back."""
    distance, nearest = shape.centers.query(places)
    found = np.asarray(shape.centers.data)[nearest[distance <= 1.6 / scale]]
    return going_on(found, 0.5 / scale)


def going_on(found: Floats, gap_min: float) -> Floats:
    """Return those of the places [M, 2] px along a line that lie ``gap_min`` apart and do not go back."""
    kept: list[Floats] = []
    for place in found:
        gap = np.linalg.norm(place - kept[-1]) if kept else np.inf
        is_back = len(kept) > 1 and (place - kept[-1]) @ (kept[-1] - kept[-2]) <= 0.0
        if gap >= (4.0 if is_back else 1.0) * gap_min:
            kept.append(place)
    return np.array(kept).reshape(-1, 2)


def _merged(places: list[Floats], ends: list[_Ends], junctions: Floats) -> tuple[list[_Ends], Floats]:
    """Return the ends of branches, and junctions [J, 2], of which those are one between which no line shows.

    Where lines cross at a slant, or end beside each other, a skeleton has two junctions close together.
    """
    hidden = [
        both for own, both in zip(places, ends, strict=True) if both is not None and min(both) >= 0 and len(own) < 2
    ]
    count = len(junctions)
    first, second = np.array(hidden, np.int64).reshape(-1, 2).T
    graph = sparse.coo_matrix((np.ones(len(hidden)), (first, second)), shape=(count, count))
    merged_count, owner = csgraph.connected_components(graph, directed=False)
    merged = np.array([junctions[owner == k].mean(0) for k in range(merged_count)]).reshape(-1, 2)
    number = [*owner.tolist(), -1]  # the last is that of free ends
    return [None if both is None else (number[both[0]], number[both[1]]) for both in ends], merged


def _cleared(places: Floats, ends: tuple[int, int] | None) -> Floats:
    """Return the places [M, 2] of a branch without those next to junctions: there, disks have grown, and moved off."""
    if ends is None or len(places) < _ARM_PLACES + 2:
        return places
    return places[int(ends[0] >= 0) : len(places) - int(ends[1] >= 0)]


def _to_junction(places: Floats, ends: tuple[int, int] | None, junctions: Floats) -> Floats:
    """Return the places [M, 2] of a branch, of which only its cap may show, with its only junction then."""
    if len(places) != 1 or ends is None or (ends[0] < 0) == (ends[1] < 0):
        return places
    junction = junctions[max(ends)][None]
    return np.concatenate([places, junction] if ends[0] < 0 else [junction, places])


def _is_spur(shape: Shape, places: Floats, ends: tuple[int, int] | None, junctions: Floats) -> bool:
    """Return whether a branch ends near its only junction, and without a cap."""
    if ends is None or (ends[0] < 0) == (ends[1] < 0):
        return False
    tip, junction = (places[0], ends[1]) if ends[0] < 0 else (places[-1], ends[0])
    is_short = np.linalg.norm(tip - junctions[junction]) < STROKES.spur * shape.width
    return bool(is_short and _turn_around(shape, tip) < STROKES.cap_degrees)


def _stem(shape: Shape, ridge: Floats, ends: tuple[int, int], branch: int) -> Stem | None:
    """Return the stem that a branch with these places on the ridge [M, 2] is; None if it has no free end."""
    if (ends[0] < 0) == (ends[1] < 0) or len(ridge) < 2:
        return None
    from_junction = ridge if ends[1] < 0 else ridge[::-1]
    out = from_junction[-1] - from_junction[0]
    out /= np.linalg.norm(out)
    tip = from_junction[-1] + max(_room(shape, from_junction[-1], out) - shape.width / 2.0, 0.0) * out
    return Stem(max(ends), branch, _center_of_cap(shape, tip))


def _center_of_cap(shape: Shape, tip: Floats) -> Floats:
    """Return the centre [2] of the most disks near a ``tip``, which those along a cap share; the tip without any."""
    ends = np.asarray(shape.centers.data)[shape.centers.query_ball_point(tip, shape.width / 4.0)]
    if not len(ends):
        return tip
    found: Floats = ends[
        int(np.argmax(shape.centers.query_ball_point(ends, STROKES.cap_error_min, return_length=True)))
    ]
    return found


def _turn_around(shape: Shape, tip: Floats) -> float:
    """Return how many degrees of a circle as wide as the stroke, about the end of a line near a ``tip``, are outline.

    A round cap has half of it, and a little of both sides. A corner has as much as the line turns there.
    """
    radius, tip = shape.width / 2.0, _center_of_cap(shape, tip)
    near = shape.boundary.points[shape.tree.query_ball_point(tip, 1.1 * radius)] - tip
    distance = np.linalg.norm(near, axis=1)
    off = max(STROKES.cap_error * radius, STROKES.cap_error_min)
    around = near[np.abs(distance - radius) <= off]
    return float(len(np.unique(np.floor(np.degrees(np.arctan2(around[:, 1], around[:, 0])) / _CAP_STEP))) * _CAP_STEP)


class _Meeting(NamedTuple):
    """How a line ends at a junction.

    Attributes:
        place: where [2].
        covered: how far ahead of it the other lines cover, in pixels.
        arm: the line before it was led there.
        more: the points by which it was.
    """

    place: Floats
    covered: float
    arm: Arm
    more: int


def joined(
    shape: Shape,
    places: list[Floats],
    ends: list[tuple[int, int] | None],
    kept: list[int],
    junctions: Floats,
    stems: list[Stem] | None = None,
    length_min: float = STROKES.spur,
) -> CenterLines:
    """Join branches to lines through the junctions, and let the other ends meet there.

    Points of lines that go on are added to the ``places`` of their branches.

    Args:
        shape: what the branches lie in.
        places: the centres along each branch [M, 2] px.
        ends: the junctions at the ends of each branch that is kept; as in `Graph`.
        kept: the branches that are lines.
        junctions: [J, 2] px.
        stems: branches with a free end, which a corner of two others may be. None if lines meet in the usual way.
        length_min: least length in widths of a line between others, unless it is the longest.
    """
    partner: dict[_Side, _Side] = {}
    meeting: dict[_Side, _Meeting] = {}
    corners = set[int]()
    for junction, meet in _ends_at(shape, places, ends, kept).items():
        near, arms = junctions[junction], arms_of(shape, places, meet)
        if stems is None:
            found = usual_joint(shape, arms, near)
        else:
            own = {branch: places[branch] for branch in kept if branch not in corners}
            found, corner = chosen_joint(shape, own, arms, junction, junctions, stems)
            corners |= set() if corner is None else {corner}
        _go_on(found, places, partner)
        for end, points in found.singles:
            covered = _covered(shape, end, [other for other in meet if other is not end])
            arm = next(each for each in arms if each.end is end)
            meeting[end.branch, end.is_start] = _Meeting(points[-1], covered, arm, len(points) - 1)
    closed = {branch for branch, both in zip(kept, ends, strict=True) if both is None}
    chains = [([(k, True)], True) for k in closed] + _chains([k for k in kept if k not in closed | corners], partner)
    if stems is not None:
        chains = [(chain, is_ring or _is_closed(shape, places, chain, meeting)) for chain, is_ring in chains]
    lengths = [sum(_length(places[k]) for k, _ in chain) for chain, _ in chains]
    least = min(length_min * shape.width, max(lengths, default=0.0))
    chains = [
        chain for chain, length in zip(chains, lengths, strict=True) if length >= least or _has_cap(chain[0], meeting)
    ]
    are_square = _square_ends(shape, places, chains, meeting)
    cap = BUTT if are_square and np.mean(are_square) > 0.5 else ROUND
    lines = [_line_of(shape, places, chain, is_ring, meeting, cap) for chain, is_ring in chains]
    return CenterLines([line for line in lines if len(line.points) > 1], cap, len(are_square))


def _ends_at(shape: Shape, places: list[Floats], ends: list[_Ends], kept: list[int]) -> dict[int, list[End]]:
    """Return the ends of branches that meet at each junction, by its number; see `joined`."""
    at: dict[int, list[End]] = {}
    for branch, both in zip(kept, ends, strict=True):
        for is_start, junction in zip((True, False), both or (), strict=False):
            if junction >= 0:
                reach = STROKES.reach * shape.along(branch).width
                at.setdefault(junction, []).append(End(branch, is_start, _direction(places[branch], is_start, reach)))
    return at


def _is_closed(shape: Shape, places: list[Floats], chain: list[_Side], meeting: dict[_Side, _Meeting]) -> bool:
    """Return whether a chain that ends at others goes on below them from one end to the other, as a circle may.

    If so, the points between are added to the ``places`` of its last branch, and those that led elsewhere go.
    """
    ends = chain[0], (chain[-1][0], not chain[-1][1])
    if ends[0] == ends[1] or not set(ends) <= meeting.keys():
        return False
    head, tail = (meeting[end] for end in ends)
    between = bridge_of(tail.arm, head.arm)
    if not len(between) or shape.tree.query(between)[0].min() < (1.0 - STROKES.width_error) * shape.width / 2.0:
        return False
    for (branch, is_start), end in zip(ends, (head, tail), strict=True):
        own = places[branch]
        places[branch] = own[end.more :] if is_start else own[: len(own) - end.more]
    branch, is_start = ends[1]
    places[branch] = np.concatenate([between[::-1], places[branch]] if is_start else [places[branch], between])
    return True


def _go_on(joint: Joint, places: list[Floats], partner: dict[_Side, _Side]) -> None:
    """Note the pairs of a ``joint``, and add the points by which branches go on to their ``places``."""
    singles = [(end, points[:-1]) for end, points in joint.singles]
    for end, more in [*((a, between) for a, _, between in joint.pairs), *joint.ended, *singles]:
        own = places[end.branch]
        places[end.branch] = np.concatenate([more[::-1], own] if end.is_start else [own, more])
    for a, b, _ in joint.pairs:
        partner[a.branch, a.is_start] = b.branch, b.is_start
        partner[b.branch, b.is_start] = a.branch, a.is_start


def _has_cap(chain: list[_Side], meeting: dict[_Side, _Meeting]) -> bool:
    """Return whether a chain of branches has an end that meets no other line."""
    return not {chain[0], (chain[-1][0], not chain[-1][1])} <= meeting.keys()


def _length(points: Floats) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def _direction(points: Floats, is_start: bool, reach: float) -> Floats:
    """Return the unit direction in which a line leaves at one of its ends: of a parabola through its last part."""
    ordered = points if is_start else points[::-1]
    along = reached(ordered)
    part = along <= reach
    part[:2] = True
    terms = np.stack([along[part], np.square(along[part])], 1)
    if part.sum() < 5:
        terms = terms[:, :1]
    out: Floats = -np.linalg.lstsq(terms, ordered[part] - ordered[0], rcond=None)[0][0]
    return out / max(float(np.linalg.norm(out)), 1e-9)


def _covered(shape: Shape, end: End, others: list[End]) -> float:
    """Return how far ahead of a junction the other lines cover the straight way on from an ``end``, in pixels."""
    cosine = np.array([-(other.out @ end.out) for other in others])
    sine = np.sqrt(np.maximum(1.0 - np.square(cosine), 1e-6))
    widths = np.array([shape.along(other.branch).width for other in others])
    return float((widths / 2.0 / np.where(cosine > 0.0, sine, 1.0)).max(initial=0.0 if others else shape.width / 2.0))


def _chains(branches: list[int], partner: dict[_Side, _Side]) -> list[tuple[list[_Side], bool]]:
    """Return lists of branches that follow each other, each with whether it runs forwards, and whether it is a ring."""
    left, chains = set(branches), []
    heads = [(k, True) for k in branches if (k, True) not in partner] + [
        (k, False) for k in branches if (k, False) not in partner
    ]
    for branch, forwards in [*heads, *((k, True) for k in branches)]:
        if branch not in left:
            continue
        chain, at = [], (branch, forwards)
        is_ring = (branch, forwards) in partner
        while at[0] in left:
            left.discard(at[0])
            chain.append(at)
            after = partner.get((at[0], not at[1]))
            if after is None:
                break
            at = after
        chains.append((chain, is_ring))
    return chains


def _square_ends(
    shape: Shape,
    places: list[Floats],
    chains: list[tuple[list[_Side], bool]],
    meeting: dict[_Side, _Meeting],
) -> list[bool]:
    """Return for each free end whether the corners of a square lie inside of its cap."""
    found = []
    for chain, is_ring in chains:
        if is_ring:
            continue
        for branch, is_start in (chain[0], (chain[-1][0], not chain[-1][1])):
            if (branch, is_start) not in meeting:
                found.append(_is_square(shape.along(branch), places[branch] if is_start else places[branch][::-1]))
    return found


def _is_square(shape: Shape, points: Floats) -> bool:
    """Return whether the shape has corners beyond the start of a line."""
    out = _direction(points, True, STROKES.reach * shape.width)
    radius, side = shape.width / 2.0, np.array([-out[1], out[0]])
    far = points[0] + (_room(shape, points[0], out) - (1.0 - STROKES.cap_probe) * radius) * out
    corners = np.array([far + STROKES.cap_probe * radius * side, far - STROKES.cap_probe * radius * side])
    return bool(shape.is_inside(corners).all())


def _line_of(
    shape: Shape,
    places: list[Floats],
    chain: list[_Side],
    is_ring: bool,
    meeting: dict[_Side, _Meeting],
    cap: int,
) -> Line:
    points = np.concatenate([places[k] if forwards else places[k][::-1] for k, forwards in chain])
    shape = shape.along(max((k for k, _ in chain), key=lambda k: len(places[k])))
    points = _with_corners(points, shape.width, is_ring)
    if is_ring:
        return Line(points, True)
    head, tail = chain[0], (chain[-1][0], not chain[-1][1])
    first, last = meeting.get(head), meeting.get(tail)
    points = _with_end(shape, points[::-1], last, cap)[::-1]
    return Line(_with_end(shape, points, first, cap), False)


def _with_corners(points: Floats, width: float, is_ring: bool) -> Floats:
    """Return ``points`` with a corner in each gap in which the line turns: there, disks have no centre on the line."""
    count = len(points)
    gaps = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    found = [points]
    for k in np.flatnonzero(gaps > STROKES.corner_gap * width).tolist()[::-1]:
        if k == count - 1 and not is_ring:
            continue
        before = np.roll(points, -(k + 1), axis=0) if is_ring else points[: k + 1]
        after = np.roll(points, -(k + 1), axis=0) if is_ring else points[k + 1 :]
        if min(len(before), len(after)) < 4:
            continue
        corner = _corner(before, after, width)
        if corner is not None:
            found = [np.insert(found[0], k + 1, corner, axis=0)]
    return found[0]


def _corner(before: Floats, after: Floats, width: float) -> Floats | None:
    """Return where the end of one line and the start of the next meet; None if they turn little, or meet far away."""
    reach = STROKES.corner_reach * width
    first, second = _direction(before, False, reach), -_direction(after, True, reach)
    turn = abs(first[0] * second[1] - first[1] * second[0])
    if turn < np.sin(np.radians(STROKES.corner_degrees)):
        return None
    a, b = before[-1], after[0]
    share = np.linalg.solve(np.stack([first, -second], 1), b - a)
    far = STROKES.corner_far * width
    return a + share[0] * first if 0.0 < share[0] < far and -far < share[1] < 0.0 else None


def _with_end(shape: Shape, points: Floats, meeting: _Meeting | None, cap: int) -> Floats:
    """Return ``points`` with their start where the line begins: at a junction, or before its cap."""
    out = _direction(points, True, STROKES.reach * shape.width)
    before_cap = shape.width / 2.0 if cap == ROUND else 0.0
    if meeting is not None:
        near = np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)) < shape.width
        gap = np.linalg.norm(points[: 1 + int(near.sum())] - meeting.place, axis=1)
        rest = points[int(np.argmin(gap)) :] if gap.min() < shape.width / 4.0 else points
        rest = rest if len(rest) > 1 else points[-1:]
        room = _room(shape, meeting.place, out)
        ahead = room - before_cap if room > meeting.covered + STROKES.overhang * shape.width else 0.0
        return np.concatenate([(meeting.place + max(ahead, 0.0) * out)[None], rest])
    ahead = _room(shape, points[0], out) - before_cap
    return np.concatenate([(points[0] + out * ahead)[None], points]) if ahead > STROKES.step / 2.0 else points


def _room(shape: Shape, place: Floats, out: Floats) -> float:
    """Return how far the shape goes on from ``place``, in pixels; at most one and a half widths."""
    steps = np.linspace(0.0, 1.5 * shape.width, 97)
    inside = shape.is_inside(place + steps[:, None] * out)
    return float(steps[int(np.argmin(inside)) if not inside.all() else -1])


def join_of(lines: list[Rows], boundary: Boundary, width: float) -> int:
    """Return the join of a stroke: a miter if the shape reaches to the tips of most of its corners, else round.

    A corner whose tip another line covers shows neither.
    """
    tips = list[Floats]()
    drawn = [cubic_points(curves_of(rows), _SAMPLES).reshape(-1, 2) for rows in lines]
    for k, rows in enumerate(lines):
        others = [points for other, points in enumerate(drawn) if other != k]
        over = cKDTree(np.concatenate(others)) if others else None
        own = _miter_tips(rows, width)
        tips += [tip for tip in own if over is None or over.query(tip)[0] > width / 2.0]
    if not tips:
        return ROUND
    shape = Shape(boundary, cKDTree(boundary.points), cKDTree(boundary.points), width)
    return MITER if shape.is_inside(np.array(tips)).mean() > 0.5 else ROUND


def _miter_tips(rows: Rows, width: float) -> list[Floats]:
    """Return a place [2] half way from a round join to the tip of a miter, at each corner where they lie apart."""
    found = []
    count = len(rows.control) - rows.is_open
    for k in range(1 if rows.is_open else 0, count):
        anchor, arriving = rows.control[k, 0], rows.control[k, 0] - rows.control[k - 1, 2]
        leaving = rows.control[k, 1] - anchor
        first, second = (vector / max(float(np.linalg.norm(vector)), 1e-9) for vector in (arriving, leaving))
        cosine = float(first @ second)
        reach = width / 2.0 / np.sqrt(max((1.0 + cosine) / 2.0, 1e-6))
        if STROKES.miter_min * width <= 2.0 * reach <= STROKES.miter_max * width:
            out = first - second
            length = float(np.linalg.norm(out))
            if length > 0.0:  # a handle of no length has no direction
                found.append(anchor + (reach + width / 2.0) / 2.0 * out / length)
    return found
