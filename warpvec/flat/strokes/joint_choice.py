"""Choose how lines meet at a junction by what that draws, where the usual way does not draw the shape."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree

from warpvec.arrays import Floats, Mask, cross
from warpvec.flat.constants.strokes import STROKES
from warpvec.flat.simplification.outline_samples import cubic_points
from warpvec.flat.strokes.joints import Arm, Joint, Shape, bridge_of, joint_of, usual_joint

CELLS = 16.0
"""Cells across a stroke by which drawn lines are compared with their shape."""

GAIN_MIN = 0.02
"""Least area, in squares of the width, by which another way than the usual one must be nearer to the shape: that of five
cells, which the grid adds or hides by chance. The notch of a corner that is missed by a fifth of the width is as large.
"""

STEP_SHARE = 0.05
"""Distance of points along a line in widths, by which what it draws is known."""


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
    """A way to join lines, and the stems that are none then."""

    joint: Joint
    corners: list[int]


def chosen_joint(
    shape: Shape, lines: dict[int, Floats], arms: list[Arm], junction: int, junctions: Floats, stems: list[Stem]
) -> tuple[Joint, list[int]]:
    """Return how ``arms`` meet at a ``junction``, and the branches that are corners of others.

    Args:
        shape: what they lie in.
        lines: the places along each branch that is a line [M, 2] px.
        arms: the ends of branches at the junction.
        junction: its number.
        junctions: the places of all [J, 2] px.
        stems: branches with a free end.
    """
    near, stems = junctions[junction], [stem for stem in stems if stem.junction == junction]
    stems = [stem for stem in stems if np.linalg.norm(stem.tip - near) <= STROKES.corner_far * shape.width]
    cells, is_inside = _cells(shape, near, junctions, [arm.tip for arm in arms] + [stem.tip for stem in stems])
    ways = list(_ways(shape, arms, near, stems))
    wrong = [_wrong(shape, lines, arms, way, stems, cells, is_inside) for way in ways]
    import os
    if os.environ.get("DBG"): print("JOINT", np.round(near), len(arms), [np.round(stem.tip) for stem in stems], np.round(wrong,3).tolist())
    best = int(np.argmin(wrong))
    chosen = ways[best if wrong[best] <= wrong[0] - GAIN_MIN else 0]
    return chosen.joint, chosen.corners


def _cells(shape: Shape, near: Floats, junctions: Floats, tips: list[Floats]) -> tuple[Floats, Mask]:
    """Return the centres of cells [K, 2] px around a junction and the ends at it, and which lie inside the shape.

    Cells that are nearer to other junctions tell nothing, as these may not be known yet.
    """
    reach = max((float(np.linalg.norm(tip - near)) for tip in tips), default=0.0) + shape.width
    along = np.arange(-reach, reach, shape.width / CELLS)
    places = near + np.stack(np.meshgrid(along, along), -1).reshape(-1, 2)
    places = places[cKDTree(junctions).query(places)[0] >= np.linalg.norm(places - near, axis=1) - 1e-9]
    return places, shape.is_inside(places)


def _ways(shape: Shape, arms: list[Arm], near: Floats, stems: list[Stem]) -> Iterator[_Way]:
    """Yield ways to join ``arms``, the usual one first: as they bend, and as if they were straight."""
    yield _Way(usual_joint(shape, arms, near), [])
    for own in (arms, [_straight(arm) for arm in arms]):
        yield from _ways_of(shape, own, near, stems)


def _straight(arm: Arm) -> Arm:
    """Return an arm that goes straight on: where lines meet, the centres of disks move off them."""
    chord = arm.points[0] - arm.points[-1]
    return arm._replace(out=chord / max(float(np.linalg.norm(chord)), 1e-9), bend=0.0)


def _ways_of(shape: Shape, arms: list[Arm], near: Floats, stems: list[Stem]) -> Iterator[_Way]:
    """Yield ways in which one arm ends where a stem does, or two go on by an arc or in a corner; others end on them."""
    step = STEP_SHARE * shape.width
    for stem in stems:
        others = [arm for arm in arms if arm.end.branch != stem.branch]
        for arm in others:
            ended = [(arm, np.concatenate([_toward(arm, stem.tip, step), stem.tip[None]]))]
            yield _Way(joint_of(shape, others, [], near, ended), [stem.branch])
        for a, b in combinations(others, 2):
            yield _Way(joint_of(shape, others, [(a, b, _corner(a, b, stem.tip, step))], near), [stem.branch])
    for a, b in combinations(arms, 2):
        yield _Way(joint_of(shape, arms, [(a, b, bridge_of(a, b))], near), [])
        place = _crossing(a, b, STROKES.corner_far * shape.width)
        if place is not None:
            yield _Way(joint_of(shape, arms, [(a, b, _corner(a, b, place, step))], near), [])


def _crossing(a: Arm, b: Arm, far: float) -> Floats | None:
    """Return where two lines meet as they go straight on; None if that is behind or ``far`` from their ends."""
    sine = float(cross(a.out, b.out))
    if abs(sine) < STROKES.crossing_min:
        return None
    gap = b.tip - a.tip
    first, second = float(cross(gap, b.out)) / sine, float(cross(gap, a.out)) / sine
    return a.tip + first * a.out if 0.0 < first < far and 0.0 < second < far else None


def _corner(a: Arm, b: Arm, place: Floats, step: float) -> Floats:
    """Return points [M, 2] px from ``a`` to ``b`` through a corner at a ``place`` [2]."""
    return np.concatenate([_toward(a, place, step), place[None], _toward(b, place, step)[::-1]])


def _toward(arm: Arm, place: Floats, step: float) -> Floats:
    """Return points [M, 2] px from the end of an arm to a ``place`` [2]: of an arc that goes on as the arm does."""
    chord = place - arm.tip
    length = float(np.linalg.norm(chord))
    half = float(np.arctan2(cross(arm.out, chord), arm.out @ chord))
    count = int(length / step)
    if count < 2:
        return np.zeros((0, 2))
    half = half if abs(half) < np.pi / 4.0 else 0.0
    way = chord / max(length, 1e-9)
    handle = length * 2.0 / 3.0 / (1.0 + np.cos(half))
    first, last = _turned(way, -half), _turned(way, half)
    control = np.array([arm.tip, arm.tip + handle * first, place - handle * last, place])
    return cubic_points(control[None], np.arange(1, count) / count)[0]


def _turned(way: Floats, angle: float) -> Floats:
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([cosine * way[0] - sine * way[1], sine * way[0] + cosine * way[1]])


def _wrong(
    shape: Shape, lines: dict[int, Floats], arms: list[Arm], way: _Way, stems: list[Stem], cells: Floats, is_inside: Mask
) -> float:
    """Return the area, in squares of the width, in which what the lines draw differs from the shape."""
    tips = {(arm.end.branch, arm.end.is_start): arm.tip for arm in arms}
    step = STEP_SHARE * shape.width
    drawn = [_dense(own, step) for branch, own in lines.items() if branch not in way.corners]
    for stem in stems:
        own = lines.get(stem.branch) if stem.branch not in way.corners else None
        if own is not None:
            nearest = own[np.argmin(np.linalg.norm(own - stem.tip, axis=1))]
            drawn.append(_dense(np.stack([nearest, stem.tip]), step))
    for a, b, points in way.joint.pairs:
        ends = tips[a.branch, a.is_start], tips[b.branch, b.is_start]
        drawn.append(_dense(np.concatenate([ends[0][None], points, ends[1][None]]), step))
    going_on = [*((end, place[None]) for end, place in way.joint.singles), *way.joint.ended]
    drawn += [_dense(np.concatenate([tips[end.branch, end.is_start][None], own]), step) for end, own in going_on]
    distance, _ = cKDTree(np.concatenate(drawn)).query(cells)
    import os
    if os.environ.get("DBG2"):
        bad=(distance <= shape.width / 2.0) != is_inside
        print("   pairs",[(a.branch,b.branch,len(p)) for a,b,p in way.joint.pairs],"singles",[(e.branch,np.round(p,1)) for e,p in way.joint.singles],"ended",[(e.branch,np.round(p[-1],1)) for e,p in way.joint.ended], "bad",bad.sum(), np.round(cells[bad].mean(0)) if bad.any() else "", is_inside[bad].mean())
    return float(((distance <= shape.width / 2.0) != is_inside).sum()) / CELLS**2


def _dense(points: Floats, step: float) -> Floats:
    """Return ``points`` [M, 2] with more between them, at most ``step`` pixels apart."""
    gaps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    counts = np.maximum(np.ceil(gaps / step).astype(int), 1)
    row = np.repeat(np.arange(len(gaps)), counts)
    share = (np.arange(len(row)) - np.repeat(np.cumsum(counts) - counts, counts)) / counts[row]
    return np.concatenate([points[row] + share[:, None] * (points[row + 1] - points[row]), points[-1:]])
