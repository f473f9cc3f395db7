"""Fit a centre line, given as points, by few lines, arcs and cubics."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warpvec.arrays import Floats, Integers, Mask, counted, interpolated, reached
from warpvec.flat.chains.chain import Chain
from warpvec.flat.chains.grid import arcs_among
from warpvec.flat.chains.saying import said_rows
from warpvec.flat.constants.strokes import STROKES
from warpvec.flat.curves.cubic_fitting import fit_lengths
from warpvec.flat.cutting.cut_edges import between
from warpvec.flat.price import ARC, CUBIC, LINE, number_nats

_SAMPLES = 16
"""Points of the line to which the cubic between two nodes is fitted."""


class Line(NamedTuple):
    """A centre line.

    Attributes:
        points: along it, in order [K, 2] px; those of a closed one do not repeat the first.
        is_closed: whether it goes on from the last point to the first.
    """

    points: Floats
    is_closed: bool


class Rows(NamedTuple):
    """The rows of a centre line: control points [S, 3, 2], which are lines [S], and whether it is an open line.

    The last row of an open line is its end.
    """

    control: Floats
    is_line: Mask
    is_open: bool


class _Nodes(NamedTuple):
    """Nodes along a line: numbers of points [N], directions before and after [N, 2], and which are corners [N]."""

    place: Integers
    before: Floats
    after: Floats
    is_corner: Mask


def fit_line(line: Line, width: float, spread: float, nodes_max: int = STROKES.nodes_max) -> Rows:
    """Return the cheapest rows near a ``line`` of a stroke of ``width`` pixels, as chains have them.

    Args:
        line: the centre line.
        width: of its stroke in pixels.
        spread: standard deviation of its places in pixels.
        nodes_max: most nodes beside corners of the cubics by which it is drawn first.
    """
    points = resampled(line)
    if len(points) < 3:
        return _single(points, line.is_closed)
    if line.is_closed:
        start = int(np.argmax(_turns(points, width, True)))
        points = np.concatenate([np.roll(points, -start, axis=0), points[start : start + 1]])
    points, nodes = _find_nodes(points, width, line.is_closed, nodes_max)
    chain, nats = Chain.of(_short_curves(points, nodes), line.is_closed), number_nats(float(np.ptp(points, 0).max()))
    return Rows(*said_rows({0: chain}, spread, nats)[0], not line.is_closed)


def curves_of(rows: Rows) -> Floats:
    """Return the curves [S, 4, 2] of a centre line."""
    ends = np.roll(rows.control[:, :1], -1, axis=0)
    curves: Floats = np.concatenate([rows.control, ends], 1)
    return curves[:-1] if rows.is_open else curves


def cost_of(rows: Rows) -> float:
    """Return the numbers that a file needs for the rows; the line that closes one needs none."""
    curves = curves_of(rows)
    is_arc, goes_on, _ = arcs_among(curves, np.roll(np.arange(len(curves)), -1))
    goes_on[0] &= not (rows.is_open or goes_on.all())
    numbers = np.where(rows.is_line[: len(curves)], LINE, np.where(is_arc, ARC, CUBIC) * ~goes_on)
    closing = 0.0 if rows.is_open or not rows.is_line[-1] else LINE
    return float(numbers.sum() - closing)


def halved(rows: Rows) -> Rows:
    """Return a centre line with both halves of each cubic; its lines stay."""
    curves = curves_of(rows)
    is_line = rows.is_line[: len(curves)]
    counts = np.where(is_line, 1, 2)
    row, number = np.repeat(np.arange(len(curves)), counts), counted(counts)
    parts = between(curves[row], number / counts[row], (number + 1) / counts[row])[:, :3]
    control, is_line = np.where(is_line[row][:, None, None], curves[row, :3], parts), is_line[row]
    if rows.is_open:
        control, is_line = np.concatenate([control, rows.control[-1:]]), np.append(is_line, True)
    return Rows(control, is_line, rows.is_open)


def corner_turns(curves: Floats) -> Floats:
    """Return the turn in degrees at the start of each of the ``curves`` [S, 4, 2] of a closed line [S]."""
    arriving, leaving = _unit(curves[:, 3] - _near(curves, False)), _unit(_near(curves, True) - curves[:, 0])
    return np.degrees(np.arccos(np.clip((np.roll(arriving, 1, axis=0) * leaving).sum(1), -1.0, 1.0)))


def _near(curves: Floats, is_start: bool) -> Floats:
    """Return the control point next to the start, or the end, of curves [S, 4, 2] that lies apart from it [S, 2]."""
    order = (1, 2, 3) if is_start else (2, 1, 0)
    end, found = curves[:, 0 if is_start else 3], curves[:, order[2]].copy()
    for k in order[1::-1]:
        is_apart = np.linalg.norm(curves[:, k] - end, axis=1) > 1e-2
        found[is_apart] = curves[is_apart, k]
    return found


def resampled(line: Line) -> Floats:
    """Return points at equal steps along a line, its ends included."""
    points = line.points
    if line.is_closed:
        points = np.concatenate([points, points[:1]])
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    points = points[np.concatenate([[True], steps > 1e-6])]
    along = reached(points)
    count = max(round(along[-1] / STROKES.step), 1)
    places = np.linspace(0.0, along[-1], count + 1)
    found = interpolated(places, along, points)
    return found[:-1] if line.is_closed else found


def _single(points: Floats, is_closed: bool) -> Rows:
    start, end = points[0], points[-1]
    rows = [[start, start + (end - start) / 3, start + (end - start) * 2 / 3]]
    if is_closed:
        return Rows(np.array(rows), np.array([True]), False)
    return Rows(np.array([*rows, [end, end, end]]), np.array([True, True]), True)


def _turns(points: Floats, width: float, is_closed: bool) -> Floats:
    """Return the turn in degrees at each point, between the parts of the line before and after it [K]."""
    span = max(round(STROKES.corner_span * width / STROKES.step), 2)
    count = len(points)
    if is_closed:
        before, after = np.roll(points, span, axis=0), np.roll(points, -span, axis=0)
    else:
        place = np.arange(count)
        before, after = points[np.maximum(place - span, 0)], points[np.minimum(place + span, count - 1)]
    first, second = points - before, after - points
    cross = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    return np.abs(np.degrees(np.arctan2(cross, (first * second).sum(1))))


def _find_nodes(points: Floats, width: float, is_closed: bool, nodes_max: int) -> tuple[Floats, _Nodes]:
    """Return the points with exact corners, and the nodes by which the line is drawn first."""
    count = len(points)
    span = max(round(STROKES.corner_span * width / STROKES.step), 2)
    turns = _turns(points[:-1], width, True) if is_closed else _turns(points, width, False)
    turns = np.append(turns, turns[0]) if is_closed else turns
    sharp = _sharpness(points, turns, span, is_closed)
    gap = max(STROKES.node_gap, count * STROKES.step / nodes_max)
    even = np.round(np.linspace(0, count - 1, max(int(count * STROKES.step / gap), 1) + 1)).astype(int)
    corners = np.flatnonzero(sharp)
    points = _with_exact_corners(points, corners, span, is_closed)
    far = np.array([not len(corners) or np.abs(corners - k).min() > span // 2 for k in even])
    index = np.unique(np.concatenate([even[far], corners, [0, count - 1]]))
    is_corner = np.isin(index, corners)
    before, after = _directions(points, index, is_corner, span, is_closed)
    return points, _Nodes(index, before, after, is_corner)


def _sharpness(points: Floats, turns: Floats, span: int, is_closed: bool) -> Mask:
    """Return the points that are corners: the sharpest of their part, where the turn is not spread along the line."""
    count = len(points)
    around = np.arange(-span, span + 1)
    found = np.zeros(count, bool)
    for k in np.flatnonzero(turns > STROKES.corner_degrees).tolist():
        if turns[k] < _at(turns, k + around, is_closed).max():
            continue
        low, high = k - 2 * span, k + 2 * span
        if not is_closed and (low < 0 or high >= count):
            found[k] = turns[k] > 2.0 * STROKES.corner_degrees
            continue
        # An arc that turns as much in this part goes on to turn outside of it.
        first = _at(points, np.array([k - span]), is_closed) - _at(points, np.array([low]), is_closed)
        last = _at(points, np.array([high]), is_closed) - _at(points, np.array([k + span]), is_closed)
        cross = first[0, 0] * last[0, 1] - first[0, 1] * last[0, 0]
        whole = abs(np.degrees(np.arctan2(cross, (first * last).sum())))
        found[k] = whole < 1.5 * turns[k]
    if is_closed:
        found[-1] = found[0]
    else:
        found[[0, -1]] = False
    return found


def _directions(points: Floats, index: Integers, is_corner: Mask, span: int, is_closed: bool) -> tuple[Floats, Floats]:
    """Return unit directions of the line before and after the points ``index`` [N]; they differ at corners only."""
    near = max(span // 3, 2)
    smooth = _at(points, index + near, is_closed) - _at(points, index - near, is_closed)
    before, after = smooth.copy(), smooth
    for k in np.flatnonzero(is_corner | (not is_closed) & ((index == 0) | (index == len(points) - 1))).tolist():
        before[k] = -_leaving(points, int(index[k]), -1, span, is_closed)[1]
        after[k] = _leaving(points, int(index[k]), 1, span, is_closed)[1]
    return _unit(before), _unit(after)


def _with_exact_corners(points: Floats, corners: Integers, span: int, is_closed: bool) -> Floats:
    """Return ``points`` with each corner where the lines beside it meet: points at equal steps cut it off.

    Where they seem to meet before it, both arcs turn back from its place.
    """
    points = points.copy()
    for k in corners.tolist():
        (a, first), (b, second) = (_leaving(points, k, step, span, is_closed) for step in (-1, 1))
        matrix = np.stack([first, -second], 1)
        if abs(np.linalg.det(matrix)) < STROKES.crossing_min * np.linalg.norm(first) * np.linalg.norm(second):
            continue
        place = a + np.linalg.solve(matrix, b - a)[0] * first
        if (place - points[k]) @ (first + second) <= 0.0 and np.linalg.norm(place - points[k]) <= span * STROKES.step:
            points[k] = place
    if is_closed:
        last = len(points) - 1
        points[0] = points[last] if last in corners.tolist() else points[0]
        points[last] = points[0]
    return points


def _at(points: Floats, k: Integers, is_closed: bool) -> Floats:
    """Return the rows of these numbers; those past the ends of a closed line are on its other end."""
    if is_closed:
        return points[:-1][k % (len(points) - 1)]
    return points[np.clip(k, 0, len(points) - 1)]


def _leaving(points: Floats, start: int, step: int, span: int, is_closed: bool) -> tuple[Floats, Floats]:
    """Return where a line leaves a point, and its direction [2]: of a parabola through points that are not too near.

    Near a corner the centres of disks cut it off.
    """
    place = np.unique(np.linspace(span // 2, 3 * span, 8).round().astype(int))
    if not is_closed:
        place = place[(start + step * place >= 0) & (start + step * place < len(points))]
    if len(place) < 4:
        return points[start], _at(points, np.array(start + step * 2), is_closed) - points[start]
    terms = np.stack([np.ones(len(place)), place, place**2], 1).astype(np.float64)
    found = np.linalg.lstsq(terms, _at(points, start + step * place, is_closed), rcond=None)[0]
    return found[0], found[1]


def _unit(vectors: Floats) -> Floats:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-9)


def _short_curves(points: Floats, nodes: _Nodes) -> Floats:
    """Return the cubics [N - 1, 4, 2] from each node to the next that are closest to the points between them."""
    first, last = nodes.place[:-1], nodes.place[1:]
    share = np.tile((np.arange(_SAMPLES) + 0.5) / _SAMPLES, (len(first), 1))
    place = first[:, None] + share * (last - first)[:, None]
    inner = interpolated(place, np.arange(len(points)), points)
    directions = np.stack([nodes.after[:-1], -nodes.before[1:]], 1)
    start, end = points[first], points[last]
    handles = fit_lengths(start, end, directions, inner, share).handles
    return np.concatenate([start[:, None], handles, end[:, None]], 1)
