"""Let the ends of strokes meet where they lie under each other: nothing shows where a hidden end is."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.sparse import csgraph
from scipy.spatial import cKDTree

from warpvec.arrays import Floats, Integers, cross
from warpvec.flat.chains.chain import Chain
from warpvec.flat.chains.parts import LINE
from warpvec.flat.chains.solve import Sketch

REACH = 0.25
"""Widths up to which ends lie under each other, or beyond the line of another stroke. Farther ones show."""

SHORT = 0.5
"""Widths up to which an end is short of the line of another stroke and does not show: half a width is its edge."""

SHOWN = 0.75
"""Widths from an end at which a centre line shows where it goes: nearer to it, the other stroke covers its edges."""

SHOWN_MAX = 1.0
"""Pixels by which an edge may move where ends meet: fits come nearer. The picture refuses more, and all of the line."""

TURN_MIN = 0.1
"""Least sine between centre lines by which it is told where they meet; others meet halfway."""

STRAIGHT = 1e-3
"""Largest rise of a straight curve over its chord."""

SAME, LYING = 1e-3, 0.2
"""Pixels between places that are one, and from a line on which a place lies: lines follow chains, which may bend."""


def with_met_ends(
    chains: dict[int, Chain], widths: Floats, looks: Integers, forms: dict[int, Chain] | None = None
) -> dict[int, Chain]:
    """Return ``chains`` by their loops, with ends that lie under others moved to where their centre lines meet.

    Args:
        chains: outlines and centre lines.
        widths: that of the stroke of each loop [L], in pixels; 0 for an outline.
        looks: the number of the look of each loop [L]: strokes of one look meet.
        forms: the centre lines of stroked forms by their loops, which stay; others may end on them.
    """
    opened = [loop for loop, chain in chains.items() if not chain.is_closed and widths[loop] > 0.0]
    ends = [(loop, side) for loop in opened for side in (0, 1)]
    if not ends:
        return chains
    tips = np.array([chains[loop].points[-side] for loop, side in ends])
    shown = [_shown(chains[loop], side, SHOWN * widths[loop]) for loop, side in ends]
    places, ways = (np.array(each) for each in zip(*shown, strict=True))
    reach = REACH * widths[[loop for loop, _ in ends]]
    lines = (forms or {}) | chains
    found: dict[tuple[int, int], Floats] = {}
    for group in _groups(tips, reach, looks[[loop for loop, _ in ends]]):
        first, place = group[0], None
        if len({ends[k][0] for k in group.tolist()}) < len(group):
            continue  # a dot, or a line that nearly closes
        alike = {loop: each for loop, each in lines.items() if looks[loop] == looks[ends[first][0]]}
        if len(group) == 1:
            place = _place_on_others(alike, widths, ends[first], tips[first], places[first], ways[first])
        else:
            place = _crossing(places[group], ways[group], tips[group].mean(0))
        if place is None or (np.linalg.norm(tips[group] - place, axis=1) > SHORT / REACH * reach[group]).any():
            continue
        new = {ends[k][0]: _with_end(chains[ends[k][0]], ends[k][1], place) for k in group}
        if not _shows(alike, alike | new, np.append(tips[group], place[None], axis=0), widths[ends[first][0]] / 2.0):
            found |= {ends[k]: place for k in group}
    moved = dict(chains)
    for (loop, side), place in found.items():
        moved[loop] = _with_end(moved[loop], side, place)
    return moved


def _shows(old: dict[int, Chain], new: dict[int, Chain], places: Floats, half: float) -> bool:
    """Return whether ``new`` centre lines draw another edge than ``old`` ones at the caps at ``places`` [K, 2]."""
    angle = np.arange(0.0, 2.0 * np.pi, np.pi / 12.0)
    around = (places[:, None] + half * np.stack([np.cos(angle), np.sin(angle)], 1)).reshape(-1, 2)
    trees = [cKDTree(np.concatenate([chain.dense for chain in each.values()])) for each in (old, new)]
    before, after = (np.maximum(tree.query(around)[0], half) for tree in trees)
    return bool(np.abs(after - before).max() > SHOWN_MAX)


def _shown(chain: Chain, side: int, back: float) -> tuple[Floats, Floats]:
    """Return a place [2] on an open chain at most ``back`` pixels from an end, and its direction there [2]."""
    length = chain.reached[-1]
    at = min(back, length / 2.0) if side == 0 else max(length - back, length / 2.0)
    k = int(np.argmin(np.abs(chain.reached - at)))
    return chain.points[k], chain.along[k]


def _groups(tips: Floats, reach: Floats, looks: Integers) -> list[Integers]:
    """Return the ends [K] of one look in groups that lie under each other."""
    is_near = np.linalg.norm(tips[:, None] - tips, axis=2) <= np.minimum(reach[:, None], reach)
    is_near &= looks[:, None] == looks
    count, labels = csgraph.connected_components(is_near, directed=False)
    return [np.flatnonzero(labels == k) for k in range(count)]


def _crossing(places: Floats, ways: Floats, middle: Floats) -> Floats:
    """Return where lines through ``places`` [K, 2] in directions ``ways`` cross; ``middle`` where they do not say."""
    normal = np.stack([-ways[:, 1], ways[:, 0]], 1)
    values, vectors = np.linalg.eigh(normal.T @ normal)
    step = vectors.T @ (normal.T @ ((places - middle) * normal).sum(1))
    step = np.where(values > TURN_MIN**2, step / np.maximum(values, 1e-12), 0.0)
    found: Floats = middle + vectors @ step
    return found


def _place_on_others(
    chains: dict[int, Chain], widths: Floats, end: tuple[int, int], tip: Floats, place: Floats, way: Floats
) -> Floats | None:
    """Return where the line through a ``place`` near an ``end`` meets another stroke that covers its ``tip``."""
    own, outward, found = widths[end[0]], way if end[1] else -way, list[tuple[float, Floats]]()
    for loop, chain in chains.items():
        away = np.linalg.norm(chain.dense - tip, axis=1)
        k = int(np.argmin(away))
        if loop == end[0] or away[k] > SHORT * own + 1.0:
            continue
        corners = chain.points[chain.is_corner]
        corners = corners[np.abs(cross(way, corners - place)) <= REACH * own]  # the line goes there
        gaps = np.linalg.norm(corners - tip, axis=1)
        if gaps.min(initial=np.inf) <= SHORT * own:
            found.append((float(gaps.min()), corners[int(np.argmin(gaps))]))
            continue
        along = chain.dense[min(k + 1, len(chain.dense) - 1)] - chain.dense[max(k - 1, 0)]
        turn = cross(way, along)
        if abs(turn) > TURN_MIN * np.linalg.norm(along):
            crossing = place + way * cross(chain.dense[k] - place, along) / turn
            if (tip - crossing) @ outward <= REACH * own:
                found.append((float(away[k]), crossing))
    return min(found, key=lambda each: each[0])[1] if found else None


def _with_end(chain: Chain, side: int, place: Floats) -> Chain:
    """Return an open ``chain`` with its start or end at a ``place``; a straight curve stays straight."""
    curves = chain.curves.copy()
    curve = curves[-side]
    own = 3 if side else 0
    chord = curve[3] - curve[0]
    is_straight = np.abs(cross(curve[1:3] - curve[0], chord)).max() <= STRAIGHT * np.square(chord).sum()
    curve[2 if side else 1] += place - curve[own]
    curve[own] = place
    if is_straight:
        curve[1:3] = curve[0] + (curve[3] - curve[0]) * np.array([[1.0], [2.0]]) / 3.0
    return chain.of_curves(curves, is_closed=False)


def join_ends(sketch: Sketch) -> None:
    """Let the open ends of ``sketch`` that lie on others stay there."""
    owner, columns = _sharp_nodes(sketch)
    for number, side, own in _open_ends(sketch):
        place = sketch.numbers[own]
        away = np.linalg.norm(sketch.numbers[columns] - place, axis=1)
        away[owner == number] = np.inf
        lines = sketch.rows_of_kind(LINE)
        lines = lines[sketch.chain[lines] != number]
        gaps = np.array([_distance(place, sketch.of(part)) for part in lines.tolist()])
        if away.min(initial=np.inf) <= SAME:
            near = columns[int(np.argmin(away))]
            sketch.equal += [[int(a), int(b)] for a, b in zip(own, near, strict=True)]
            sketch.joined.add((number, side))
        elif gaps.min(initial=np.inf) <= LYING:
            sketch.lying.append((own, int(lines[int(np.argmin(gaps))])))
            sketch.joined.add((number, side))


def _open_ends(sketch: Sketch) -> Iterator[tuple[int, int, Integers]]:
    """Yield the ends of open chains: the number of the chain, 0 or 1 for its start or end, and the columns [2]."""
    for number, (begin, end) in enumerate(sketch.ranges):
        for side, part in ((0, begin), (1, end - 1)):
            if not sketch.chains[number].is_closed and (number, side) not in sketch.at_axis:
                yield number, side, sketch.columns[part][2 * side : 2 * side + 2]


def _sharp_nodes(sketch: Sketch) -> tuple[Integers, Integers]:
    """Return the chains [K] and columns [K, 2] of the starts and ends of parts that no smooth joint has."""
    smooth = {(int(part), side) for pair in sketch.smooth for part, side in zip(pair, (1, 0), strict=True)}
    found = [
        (sketch.chain[part], sketch.columns[part][2 * side : 2 * side + 2])
        for part in range(len(sketch.kind))
        for side in (0, 1)
        if (part, side) not in smooth
    ]
    columns = np.array([own for _, own in found], np.int64).reshape(-1, 2)
    return np.array([owner for owner, _ in found], np.int64), columns


def _distance(place: Floats, line: Floats) -> float:
    """Return how far a ``place`` [2] is from a ``line`` [4] between its ends."""
    start, way = line[:2], line[2:] - line[:2]
    share = np.clip(((place - start) @ way) / max(float(way @ way), 1e-12), 0.0, 1.0)
    return float(np.linalg.norm(start + share * way - place))
