"""Make lines level, upright and parallel, their corners right, and lines of nearly equal place aligned."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from warpvec.arrays import Floats, Integers, Mask
from warpvec.flat.constants.simplification import SIMPLIFICATION


@dataclass(frozen=True, eq=False)
class Lines:
    """K lines of a scene of R segments.

    Attributes:
        row: the segment of each [K].
        path: the path of each [K].
        start, end: its ends [K, 2].
        weight: how much of it the picture shows [K], in pixels.
    """

    row: Integers
    path: Integers
    start: Floats
    end: Floats
    weight: Floats


def regular_anchors(lines: Lines, anchor: Floats, preceding: Integers) -> Floats:
    """Return the anchors [R, 2] of a scene whose ``lines`` are regular; nodes that would move far stay.

    Args:
        lines: the lines of the scene.
        anchor: its anchors [R, 2].
        preceding: the row before each [R].
    """
    if not len(lines.row):
        return anchor
    direction, is_axis = _directions(lines)
    place = _aligned_middles(lines, direction, is_axis)
    return _moved(lines, direction, place, anchor, preceding)


def _directions(lines: Lines) -> tuple[Floats, Mask]:
    """Return the unit direction of each line [K, 2] after turning, and which lines are level or upright [K].

    Angles count without multiples of 90 degrees, so that right angles and parallels are one thing.
    """
    chord = lines.end - lines.start
    length = np.linalg.norm(chord, axis=1)
    angle = np.degrees(np.arctan2(chord[:, 1], chord[:, 0]))
    rest = (angle + 45.0) % 90.0 - 45.0
    target = rest.copy()
    for path in np.unique(lines.path):
        rows = np.flatnonzero(lines.path == path)
        for group in groups(rest[rows], SIMPLIFICATION.parallel_degrees):
            members = rows[group]
            weight = lines.weight[members] * np.square(length[members]) + 1e-9
            offset = (rest[members] - rest[members[0]] + 45.0) % 90.0 - 45.0
            target[members] = rest[members[0]] + np.average(offset, weights=weight)
    target = (target + 45.0) % 90.0 - 45.0
    is_axis = _may_turn(target, length) & _may_turn(rest, length)
    target = np.where(is_axis, 0.0, target)
    target = np.where(_may_turn(target - rest, length), target, rest)
    final = np.radians(angle - rest + target)
    direction = np.stack([np.cos(final), np.sin(final)], 1)
    return np.where(is_axis[:, None], np.round(direction), direction), is_axis


def _may_turn(degrees: Floats, length: Floats) -> Mask:
    return (np.abs(degrees) <= SIMPLIFICATION.line_turn_max) & (
        np.radians(np.abs(degrees)) * length / 2.0 <= SIMPLIFICATION.line_move_max
    )


def groups(values: Floats, gap: float) -> list[Integers]:
    """Return the indices of ``values`` in groups within which sorted neighbours are at most ``gap`` apart."""
    order = np.argsort(values, kind="stable")
    cuts = np.flatnonzero(np.diff(values[order]) > gap) + 1
    return [group for group in np.split(order, cuts) if len(group)]


def _aligned_middles(lines: Lines, direction: Floats, is_axis: Mask) -> Floats:
    """Return a point of each line [K, 2]: its middle, moved onto the common place of lines that are in line."""
    middle = (lines.start + lines.end) / 2.0
    for axis in (0, 1):
        rows = np.flatnonzero(is_axis & (direction[:, axis] == 0.0))
        for group in groups(middle[rows, axis], SIMPLIFICATION.aligned_distance):
            members = rows[group]
            values = middle[members, axis]
            if np.ptp(values) <= SIMPLIFICATION.line_move_max:
                middle[members, axis] = np.average(values, weights=lines.weight[members] + 1e-9)
    return middle


def _moved(lines: Lines, direction: Floats, place: Floats, anchor: Floats, preceding: Integers) -> Floats:
    """Return the anchors [R, 2] on the lines beside them, and in the corner of two."""
    number = np.full(len(anchor), -1)
    number[lines.row] = np.arange(len(lines.row))
    after, before = number, number[preceding]
    moved = anchor.copy()
    for line, other in ((after, before), (before, after)):
        rows = np.flatnonzero((line >= 0) & (other < 0))
        moved[rows] = _projected(anchor[rows], place[line[rows]], direction[line[rows]])
    both = np.flatnonzero((after >= 0) & (before >= 0))
    moved[both] = _crossing(anchor[both], place, direction, before[both], after[both])
    is_near = np.linalg.norm(moved - anchor, axis=1) <= 2.0 * SIMPLIFICATION.line_move_max
    return np.where(is_near[:, None], moved, anchor)


def _projected(points: Floats, place: Floats, direction: Floats) -> Floats:
    """Return ``points`` [K, 2] on the lines through ``place`` along ``direction``; level and upright ones exactly."""
    along = ((points - place) * direction).sum(1, keepdims=True)
    on_line = place + along * direction
    return np.where(direction == 0.0, place, on_line)


def _crossing(points: Floats, place: Floats, direction: Floats, first: Integers, second: Integers) -> Floats:
    """Return where the lines ``first`` and ``second`` [K] cross, or near ``points`` if they are almost parallel."""
    u, v = direction[first], direction[second]
    sine = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    offset = place[second] - place[first]
    along = (offset[:, 0] * v[:, 1] - offset[:, 1] * v[:, 0]) / np.where(np.abs(sine) < 1e-9, 1.0, sine)
    crossing = place[first] + along[:, None] * u
    crossing = np.where(u == 0.0, place[first], np.where(v == 0.0, place[second], crossing))
    between = (_projected(points, place[first], u) + _projected(points, place[second], v)) / 2.0
    is_clear = np.abs(sine) > np.sin(np.radians(SIMPLIFICATION.crossing_degrees_min))
    return np.where(is_clear[:, None], crossing, between)
