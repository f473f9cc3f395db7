"""How lines that bend go on through a junction, and where the others end."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from warpvec.arrays import Floats, Mask, cross, dot, reached
from warpvec.flat.constants.lines import LINES
from warpvec.flat.simplification.outline_samples import cubic_points
from warpvec.flat.strokes.inner_disks import Boundary


class Shape(NamedTuple):
    """A component and what is known of it.

    Attributes:
        boundary: its outline.
        tree: of the points of the outline.
        centers: of its stroke [M, 2].
        width: that of the stroke, in pixels, or the usual one.
        widths: that of each branch of its skeleton [B]; None if they all have the ``width``.
    """

    boundary: Boundary
    tree: cKDTree
    centers: cKDTree
    width: float
    widths: Floats | None = None

    def along(self, branch: int) -> Shape:
        """Return the shape with the width of a ``branch``."""
        return self if self.widths is None else self._replace(width=float(self.widths[branch]))

    def is_inside(self, places: Floats) -> Mask:
        """Return which ``places`` [K, 2] lie inside."""
        return self.depth(places) > 0.0

    def depth(self, places: Floats) -> Floats:
        """Return how deep below the outline next to them ``places`` [K, 2] lie [K], in pixels; negative outside."""
        _, nearest = self.tree.query(places)
        away = places - self.boundary.points[nearest]
        return dot(away, self.boundary.inward[nearest])


class End(NamedTuple):
    """An end of a branch at a junction: the branch, whether it is its start, and the direction outwards [2]."""

    branch: int
    is_start: bool
    out: Floats


class Joint(NamedTuple):
    """How the ends at a junction meet.

    Attributes:
        pairs: those that go on into each other, with the points from the first to the second [M, 2] px.
        singles: each other end, with the points [M, 2] px from it to the place where it ends.
        ended: ends that go on by points [M, 2] px to a cap.
    """

    pairs: list[tuple[End, End, Floats]]
    singles: list[tuple[End, Floats]]
    ended: list[tuple[End, Floats]]


class Arm(NamedTuple):
    """The part of a line near its end at a junction.

    Attributes:
        end: the end.
        points: from the end on inwards [M, 2] px.
        out: unit direction outwards at the end [2].
        bend: how the direction turns outwards, in radians a pixel; positive from x to y.
    """

    end: End
    points: Floats
    out: Floats
    bend: float

    @property
    def tip(self) -> Floats:
        """The end [2] px."""
        return self.points[0]


def arms_of(shape: Shape, places: list[Floats], meet: list[End]) -> list[Arm]:
    """Return the arms of the ends ``meet`` of branches with their ``places`` [M, 2]."""
    return [_arm(shape, places, end) for end in meet]


def usual_joint(shape: Shape, arms: list[Arm], near: Floats) -> Joint:
    """Return how ``arms`` most likely go on at a junction ``near`` a place [2].

    Two ends are one line if an arc as bent as they are leads from one to the other.
    """
    return joint_of(shape, arms, [(a, b, bridge_of(a, b)) for a, b in _pairs(arms)], near)


def joint_of(
    shape: Shape,
    arms: list[Arm],
    pairs: list[tuple[Arm, Arm, Floats]],
    near: Floats,
    ended: list[tuple[Arm, Floats]] | None = None,
) -> Joint:
    """Return the joint of ``arms`` of which ``pairs`` go on into each other, by points [M, 2] px.

    Some may go on by points [M, 2] to a cap, where they have ``ended``. Each other end lies where it would cross such a
    line.
    """
    ended = ended or []
    known = {id(arm) for a, b, _ in pairs for arm in (a, b)} | {id(arm) for arm, _ in ended}
    rest = [arm for arm in arms if id(arm) not in known]
    through = [np.concatenate([a.points[::-1], bridge, b.points]) for a, b, bridge in pairs]
    through += [np.concatenate([arm.points[::-1], points]) for arm, points in ended]
    singles = []
    if rest:
        common = _common_place(rest, near)
        if len(rest) < 2 or np.linalg.norm(common - near) > LINES.meeting_far * shape.width:
            common = near
        singles = [(arm.end, _ending(arm, through, near, common, shape.width / 2.0)[None]) for arm in rest]
    return Joint([(a.end, b.end, bridge) for a, b, bridge in pairs], singles, [(arm.end, own) for arm, own in ended])


def _common_place(arms: list[Arm], near: Floats) -> Floats:
    """Return the place nearest to the lines of ``arms`` as they go straight on; ``near`` if they are parallel."""
    across = [np.eye(2) - np.outer(arm.out, arm.out) for arm in arms]
    matrix = np.sum(across, 0)
    if np.linalg.cond(matrix) > 1e4:
        return near
    found: Floats = np.linalg.solve(matrix, np.sum([each @ arm.tip for each, arm in zip(across, arms, strict=True)], 0))
    return found


def _arm(shape: Shape, places: list[Floats], end: End) -> Arm:
    own = places[end.branch] if end.is_start else places[end.branch][::-1]
    along = reached(own)
    reach = max(LINES.arm_reach * shape.along(end.branch).width, LINES.arm_reach_min)
    part = along <= reach
    part[:2] = True
    return arm_along(end, own[part])[0]


def arm_along(end: End, points: Floats) -> tuple[Arm, float]:
    """Return the arm of an ``end`` along ``points`` [M, 2], and how far these are from its parabola, in pixels."""
    along = reached(points)
    terms = np.stack([along, along**2], 1) if len(points) >= 5 else along[:, None]
    found = np.linalg.lstsq(terms, points - points[0], rcond=None)[0]
    speed = max(float(np.linalg.norm(found[0])), 1e-9)
    out = -found[0] / speed
    bend = 2.0 * float(cross(out, found[1])) / speed**2 if len(found) > 1 else 0.0
    off = np.linalg.norm(points - points[0] - terms @ found, axis=1)
    return Arm(end, points, out, bend), float(off.max())


def _turn(a: Floats, b: Floats) -> float:
    """Return the angle from one direction to another in radians."""
    return float(np.arctan2(cross(a, b), a @ b))


def _pairs(arms: list[Arm]) -> list[tuple[Arm, Arm]]:
    """Return the ends that go on into each other, the best first; two ends alone always do."""
    return [(arms[0], arms[1])] if len(arms) == 2 else fitting_pairs(arms)


def fitting_pairs(arms: list[Arm]) -> list[tuple[Arm, Arm]]:
    """Return the ends to which an arc leads from another, the best first."""
    found = sorted(
        (misfit, i, j)
        for i in range(len(arms))
        for j in range(i + 1, len(arms))
        if (misfit := misfit_of(arms[i], arms[j])) <= np.radians(LINES.misfit_degrees)
    )
    pairs, used = [], set[int]()
    for _, i, j in found:
        if not {i, j} & used:
            pairs.append((arms[i], arms[j]))
            used |= {i, j}
    return pairs


def misfit_of(a: Arm, b: Arm) -> float:
    """Return by how much an arc from one end to the other turns more, or less evenly, than both lines do there."""
    chord = b.tip - a.tip
    first, last = _turn(a.out, chord), _turn(chord, -b.out)
    limit = np.radians(LINES.bend_degrees)
    # Walking from a to b, the line b turns the other way than outwards.
    expected = float(np.clip((a.bend - b.bend) / 2.0 * np.linalg.norm(chord), -limit, limit))
    return abs(first - last) + abs(first + last - expected)


def bridge_of(a: Arm, b: Arm) -> Floats:
    """Return points from one end to the other [M, 2] px, without these."""
    gap = float(np.linalg.norm(b.tip - a.tip))
    turn = abs(_turn(a.out, b.tip - a.tip)) + abs(_turn(b.tip - a.tip, -b.out))
    count = int(gap / LINES.bridge_step)
    if count < 2 or turn > np.radians(LINES.bridge_degrees) or misfit_of(a, b) > np.radians(LINES.misfit_degrees):
        return np.zeros((0, 2))
    # The handles of an arc that turns so much over this chord.
    handle = gap * 2.0 / 3.0 / (1.0 + np.cos(turn / 2.0))
    control = np.array([a.tip, a.tip + handle * a.out, b.tip + handle * b.out, b.tip])
    return cubic_points(control[None], np.arange(1, count) / count)[0]


def _ending(arm: Arm, through: list[Floats], near: Floats, common: Floats, more: float) -> Floats:
    """Return where a line ends: on the first line through the junction that it crosses, else at ``common``.

    The line is followed to twice the distance of the junction, and by ``more`` pixels.
    """
    far = 2.0 * float(np.linalg.norm(near - arm.tip)) + more
    along = np.linspace(0.0, far, 65)
    turned = np.clip(arm.bend * along, -0.8, 0.8)
    side = np.array([-arm.out[1], arm.out[0]])
    ray = arm.tip + along[:, None] * arm.out + (turned * along / 2.0)[:, None] * side
    found = [place for line in through if (place := _first_crossing(ray, line)) is not None]
    if found:
        return min(found, key=lambda place: float(np.linalg.norm(place - near)))
    if through:
        places = np.concatenate(through)
        return places[int(np.argmin(np.linalg.norm(places - common, axis=1)))]
    return common


def _first_crossing(ray: Floats, line: Floats) -> Floats | None:
    """Return where a polyline ``ray`` [K, 2] first crosses a ``line`` [M, 2]; None if it does not."""
    a, u = ray[:-1, None], np.diff(ray, axis=0)[:, None]
    b, v = line[None, :-1], np.diff(line, axis=0)[None]
    det = u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]
    safe = np.where(np.abs(det) > 1e-12, det, np.inf)
    gap = b - a
    s = (gap[..., 0] * v[..., 1] - gap[..., 1] * v[..., 0]) / safe
    t = (gap[..., 0] * u[..., 1] - gap[..., 1] * u[..., 0]) / safe
    hit = np.isfinite(safe) & (s >= 0.0) & (s <= 1.0) & (t >= 0.0) & (t <= 1.0)
    if not hit.any():
        return None
    row, column = np.argwhere(hit)[0]
    place: Floats = ray[row] + s[row, column] * (ray[row + 1] - ray[row])
    return place
