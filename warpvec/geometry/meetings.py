"""Find the curves of a path that cross or touch each other, exactly: `crossings.py` counts only what can be seen.

Pairs of curves are halved until their boxes part or both are straight, as in T. W. Sederberg, "Computer Aided Geometric
Design" (2012), chapter 7.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warpvec.arrays import Floats, Integers, Mask, counted
from warpvec.geometry.bezier import whole_curves
from warpvec.geometry.scene import Scene

FLAT = 0.0005
"""Largest distance in pixels of a curve from its chord that counts as straight: half of what outlines may be off."""

FIRST_PARTS = 4
"""Parts of a curve that are compared first: their boxes overlap far less often than those of whole curves."""

TURN_WIDTH = 0.001
"""Two neighbours that part by no more than so many pixels over ten times that turn back along each other: rounding
decides whether they cross."""

_HALVINGS = 24
"""Most rounds of halving. A curve as long as a picture is straight after ten; a cusp takes more."""


class _Parts(NamedTuple):
    """Parts of curves.

    Attributes:
        control: control points [P, 4, 2].
        row: the curve of each [P].
        start, end: its nodes [P]: the row plus the parameter, the same number for the end of a curve and the next one.
        loop: [P].
    """

    control: Floats
    row: Integers
    start: Floats
    end: Floats
    loop: Integers

    def select(self, rows: Integers) -> _Parts:
        """Return the parts ``rows``."""
        return _Parts(self.control[rows], self.row[rows], self.start[rows], self.end[rows], self.loop[rows])

    def flat(self) -> Mask:
        """Return which parts are as good as straight [P]."""
        bend = np.abs(self.control[:, :-2] - 2.0 * self.control[:, 1:-1] + self.control[:, 2:]).max((1, 2))
        return bend <= FLAT

    def halves(self) -> tuple[_Parts, _Parts]:
        """Return the first and the second halves."""
        a, b, c, d = np.moveaxis(self.control, 1, 0)
        ab, bc, cd = (a + b) / 2.0, (b + c) / 2.0, (c + d) / 2.0
        abc, bcd = (ab + bc) / 2.0, (bc + cd) / 2.0
        middle = (abc + bcd) / 2.0
        # The last part of a curve ends at the node of another row.
        place = (self.start + np.where(self.end > self.start, np.minimum(self.end, self.row + 1.0), self.row + 1.0)) / 2
        first = self._replace(control=np.stack([a, ab, abc, middle], 1), end=place)
        return first, self._replace(control=np.stack([middle, bcd, cd, d], 1), start=place)


def meeting_rows(scene: Scene) -> Mask:
    """Return which curves [R] of fills cross another one of their path, or touch one of their own loop, or themselves.

    Neighbours have their node in common, which is no meeting, unless one turns back along the other. Loops may touch
    each other at nodes of both.
    """
    found = np.zeros(len(scene.segments), bool)
    parts, path = _first_parts(scene)
    one, two = _overlapping(parts, path)
    a, b = parts.select(one), parts.select(two)
    for _ in range(_HALVINGS):
        kept = _may_meet(a, b)
        a, b = a.select(kept), b.select(kept)
        flat_a, flat_b = a.flat(), b.flat()
        ends = flat_a & flat_b & (a.start != b.start)
        meets = np.flatnonzero(ends)
        meets = meets[_chords_meet(a.select(meets), b.select(meets))]
        found[a.row[meets]] = found[b.row[meets]] = True
        # A row that is found needs no second look.
        left = ~ends & ~(flat_a & flat_b) & ~(found[a.row] & found[b.row])
        if not left.any():
            break
        a, b = _halved(a.select(np.flatnonzero(left)), b.select(np.flatnonzero(left)))
    return found


def _first_parts(scene: Scene) -> tuple[_Parts, Integers]:
    """Return the first parts of all fills, and the path of each."""
    structure = scene.structure
    control = whole_curves(scene).double().cpu().numpy()
    path = structure.segment_path.cpu().numpy().astype(np.int64)
    first = structure.loop_first_segment.cpu().numpy().astype(np.int64)
    loop = np.repeat(np.arange(len(first) - 1), np.diff(first))
    is_line = structure.lines.cpu().numpy()
    is_fill = np.ones(len(path), bool)
    if scene.strokes is not None:
        is_fill &= ~scene.strokes.is_stroked.cpu().numpy()[path]
    if scene.forms is not None:
        is_fill &= ~scene.forms.is_form.cpu().numpy()[path]
    rows = np.flatnonzero(is_fill)
    counts = np.where(is_line[rows], 1, FIRST_PARTS)
    row, number = np.repeat(rows, counts), counted(counts)
    share = 1.0 / np.repeat(counts, counts)
    control = _between(control[row], number * share, (number + 1) * share)
    following = structure.segment_next.cpu().numpy()
    is_last = number == np.repeat(counts, counts) - 1
    start, end = row + number * share, np.where(is_last, following[row], row + (number + 1) * share)
    return _Parts(control, row, start, end, loop[row]), path[row]


def _between(cubics: Floats, first: Floats, last: Floats) -> Floats:
    """Return the control points [P, 4, 2] of the parts of ``cubics`` from parameters ``first`` to ``last`` [P]."""

    def blossom(*parameters: Floats) -> Floats:
        points = cubics
        for u in parameters:
            points = points[:, :-1] + u[:, None, None] * (points[:, 1:] - points[:, :-1])
        return points[:, 0]

    inner = np.stack([blossom(*[first] * (3 - k), *[last] * k) for k in range(4)], 1)
    # The ends of curves stay to the last bit: neighbours have them in common.
    inner[first == 0.0, 0], inner[last == 1.0, 3] = cubics[first == 0.0, 0], cubics[last == 1.0, 3]
    return inner


def _overlapping(parts: _Parts, path: Integers) -> tuple[Integers, Integers]:
    """Return the pairs of parts of one path whose boxes overlap, each part with itself included."""
    if not len(path):
        return np.zeros(0, np.int64), np.zeros(0, np.int64)
    low, high = parts.control.min(1), parts.control.max(1)
    # Paths stand side by side, too far apart to reach each other.
    offset = path * (2.0 * np.ptp(parts.control[..., 0]) + 1.0)
    left, right = low[:, 0] + offset, high[:, 0] + offset
    order = np.argsort(left, kind="stable")
    last = np.searchsorted(left[order], right[order], side="right")
    counts = last - np.arange(len(order))
    ones, twos = [], []
    for rows in np.array_split(np.arange(len(order)), 1 + int(counts.sum()) // 2**20):
        index = np.repeat(rows, counts[rows])
        one, two = order[index], order[index + counted(counts[rows])]
        overlaps = (low[one, 1] <= high[two, 1]) & (low[two, 1] <= high[one, 1])
        ones.append(one[overlaps])
        twos.append(two[overlaps])
    return np.concatenate(ones), np.concatenate(twos)


def _may_meet(a: _Parts, b: _Parts) -> Integers:
    """Return the pairs whose parts may meet elsewhere than at a common node."""
    apart = (a.control.min(1) > b.control.max(1)).any(1) | (b.control.min(1) > a.control.max(1)).any(1)
    rows = np.flatnonzero(~apart)
    a, b = a.select(rows), b.select(rows)
    steps = np.concatenate([np.diff(a.control, axis=1), np.diff(b.control, axis=1)], 1)
    along = steps.sum(1)
    # What always goes forward along one direction does not come back.
    forward = (np.einsum("pki,pi->pk", steps, along) >= 0.0).all(1) & along.any(1)
    follows = (a.end == b.start) ^ (b.end == a.start)
    return rows[~(forward & (follows | (a.start == b.start)))]


def _halved(a: _Parts, b: _Parts) -> tuple[_Parts, _Parts]:
    """Return the pairs of halves of pairs of parts; straight ones stay whole, and one with itself makes three pairs."""
    same, flat_a, flat_b = a.start == b.start, a.flat(), b.flat()
    pairs = []
    for first_halves, second_halves, rows in (
        (True, True, np.flatnonzero(~same & ~flat_a & ~flat_b)),
        (True, False, np.flatnonzero(~same & ~flat_a & flat_b)),
        (False, True, np.flatnonzero(~same & flat_a & ~flat_b)),
    ):
        firsts = a.select(rows).halves() if first_halves else (a.select(rows),)
        seconds = b.select(rows).halves() if second_halves else (b.select(rows),)
        pairs += [(one, two) for one in firsts for two in seconds]
    one, two = a.select(np.flatnonzero(same & ~flat_a)).halves()
    pairs += [(one, one), (two, two), (one, two)]
    first, second = zip(*pairs, strict=True)
    return _joined(first), _joined(second)


def _joined(parts: tuple[_Parts, ...]) -> _Parts:
    control, row, start, end, loop = zip(*parts, strict=True)
    return _Parts(*map(np.concatenate, (control, row, start, end, loop)))


def _chords_meet(a: _Parts, b: _Parts) -> Mask:
    """Return which pairs of straight parts meet [n]."""
    p, q, r, s = a.control[:, 0], a.control[:, 3], b.control[:, 0], b.control[:, 3]
    sides = np.stack([_side(p, q, r), _side(p, q, s), _side(r, s, p), _side(r, s, q)])
    crosses = (sides[0] * sides[1] < 0) & (sides[2] * sides[3] < 0)
    reaches = (sides[0] * sides[1] <= 0) & (sides[2] * sides[3] <= 0) & _boxes_touch(p, q, r, s)
    is_along = (sides == 0).all(0)
    follows = (a.end == b.start) | (b.end == a.start)
    # Ends lie on each other where loops touch at nodes.
    at_nodes = (p == r).all(1) | (p == s).all(1) | (q == r).all(1) | (q == s).all(1)
    touches = reaches & ~is_along & np.where(a.loop == b.loop, ~follows, ~at_nodes)
    turns = np.where(a.end == b.start, _turns_back(q, p, s), (b.end == a.start) & _turns_back(p, q, r))
    return crosses | touches | turns | (is_along & reaches & _overlap(p, q, r, s))


def _turns_back(node: Floats, one: Floats, two: Floats) -> Mask:
    """Return which lines from a ``node`` to ``one`` and to ``two`` lie on each other, as far as one can tell."""
    u, v = one - node, two - node
    lengths = np.hypot(*u.T), np.hypot(*v.T)
    sine = np.abs(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]) / np.maximum(np.maximum(*lengths), 1e-12)
    found: Mask = ((u * v).sum(1) > 0.0) & (sine <= TURN_WIDTH) & (np.minimum(*lengths) >= 10.0 * TURN_WIDTH)
    return found


def _boxes_touch(p: Floats, q: Floats, r: Floats, s: Floats) -> Mask:
    low, high = np.maximum(np.minimum(p, q), np.minimum(r, s)), np.minimum(np.maximum(p, q), np.maximum(r, s))
    return np.asarray((low <= high).all(1))


def _overlap(p: Floats, q: Floats, r: Floats, s: Floats) -> Mask:
    """Return which lines from p to q and from r to s, all on one line, have more than a point in common."""
    low, high = np.maximum(np.minimum(p, q), np.minimum(r, s)), np.minimum(np.maximum(p, q), np.maximum(r, s))
    return np.asarray((low < high).any(1))


def _side(a: Floats, b: Floats, point: Floats) -> Floats:
    """Return on which side of the line from ``a`` to ``b`` each ``point`` lies: the sign of a cross product."""
    u, v = b - a, point - a
    found: Floats = np.sign(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0])
    return found
