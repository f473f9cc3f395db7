"""Choose how lines meet at a junction by what that draws, where the usual way does not draw the shape."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from warpvec.arrays import Floats, counted, cross, reached
from warpvec.flat.chains.parts import turned
from warpvec.flat.constants.lines import LINES
from warpvec.flat.constants.strokes import STROKES
from warpvec.flat.simplification.outline_samples import cubic_points
from warpvec.flat.strokes.joints import (
    Arm,
    End,
    Joint,
    Shape,
    arm_along,
    bridge_of,
    fitting_pairs,
    joint_of,
    misfit_of,
    usual_joint,
)

CELLS = 16.0
"""Cells across a stroke by which drawn lines are compared with their shape."""

WRONG_MAX = 0.02
"""Largest area, in squares of the width, in which the usual way differs from the shape where no other is looked at."""

WRONG_ODD = 0.012
"""Such an area that is as bad as a line that ends. Right ways of lucide are off by 0.003 where lines meet and by 0.01
where arcs do, and differ by 0.005 from ways that draw the same."""

ODD = math.radians(LINES.misfit_degrees)
"""A corner, and a line that ends, are as odd as a line that bends by so many radians: lines that bend more are two."""

PART = 0.4
"""Length in widths of the part of a line next to its end, as few places as tell a direction."""

TURN_SHARE = 0.1
"""Share of its turn by which a corner is odder: of equal ones that is meant which turns least, as in an arrowhead."""

BENT_PLACES = 5
"""Fewest places along an arm that tell how it bends."""

TURNS = (-1.0, -0.5, 0.5, 1.0)
"""Where lines end that turn aside before they cross another, in shares of their distance from the crossing."""

ROUND = (0.5, 0.75, 1.0)
"""How much of a corner may be round, in shares of the distance from it to the next end of a line."""

STEP_SHARE = 0.05
"""Distance in widths of points along a line, by which what it draws is known."""


class Stem(NamedTuple):
    """A branch with a free end. A narrow corner of two lines makes one too.

    Attributes:
        junction: where it begins.
        branch: its number.
        tip: the centre of its cap [2] px.
    """

    junction: int
    branch: int
    tip: Floats


class _Way(NamedTuple):
    """A way to join lines.

    Attributes:
        joint: how they are joined.
        oddness: by how many radians lines bend for it, and `ODD` for each corner and each line that ends.
        corner: the stem that is no line then; None for none.
    """

    joint: Joint
    oddness: float
    corner: int | None


def chosen_joint(
    shape: Shape, lines: dict[int, Floats], arms: list[Arm], junction: int, junctions: Floats, stems: list[Stem]
) -> tuple[Joint, int | None]:
    """Return how ``arms`` meet at a ``junction``, and the branch that is a corner or an end of others; None for none.

    That is the usual way if it draws the shape, unless several lines end there. Else it is the way that draws the shape
    best, and of equal ones the way in which lines turn and end least.

    Args:
        shape: what they lie in.
        lines: the places along each branch that is a line [M, 2] px.
        arms: the ends of branches at the junction.
        junction: its number.
        junctions: the places of all [J, 2] px.
        stems: branches with a free end.
    """
    near, far = junctions[junction], STROKES.corner_far * shape.width
    arms = [_even(arm) for arm in arms]
    stems = [each for each in stems if each.junction == junction and np.linalg.norm(each.tip - near) <= far]
    usual = _way(usual_joint(shape, arms, near), arms, STEP_SHARE * shape.width)
    if any(np.linalg.norm(arm.tip - near) > far for arm in arms):
        return usual.joint, None
    drawing = _Drawing.of(shape, lines, arms, junction, junctions, stems)
    is_plain = len(usual.joint.singles) < 2
    if is_plain and drawing.wrong(usual) <= WRONG_MAX:
        return usual.joint, None
    ways = [usual]
    for own in (arms, [_straight(arm) for arm in arms], [_straight(_part(arm, shape.width)) for arm in arms]):
        ways += _ways(shape, own, near, stems)
    best = min(ways, key=lambda way: way.oddness / ODD + drawing.wrong(way) / WRONG_ODD)
    return best.joint, best.corner


def _part(arm: Arm, width: float) -> Arm:
    """Return the part of an arm next to its end: a bend of a designer's is an arc between lines."""
    count = int(np.searchsorted(reached(arm.points), PART * width))
    return arm._replace(points=arm.points[: max(2, count)])


def _even(arm: Arm) -> Arm:
    """Return the part of an arm next to its end that bends evenly: not a short line with the arc behind it."""
    found = arm
    for count in range(len(arm.points), BENT_PLACES - 1, -1):
        found, off = arm_along(arm.end, arm.points[:count])
        if off <= STROKES.center_error_min:
            break
    return found


def _straight(arm: Arm) -> Arm:
    """Return an arm that goes straight on: where lines meet, the centres of disks move off them."""
    chord = arm.points[0] - arm.points[-1]
    return arm._replace(out=chord / max(float(np.linalg.norm(chord)), 1e-9), bend=0.0)


def _ways(shape: Shape, arms: list[Arm], near: Floats, stems: list[Stem]) -> Iterator[_Way]:
    """Yield ways in which one arm ends where a stem does, or two go on by an arc or in a corner.

    The other arms end where they cross the two, or turn into them where the two go on by an arc.
    """
    step = STEP_SHARE * shape.width
    for stem in stems:
        others = [arm for arm in arms if arm.end.branch != stem.branch]
        for arm in others:
            ended = [(arm, np.concatenate([_toward(arm, stem.tip, step), stem.tip[None]]))]
            rest = _bridged([other for other in others if other is not arm])
            odd = ODD / 2.0 + _bend(arm, stem.tip)  # a corner there has no end of a line at all
            yield _way(joint_of(shape, others, rest, near, ended), others, step, odd, stem.branch)
        for a, b in combinations(others, 2):
            yield _in_corner(shape, others, (a, b), stem.tip, near, stem.branch)
    for a, b in combinations(arms, 2):
        rest = _bridged([arm for arm in arms if arm is not a and arm is not b])
        joint = joint_of(shape, arms, [(a, b, bridge_of(a, b)), *rest], near)
        yield _way(joint, arms, step, misfit_of(a, b))
        if joint.singles:
            yield from (_way(_turning_in(joint, arms, share), arms, step, misfit_of(a, b)) for share in TURNS)
        place = _crossing(a, b, STROKES.corner_far * shape.width)
        if place is not None:
            yield _in_corner(shape, arms, (a, b), place, near)
            yield from (_in_round_corner(shape, arms, (a, b), place, near, share) for share in ROUND)


def _bridged(arms: list[Arm]) -> list[tuple[Arm, Arm, Floats]]:
    """Return the pairs of ``arms`` that go on into each other, with the points between them [M, 2] px."""
    return [(a, b, bridge_of(a, b)) for a, b in fitting_pairs(arms)]


def _turning_in(joint: Joint, arms: list[Arm], share: float) -> Joint:
    """Return a ``joint`` of ``arms``, where single ones turn by arcs into the line of the first pair, not across it."""
    own = {(arm.end.branch, arm.end.is_start): arm for arm in arms}
    a, b, bridge = joint.pairs[0]
    line = np.concatenate([own[a.branch, a.is_start].points[::-1], bridge, own[b.branch, b.is_start].points])
    singles = [
        (end, _landing(own[end.branch, end.is_start], points[-1], line, share)[None]) for end, points in joint.singles
    ]
    return joint._replace(singles=singles)


def _landing(arm: Arm, crossing: Floats, line: Floats, share: float) -> Floats:
    """Return where an ``arm`` ends that turns to one side before it crosses a ``line`` [M, 2] at ``crossing`` [2].

    With a ``share`` of 1 the arc touches the line, at the distance from the crossing that the arm has. Other shares of
    this distance lie along the line too, negative ones where the arc turns back.
    """
    k = int(np.argmin(np.linalg.norm(line - crossing, axis=1)))
    along = line[min(k + 1, len(line) - 1)] - line[max(k - 1, 0)]
    ahead = line[k:] if (along @ arm.out >= 0.0) == (share > 0.0) else line[k::-1]
    far = abs(share) * float(np.linalg.norm(crossing - arm.tip))
    found: Floats = ahead[np.searchsorted(reached(ahead)[:-1], far)]
    return found


def _in_corner(
    shape: Shape, arms: list[Arm], pair: tuple[Arm, Arm], place: Floats, near: Floats, stem: int | None = None
) -> _Way:
    """Return the way in which a ``pair`` of arms has a corner at a ``place`` [2], which a ``stem`` may have."""
    (a, b), step = pair, STEP_SHARE * shape.width
    between = np.concatenate([_toward(a, place, step), place[None], _toward(b, place, step)[::-1]])
    odd = ODD + TURN_SHARE * _turn(a, b) + _bend(a, place) + _bend(b, place)
    return _way(joint_of(shape, arms, [(a, b, between)], near), arms, step, odd, stem)


def _in_round_corner(
    shape: Shape, arms: list[Arm], pair: tuple[Arm, Arm], place: Floats, near: Floats, share: float
) -> _Way:
    """Return the way in which a ``pair`` of arms goes on by an arc that takes a ``share`` of a corner at ``place``."""
    (a, b), step = pair, STEP_SHARE * shape.width
    length = share * min(float(np.linalg.norm(place - arm.tip)) for arm in pair)
    arc = _toward(a._replace(points=(place - length * a.out)[None]), place - length * b.out, step)
    between = np.concatenate([(place - length * a.out)[None], arc, (place - length * b.out)[None]])
    return _way(joint_of(shape, arms, [(a, b, between)], near), arms, step, ODD + TURN_SHARE * _turn(a, b))


def _way(joint: Joint, arms: list[Arm], step: float, odd: float = 0.0, corner: int | None = None) -> _Way:
    """Return the way of a ``joint`` of ``arms``, in which the lines that end go on in arcs to where they do.

    ``odd`` is how odd the other lines are, in radians.
    """
    own = {(arm.end.branch, arm.end.is_start): arm for arm in arms}
    led = [(own[end.branch, end.is_start], points) for end, points in joint.singles]
    singles = [(arm.end, np.concatenate([_toward(arm, points[-1], step), points])) for arm, points in led]
    odd += sum(ODD + _bend(arm, points[-1]) for arm, points in led)
    return _Way(joint._replace(singles=singles), odd, corner)


def _turn(a: Arm, b: Arm) -> float:
    """Return by how many radians a line turns that goes on from one arm into another."""
    return abs(math.atan2(float(cross(b.out, a.out)), -float(a.out @ b.out)))


def _bend(arm: Arm, place: Floats) -> float:
    """Return by how many radians the way to a ``place`` [2] turns from that of an arm."""
    chord = place - arm.tip
    return abs(math.atan2(float(cross(arm.out, chord)), float(arm.out @ chord))) if chord.any() else 0.0


def _crossing(a: Arm, b: Arm, far: float) -> Floats | None:
    """Return where two lines meet as they go straight on; None if that is behind or ``far`` from their ends."""
    sine = float(cross(a.out, b.out))
    if abs(sine) < STROKES.crossing_min:
        return None
    gap = b.tip - a.tip
    first, second = float(cross(gap, b.out)) / sine, float(cross(gap, a.out)) / sine
    return a.tip + first * a.out if 0.0 < first < far and 0.0 < second < far else None


def _toward(arm: Arm, place: Floats, step: float) -> Floats:
    """Return points [M, 2] px from the end of an arm to a ``place`` [2]: of an arc that goes on as the arm does."""
    chord = place - arm.tip
    length = float(np.linalg.norm(chord))
    half = float(np.arctan2(cross(arm.out, chord), arm.out @ chord))
    count = int(length / step)
    if count < 2:
        return np.zeros((0, 2))
    half = half if abs(half) < np.pi / 4.0 else 0.0
    handle = 2.0 / 3.0 / (1.0 + np.cos(half))
    first, last = turned(np.stack([chord, chord]), np.array([-half, half]))
    control = np.array([arm.tip, arm.tip + handle * first, place - handle * last, place])
    return cubic_points(control[None], np.arange(1, count) / count)[0]


class _Drawing(NamedTuple):
    """What is drawn around a junction, whichever way its lines go on.

    Attributes:
        cells: the centres of cells there [K, 2] px.
        covered: the share of each that lies inside the shape [K].
        distance: from the lines but for the stems [K].
        stems: points along each stem, by its branch.
        tips: the ends of the arms.
        width: that of the stroke.
    """

    cells: Floats
    covered: Floats
    distance: Floats
    stems: dict[int, Floats]
    tips: dict[tuple[int, bool], Floats]
    width: float

    @staticmethod
    def of(
        shape: Shape, lines: dict[int, Floats], arms: list[Arm], junction: int, junctions: Floats, stems: list[Stem]
    ) -> _Drawing:
        """Return what is drawn there. Cells that are nearer to other junctions tell nothing: these may change yet."""
        step, near = STEP_SHARE * shape.width, junctions[junction]
        tips = {(arm.end.branch, arm.end.is_start): arm.tip for arm in arms}
        away = [float(np.linalg.norm(tip - near)) for tip in [*tips.values(), *(stem.tip for stem in stems)]]
        reach = max(away, default=0.0) + shape.width
        along = np.arange(-reach, reach, shape.width / CELLS)
        cells = near + np.stack(np.meshgrid(along, along), -1).reshape(-1, 2)
        cells = cells[cKDTree(junctions).query(cells)[1] == junction]
        around = (reach + shape.width) * math.sqrt(2.0)
        drawn = {
            branch: _dense(points, step)
            for branch, points in lines.items()
            if np.linalg.norm(points - near, axis=1).min() <= around
        }
        own = {stem.branch: _to_tip(drawn[stem.branch], stem.tip, step) for stem in stems if stem.branch in drawn}
        rest = [points for branch, points in drawn.items() if branch not in own]
        distance = cKDTree(np.concatenate(rest)).query(cells)[0] if rest else np.full(len(cells), np.inf)
        covered = _share_inside(shape.depth(cells), shape.width)
        return _Drawing(cells, covered, distance, own, tips, shape.width)

    def wrong(self, way: _Way) -> float:
        """Return the area, in squares of the width, in which what the lines draw differs from the shape."""
        joint = way.joint
        more = [points for branch, points in self.stems.items() if branch != way.corner]
        more += [self._from(a, np.concatenate([points, self._tip(b)])) for a, b, points in joint.pairs]
        more += [self._from(end, points) for end, points in [*joint.singles, *joint.ended]]
        distance = self.distance
        if more:
            distance = np.minimum(distance, cKDTree(np.concatenate(more)).query(self.cells)[0])
        return float(np.abs(_share_inside(self.width / 2.0 - distance, self.width) - self.covered).sum()) / CELLS**2

    def _tip(self, end: End) -> Floats:
        return self.tips[end.branch, end.is_start][None]

    def _from(self, end: End, points: Floats) -> Floats:
        return _dense(np.concatenate([self._tip(end), points]), STEP_SHARE * self.width)


def _share_inside(depth: Floats, width: float) -> Floats:
    """Return the share of each cell that lies inside an edge, by the ``depth`` of its centre below it [K] in pixels."""
    return np.clip(depth * CELLS / width + 0.5, 0.0, 1.0)


def _to_tip(points: Floats, tip: Floats, step: float) -> Floats:
    """Return ``points`` [M, 2] along a stem, and those on to its ``tip`` [2]."""
    nearest = points[int(np.argmin(np.linalg.norm(points - tip, axis=1)))]
    return np.concatenate([points, _dense(np.stack([nearest, tip]), step)])


def _dense(points: Floats, step: float) -> Floats:
    """Return ``points`` [M, 2] with more between them, at most ``step`` pixels apart."""
    gaps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    counts = np.maximum(np.ceil(gaps / step).astype(int), 1)
    row = np.repeat(np.arange(len(gaps)), counts)
    share = counted(counts) / counts[row]
    return np.concatenate([points[row] + share[:, None] * (points[row + 1] - points[row]), points[-1:]])
