"""Lines and cubics between chosen nodes, which meet in true corners or go on smoothly."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from warpvec.arrays import Floats, Integers, Mask
from warpvec.flat.constants.curves import CURVES
from warpvec.flat.curves.cubic_fitting import fit_cubics, fit_lengths
from warpvec.flat.curves.outline_nodes import Nodes, Samples, unit
from warpvec.flat.curves.span_costs import places_between, typical_distance


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


class _Joined(NamedTuple):
    """Control points [R, 3, 2], their distance from the outline [R], and which pieces begin smoothly [R]."""

    segments: Floats
    distance: Floats
    is_smooth: Mask


def join_pieces(samples: Samples, nodes: Nodes, pieces: Pieces, tolerance: Floats) -> Floats:
    """Return the control points [R, 3, 2] of the pieces; the handles of lines are at thirds.

    A slight corner becomes smooth where the pieces then still are within the ``tolerance`` of their loop [L].
    """
    tolerance = tolerance[np.searchsorted(nodes.first, pieces.start, side="right") - 1]
    joined = _joined(samples, nodes, pieces, tolerance)
    is_slight = nodes.is_corner[pieces.start] & (_turns(pieces, joined.segments) < CURVES.slight_corner_degrees)
    is_slight &= ~(pieces.is_line & pieces.is_line[pieces.before])
    if not is_slight.any():
        return joined.segments
    limit = np.maximum(joined.distance, tolerance)
    soft = _joined(samples, _softened(samples, nodes, pieces.start[is_slight]), pieces, tolerance)
    is_worse = (soft.distance > limit) & ~pieces.is_line
    is_slight &= soft.is_smooth & ~(is_worse | is_worse[pieces.before])
    return _joined(samples, _softened(samples, nodes, pieces.start[is_slight]), pieces, tolerance).segments


def rough_pieces(nodes: Nodes, pieces: Pieces) -> Floats:
    """Return control points [R, 3, 2] of the pieces without a fit, smooth at smooth nodes."""
    start, end = nodes.point[pieces.start], nodes.point[pieces.end]
    third = (end - start) / 3.0
    reach = np.linalg.norm(third, axis=1, keepdims=True)
    leaving, arriving = (
        np.where((pieces.is_line | nodes.is_corner[node])[:, None], third, reach * nodes.direction[node])
        for node in (pieces.start, pieces.end)
    )
    return np.stack([start, start + leaving, end - arriving], 1)


def _softened(samples: Samples, nodes: Nodes, chosen: Integers) -> Nodes:
    """Return the nodes with the corners ``chosen`` as smooth nodes on the outline."""
    loop = np.searchsorted(nodes.first, chosen, side="right") - 1
    point, is_corner, trim = nodes.point.copy(), nodes.is_corner.copy(), nodes.trim.copy()
    point[chosen] = samples.xy[samples.first[loop] + nodes.sample[chosen]]
    is_corner[chosen], trim[chosen] = False, 0
    return replace(nodes, point=point, is_corner=is_corner, trim=trim)


def _joined(samples: Samples, nodes: Nodes, pieces: Pieces, tolerance: Floats) -> _Joined:
    places = places_between(samples, nodes, pieces.start, pieces.end, CURVES.joined_points)
    anchor = _anchors(nodes, pieces, places.points, places.parameters)
    end, is_line = anchor[pieces.after], pieces.is_line[:, None, None]
    cubics = fit_cubics(anchor, end, places.points, places.parameters, CURVES.precise_plan)
    chord = (end - anchor)[:, None]
    thirds = np.concatenate([anchor[:, None] + chord / 3.0, anchor[:, None] + chord * (2.0 / 3.0)], 1)
    segments = np.concatenate([anchor[:, None], np.where(is_line, thirds, cubics.handles)], 1)
    highest = np.where(nodes.is_corner[pieces.start], CURVES.corner_node_degrees, CURVES.smooth_node_degrees)
    is_smooth = (_turns(pieces, segments) < highest) & ~(pieces.is_line & pieces.is_line[pieces.before])
    limit = np.maximum(typical_distance(cubics.distance, cubics.square), tolerance) * CURVES.worsening_max
    for _ in range(2):
        directions = _smoothed(pieces, segments, is_smooth)
        fitted = fit_lengths(anchor, end, directions, places.points, places.parameters)
        distance = typical_distance(fitted.distance, fitted.square)
        is_bad = (distance > limit) & ~pieces.is_line
        is_smooth = is_smooth & ~(is_bad | is_bad[pieces.before])
    handles = np.where(is_line, thirds, fitted.handles)
    return _Joined(np.concatenate([anchor[:, None], handles], 1), distance, is_smooth)


def _anchors(nodes: Nodes, pieces: Pieces, points: Floats, parameters: Floats) -> Floats:
    """Return the starts of the pieces [R, 2]: where lines cross or are met, else the nodes."""
    before, is_line = pieces.before, pieces.is_line
    node = nodes.point[pieces.start]
    cubics = fit_cubics(node, nodes.point[pieces.end], points, parameters, CURVES.precise_plan)
    center = points.mean(1)
    along = _main_direction(points - center[:, None])
    leaving = np.where(is_line[:, None], along, unit(cubics.handles[:, 0] - node))
    arriving = np.where(is_line[:, None], along, unit(nodes.point[pieces.end] - cubics.handles[:, 1]))
    # A line passes through its centre, a cubic's tangent through the node.
    on_next = np.where(is_line[:, None], center, node)
    on_last = np.where(is_line[before][:, None], center[before], node)
    found, is_crossing = _crossings(on_last, arriving[before], on_next, leaving)
    met = np.where(is_line[before][:, None], _nearest(node, center[before], along[before]), node)
    met = np.where(is_line[:, None], _nearest(node, center, along), met)
    is_corner = nodes.is_corner[pieces.start] & (is_line | is_line[before])
    sine = np.abs(leaving[:, 0] * arriving[before][:, 1] - leaving[:, 1] * arriving[before][:, 0])
    chord = np.linalg.norm(nodes.point[pieces.end] - node, axis=1)
    shorter = np.minimum(chord, chord[before])
    met = np.where((is_corner & (shorter < CURVES.short_piece))[:, None], node, met)
    shift_max = np.minimum(CURVES.corner_shift_max, CURVES.corner_shift_share * shorter)
    is_near = np.linalg.norm(found - node, axis=1) * np.maximum(sine, CURVES.crossing_min) < shift_max
    return np.where((is_crossing & is_near & (is_corner | (is_line & is_line[before])))[:, None], found, met)


def _nearest(point: Floats, center: Floats, along: Floats) -> Floats:
    """Return the nearest places [R, 2] to ``point`` on lines through ``center`` in the direction ``along``."""
    return center + ((point - center) * along).sum(1, keepdims=True) * along


def _main_direction(offsets: Floats) -> Floats:
    """Return the unit vectors [R, 2] along which ``offsets`` [R, S, 2] from a mean extend, from first to last."""
    xx, yy = (offsets[..., 0] ** 2).sum(1), (offsets[..., 1] ** 2).sum(1)
    xy = (offsets[..., 0] * offsets[..., 1]).sum(1)
    angle = np.arctan2(2.0 * xy, xx - yy) / 2.0
    direction = np.stack([np.cos(angle), np.sin(angle)], 1)
    forward = ((offsets[:, -1] - offsets[:, 0]) * direction).sum(1, keepdims=True)
    return np.where(forward < 0, -direction, direction)


def _crossings(a: Floats, along_a: Floats, b: Floats, along_b: Floats) -> tuple[Floats, Mask]:
    """Return where the lines through ``a`` and ``b`` [R, 2] cross, and whether they do so at a clear angle."""
    cross = along_a[:, 0] * along_b[:, 1] - along_a[:, 1] * along_b[:, 0]
    is_clear = np.abs(cross) > CURVES.crossing_min
    between = b - a
    share = (between[:, 0] * along_b[:, 1] - between[:, 1] * along_b[:, 0]) / np.where(is_clear, cross, 1.0)
    return a + share[:, None] * along_a, is_clear


def _directions(pieces: Pieces, segments: Floats) -> tuple[Floats, Floats]:
    """Return the unit vectors [R, 2] along which pieces leave their start and arrive at their end."""
    end = segments[pieces.after, 0]
    return unit(segments[:, 1] - segments[:, 0]), unit(end - segments[:, 2])


def _turns(pieces: Pieces, segments: Floats) -> Floats:
    """Return by how many degrees the outline turns at the start of each piece [R]."""
    leaving, arriving = _directions(pieces, segments)
    cosine = np.clip((leaving * arriving[pieces.before]).sum(1), -1.0, 1.0)
    return np.degrees(np.arccos(cosine))


def _smoothed(pieces: Pieces, segments: Floats, is_smooth: Mask) -> Floats:
    """Return the directions [R, 2, 2] of the handles, the same on both sides of smooth joints."""
    leaving, arriving = _directions(pieces, segments)
    before, is_line = pieces.before, pieces.is_line
    common = unit(leaving + arriving[before])
    common = np.where(is_line[:, None], leaving, np.where(is_line[before][:, None], arriving[before], common))
    leaving = np.where(is_smooth[:, None], common, leaving)
    after = pieces.after
    arriving = np.where(is_smooth[after][:, None], common[after], arriving)
    return np.stack([leaving, -arriving], 1)
