"""Lines and cubics between chosen nodes, which meet in true corners or go on smoothly."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from warpvec.flat.cubic_fitting import PRECISE, fit_cubics, fit_lengths
from warpvec.flat.outline_nodes import Nodes, Samples
from warpvec.flat.span_costs import places_between, typical_distance

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Mask = NDArray[np.bool_]

POINTS = 40
"""Points of the outline that each piece is fitted to at the end."""

SHIFT_MAX = 1.5
"""Pixels that a corner may move to where the pieces on both sides meet; beyond, these are too uncertain."""

CROSSING_MIN = np.sin(np.radians(12.0))
"""Sine of the least angle between two pieces whose crossing is looked for; it is uncertain at smaller angles."""

SMOOTH_DEGREES, CORNER_DEGREES = 25.0, 7.0
"""Largest change of direction that is smoothed away, at a smooth node and at one that may be a corner."""

WORSENING_MAX = 1.5
"""A joint stays a corner if smoothing it brings a piece further from the outline than so many tolerances."""


class Pieces(NamedTuple):
    """R pieces of all loops, in order.

    Attributes:
        start, end: nodes of each piece [R].
        is_line: lines [R].
        before, after: the previous and the next piece of the loop [R].
    """

    start: Integers
    end: Integers
    is_line: Mask
    before: Integers
    after: Integers


def join_pieces(samples: Samples, nodes: Nodes, pieces: Pieces, tolerance: float) -> Floats:
    """Return the control points [R, 3, 2] of the pieces; the handles of lines are at thirds."""
    places = places_between(samples, nodes, pieces.start, pieces.end, POINTS)
    anchor = _anchors(nodes, pieces, places.points, places.parameters)
    end = anchor[pieces.after]
    cubics = fit_cubics(anchor, end, places.points, places.parameters, PRECISE)
    handles, chord = cubics.handles, (end - anchor)[:, None]
    thirds = np.concatenate([anchor[:, None] + chord / 3.0, anchor[:, None] + chord * (2.0 / 3.0)], 1)
    handles = np.where(pieces.is_line[:, None, None], thirds, handles)
    is_smooth = _smooth_joints(nodes, pieces, anchor, handles)
    limit = np.maximum(typical_distance(cubics.distance, cubics.square), tolerance) * WORSENING_MAX
    for _ in range(2):
        smoothed = _smoothed(pieces, anchor, handles, is_smooth)
        fitted = fit_lengths(anchor, end, smoothed, places.points, places.parameters)
        is_bad = (typical_distance(fitted.distance, fitted.square) > limit) & ~pieces.is_line
        is_smooth &= ~(is_bad | is_bad[pieces.before])
    return np.concatenate([anchor[:, None], np.where(pieces.is_line[:, None, None], thirds, fitted.handles)], 1)


def _anchors(nodes: Nodes, pieces: Pieces, points: Floats, parameters: Floats) -> Floats:
    """Return the starts of the pieces [R, 2]: where lines cross or are met, else the nodes."""
    node = nodes.point[pieces.start]
    cubics = fit_cubics(node, nodes.point[pieces.end], points, parameters, PRECISE)
    center = points.mean(1)
    direction = _main_direction(points - center[:, None])
    is_line = pieces.is_line
    leaving = np.where(is_line[:, None], direction, _unit(cubics.handles[:, 0] - node))
    arriving = np.where(is_line[:, None], direction, _unit(nodes.point[pieces.end] - cubics.handles[:, 1]))
    before = pieces.before
    # A line passes through its centre, a cubic's tangent through the node.
    on_next = np.where(is_line[:, None], center, node)
    on_last = np.where(is_line[before][:, None], center[before], node)
    found, is_crossing = _crossings(on_last, arriving[before], on_next, leaving)
    near = np.linalg.norm(found - node, axis=1) < SHIFT_MAX
    nearest_next = center + ((node - center) * direction).sum(1, keepdims=True) * direction
    nearest_last = (
        center[before] + ((node - center[before]) * direction[before]).sum(1, keepdims=True) * direction[before]
    )
    met = np.where(is_line[:, None], nearest_next, np.where(is_line[before][:, None], nearest_last, node))
    has_line = is_line | is_line[before]
    return np.where(
        (is_crossing & near & has_line & (nodes.is_corner[pieces.start] | (is_line & is_line[before])))[:, None],
        found,
        met,
    )


def _main_direction(offsets: Floats) -> Floats:
    """Return the unit vector [R, 2] along which ``offsets`` [R, S, 2] from their mean are longest, from first to last."""
    xx, yy = (offsets[..., 0] ** 2).sum(1), (offsets[..., 1] ** 2).sum(1)
    xy = (offsets[..., 0] * offsets[..., 1]).sum(1)
    angle = np.arctan2(2.0 * xy, xx - yy) / 2.0
    direction = np.stack([np.cos(angle), np.sin(angle)], 1)
    forward = ((offsets[:, -1] - offsets[:, 0]) * direction).sum(1, keepdims=True)
    return np.where(forward < 0, -direction, direction)


def _crossings(a: Floats, along_a: Floats, b: Floats, along_b: Floats) -> tuple[Floats, Mask]:
    """Return where the lines through ``a`` and ``b`` [R, 2] cross, and whether they do so at a clear angle."""
    cross = along_a[:, 0] * along_b[:, 1] - along_a[:, 1] * along_b[:, 0]
    is_clear = np.abs(cross) > CROSSING_MIN
    between = b - a
    share = (between[:, 0] * along_b[:, 1] - between[:, 1] * along_b[:, 0]) / np.where(is_clear, cross, 1.0)
    return a + share[:, None] * along_a, is_clear


def _smooth_joints(nodes: Nodes, pieces: Pieces, anchor: Floats, handles: Floats) -> Mask:
    """Return the starts of pieces [R] where the outline goes on smoothly."""
    leaving, arriving = _directions(pieces, anchor, handles)
    turn = np.degrees(np.arccos(np.clip((leaving * arriving[pieces.before]).sum(1), -1.0, 1.0)))
    has_cubic = ~(pieces.is_line & pieces.is_line[pieces.before])
    return has_cubic & (turn < np.where(nodes.is_corner[pieces.start], CORNER_DEGREES, SMOOTH_DEGREES))


def _directions(pieces: Pieces, anchor: Floats, handles: Floats) -> tuple[Floats, Floats]:
    """Return the unit vectors [R, 2] along which pieces leave their start and arrive at their end."""
    end = anchor[pieces.after]
    return _unit(handles[:, 0] - anchor), _unit(end - handles[:, 1])


def _smoothed(pieces: Pieces, anchor: Floats, handles: Floats, is_smooth: Mask) -> Floats:
    """Return the directions [R, 2, 2] of the handles, the same on both sides of smooth joints."""
    leaving, arriving = _directions(pieces, anchor, handles)
    before, is_line = pieces.before, pieces.is_line
    common = _unit(leaving + arriving[before])
    common = np.where(is_line[:, None], leaving, np.where(is_line[before][:, None], arriving[before], common))
    leaving = np.where(is_smooth[:, None], common, leaving)
    after = pieces.after
    arriving = np.where(is_smooth[after][:, None], common[after], arriving)
    return np.stack([leaving, -arriving], 1)


def _unit(vectors: Floats) -> Floats:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-12)
