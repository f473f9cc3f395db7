"""Lines of many points as lines and arcs of circles, which machines follow without a stop at every point."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

import numpy as np

from warpvec.arrays import Floats
from warpvec.making.curves import CHORD_ERROR, Piece
from warpvec.making.parts import Circle, Outline, Shape

FINE_ERROR = CHORD_ERROR / 5.0
"""Largest distance in millimetres of the chords that are read from a curve. With ``_ERROR`` it is below
``CHORD_ERROR``."""

_ERROR = CHORD_ERROR / 2.0
"""Largest distance in millimetres of points from the line or arc in their place."""

_EXACT = _ERROR / 10.0
"""Largest distance in millimetres of points from a line, and from an arc that is one. It is less than that of the
second chord of an arc from its tangent, which is four times ``FINE_ERROR``, so that no line takes the end of an arc."""

_SLACK = 2, 0.2
"""Number and share of points by which an arc within ``_ERROR`` may be longer than an exact one that is taken: the
others are of the next piece. Along a curve that is no arc, the length goes with the third root of the error, by a
half."""

_TURN_MAX = 1.5 * math.pi
"""Most radians that an arc turns: the centre of one that is nearly whole follows from its ends badly."""

_SAME = 1e-4
"""Distance in millimetres within which points are one: pieces that meet all but smoothly leave such."""

_CORNER = 0.6
"""Radians that a line turns at a point from which the point is a corner: the chords of curves turn less."""

_CIRCLE_POINTS = 12
"""Fewest points of an outline that may be a circle: a square's lie on one too."""


def with_arcs(outline: Outline) -> Shape:
    """Return ``outline`` with lines and arcs within ``CHORD_ERROR`` of its cubics; a circle if it is one.

    One arc stands for consecutive ones of a circle.
    """
    if outline.is_closed and all(piece.is_cubic or piece.bulge for piece in outline.pieces):
        whole = closed_shape(np.concatenate([piece.chords(FINE_ERROR) for piece in outline.pieces]))
        if isinstance(whole, Circle):
            return whole
    return outline._replace(pieces=_joined_arcs(_pieces(outline)))


def _pieces(outline: Outline) -> Iterator[Piece]:
    waiting: list[Piece] = []
    for piece in outline.pieces:
        if piece.is_cubic:
            waiting.append(piece)
            continue
        yield from _run(waiting)
        waiting = []
        yield piece
    yield from _run(waiting)


def _run(cubics: list[Piece]) -> Iterator[Piece]:
    if cubics:
        yield from _along(np.concatenate([*(piece.chords(FINE_ERROR) for piece in cubics), cubics[-1].points[-1:]]))


def _joined_arcs(pieces: Iterable[Piece]) -> tuple[Piece, ...]:
    """Return ``pieces`` with one arc in place of consecutive ones of a circle."""
    found: list[Piece] = []
    for piece in pieces:
        joined = _joined(found[-1], piece) if found else None
        found = [*found, piece] if joined is None else [*found[:-1], joined]
    return tuple(found)


def _joined(first: Piece, second: Piece) -> Piece | None:
    """Return the arc in place of two; None if they are not of one circle."""
    turn = math.atan(first.bulge) + math.atan(second.bulge)
    if first.bulge * second.bulge <= 0.0 or abs(4.0 * turn) > _TURN_MAX:
        return None
    whole = Piece(np.stack([first.points[0], second.points[1]]), math.tan(turn))
    x, y, radius = whole.circle
    inside = np.stack([_middle(first), second.points[0], _middle(second)])
    return whole if np.abs(np.hypot(*(inside - (x, y)).T) - radius).max() <= CHORD_ERROR else None


def _middle(arc: Piece) -> Floats:
    """Return the point [2] in the middle of an arc."""
    half = (arc.points[1] - arc.points[0]) / 2.0
    return arc.points[0] + half + arc.bulge * np.array([half[1], -half[0]])


def closed_shape(points: Floats) -> Shape:
    """Return the shape along a ring of points [K, 2], whose last one is not the first: a circle, or lines and arcs."""
    is_own = np.hypot(*(points - np.roll(points, 1, axis=0)).T) > _SAME
    points = points[is_own] if is_own.sum() > 2 else points
    center = (points.min(0) + points.max(0)) / 2.0
    radii = np.hypot(*(points - center).T)
    following = np.roll(points, -1, axis=0)
    if len(points) >= _CIRCLE_POINTS and np.ptp(radii) <= CHORD_ERROR:
        area = float((points[:, 0] * following[:, 1] - following[:, 0] * points[:, 1]).sum())
        return Circle(float(center[0]), float(center[1]), float(radii.mean()), 1 if area > 0.0 else -1)
    points = np.roll(points, -_start(points, following), axis=0)
    return Outline(tuple(_along(np.concatenate([points, points[:1]]))), True)


def _start(points: Floats, following: Floats) -> int:
    """Return where no arc goes on: the sharpest corner of a ring, else the end of its longest line."""
    steps = following - points
    angles = np.arctan2(steps[:, 1], steps[:, 0])
    turns = np.abs((angles - np.roll(angles, 1) + math.pi) % (2.0 * math.pi) - math.pi)
    if turns.max() > _CORNER:
        return int(turns.argmax())
    return (int(np.hypot(*steps.T).argmax()) + 1) % len(points)


def _along(points: Floats) -> Iterator[Piece]:
    """Yield few lines and arcs within ``_ERROR`` of a line of points [K, 2], each as long as can be."""
    first = 0
    while first < len(points) - 1:
        (loose, found), (exact, best) = (_longest(points, first, error) for error in (_ERROR, _EXACT))
        if loose - exact <= max(_SLACK[0], _SLACK[1] * (loose - first)):
            loose, found = exact, best
        yield found
        first = loose


def _longest(points: Floats, first: int, error: float) -> tuple[int, Piece]:
    """Return the end of the longest line or arc from the point ``first`` on, and itself."""
    last, good, found, step = len(points) - 1, first + 1, Piece(points[[first, first + 1]]), 1
    while step and good < last:
        stop = min(good + step, last)
        piece = _one(points[first : stop + 1], error)
        if piece is not None:
            good, found, step = stop, piece, 2 * step
        else:
            step = step // 2
    return good, found


def _one(points: Floats, error: float) -> Piece | None:
    """Return the line or the arc from the first to the last of the points [K, 2]; None if it is not near them."""
    half = (points[-1] - points[0]) / 2.0
    length = float(np.hypot(*half))
    if length <= _EXACT:
        return None
    along = half / length
    u, v = np.array([along, [-along[1], along[0]]]) @ (points - points[0] - half).T
    steps = np.hypot(*np.diff(points, axis=0).T)
    if np.abs(v).max() <= _EXACT and np.all(np.diff(u) >= 0.0):
        return Piece(points[[0, -1]])
    # The circle through both ends about (0, c): u² + v² - 2 c v = length².
    c = float((v * (u * u + v * v - length**2)).sum() / (2.0 * (v * v).sum()))
    radius = math.hypot(length, c)
    if np.abs(np.hypot(u, v - c) - radius).max() > error or float(steps.max()) ** 2 > 8.0 * radius * _ERROR:
        return None
    angles = np.unwrap(np.arctan2(v - c, u))
    turn = float(angles[-1] - angles[0])
    if abs(turn) > _TURN_MAX or not (np.diff(angles) * turn > 0.0).all():
        return None
    return Piece(points[[0, -1]], math.tan(turn / 4.0))
