"""Pieces of outlines: lines, arcs of circles and cubics, in millimetres."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from warpvec.arrays import Floats

CHORD_ERROR = 0.01
"""Largest distance in millimetres between a curve and its chords: half of the 0.02 mm that a cut file may be off, and
a tenth of what a good laser cutter repeats."""

ARC_ERROR = 0.003
"""Largest distance in millimetres of a cubic from the arc that replaces it: the last decimal of a file in pixels."""

_TURN_MIN = 0.02
"""Turn in radians below which a curve counts as a line or a cubic, not as an arc: its radius would be a guess."""

_EIGHTH = math.pi / 4.0
"""Most radians that a cubic turns for an arc; it is then within 5e-6 of the radius."""


class Piece(NamedTuple):
    """A piece of an outline.

    Attributes:
        points: start and end [2, 2] of a line or an arc, or the control points [4, 2] of a cubic.
        bulge: tangent of a quarter of the turn of an arc, above 0 if the angle grows; 0 for lines and cubics. DXF files
            state arcs in this way.
    """

    points: Floats
    bulge: float = 0.0

    @property
    def is_cubic(self) -> bool:
        """Whether it is a cubic."""
        return len(self.points) == 4

    @property
    def length(self) -> float:
        """Distance of its ends."""
        return float(np.hypot(*(self.points[-1] - self.points[0])))

    @property
    def circle(self) -> tuple[float, float, float]:
        """The centre and the radius of an arc."""
        start, end = self.points[0], self.points[-1]
        chord = end - start
        left = np.array([-chord[1], chord[0]])
        x, y = (start + end) / 2.0 + left * (1.0 - self.bulge**2) / (4.0 * self.bulge)
        radius = self.length * (1.0 + self.bulge**2) / (4.0 * abs(self.bulge))
        return float(x), float(y), radius

    def chords(self, error: float = CHORD_ERROR) -> Floats:
        """Return points [K, 2] along it, without its end, whose chords are at most ``error`` off."""
        if self.is_cubic:
            return _cubic_points(self.points, error)
        return self._arc_points(error) if self.bulge else self.points[:1]

    def cubics(self) -> list[Floats]:
        """Return cubics [4, 2] along it."""
        if self.is_cubic:
            return [self.points]
        if not self.bulge:
            return [line_cubic(self.points[0], self.points[1])]
        x, y, radius = self.circle
        turn = 4.0 * math.atan(self.bulge)
        count = math.ceil(abs(turn) / _EIGHTH)
        start = math.atan2(self.points[0, 1] - y, self.points[0, 0] - x)
        angle = start + turn * np.arange(count + 1) / count
        places = np.stack([x + radius * np.cos(angle), y + radius * np.sin(angle)], 1)
        places[0], places[-1] = self.points
        handle = 4.0 / 3.0 * math.tan(turn / count / 4.0) * radius * np.stack([-np.sin(angle), np.cos(angle)], 1)
        rows = zip(pairwise(places), pairwise(handle), strict=True)
        return [np.stack([a, a + leaving, b - arriving, b]) for (a, b), (leaving, arriving) in rows]

    def _arc_points(self, error: float) -> Floats:
        x, y, radius = self.circle
        turn = 4.0 * math.atan(self.bulge)
        step = 2.0 * math.acos(max(1.0 - error / radius, 0.0)) if error < radius else math.pi / 2.0
        count = max(1, math.ceil(abs(turn) / step))
        start = math.atan2(self.points[0, 1] - y, self.points[0, 0] - x)
        angle = start + turn * np.arange(count) / count
        points = np.stack([x + radius * np.cos(angle), y + radius * np.sin(angle)], 1)
        points[0] = self.points[0]
        return points


def line_cubic(start: Floats, end: Floats) -> Floats:
    """Return the cubic [4, 2] of a line."""
    return start + np.linspace(0.0, 1.0, 4)[:, None] * (end - start)


def straight(cubic: Floats) -> bool:
    """Return whether a cubic [4, 2] is a line but for ``ARC_ERROR``."""
    chord = cubic[3] - cubic[0]
    length = float(np.hypot(*chord))
    if length <= ARC_ERROR:
        return float(np.hypot(*(cubic - cubic[0]).T).max()) <= ARC_ERROR
    along, across = np.array([chord, [-chord[1], chord[0]]]) @ (cubic[1:3] - cubic[0]).T / length
    return bool((np.abs(across) <= ARC_ERROR).all() and (along >= 0.0).all() and (along <= length).all())


def arc_through(cubic: Floats) -> Piece | None:
    """Return the arc within ``ARC_ERROR`` of a cubic [4, 2], or the arc that it stands for; None without one."""
    chord = cubic[3] - cubic[0]
    length = float(np.hypot(*chord))
    if length <= ARC_ERROR:
        return None
    middle = (cubic[0] + 3.0 * cubic[1] + 3.0 * cubic[2] + cubic[3]) / 8.0 - (cubic[0] + cubic[3]) / 2.0
    bulge = -2.0 * float(chord[0] * middle[1] - chord[1] * middle[0]) / length**2
    if abs(4.0 * math.atan(bulge)) < _TURN_MIN or abs(bulge) > 1.0:
        return None
    piece = Piece(cubic[[0, 3]], bulge)
    x, y, radius = piece.circle
    off = np.abs(np.hypot(*(cubic_at(cubic, np.arange(1, 16) / 16.0) - (x, y)).T) - radius)
    return piece if float(off.max()) <= ARC_ERROR or _stands_for(cubic, piece) else None


def _stands_for(cubic: Floats, arc: Piece) -> bool:
    """Return whether a cubic is the one that programs write for an arc of at most a quarter.

    That of a quarter is up to 0.00027 radii beside the circle, which is more than ``ARC_ERROR`` of a large one.
    """
    turn = 4.0 * math.atan(arc.bulge)
    if abs(turn) > 1.01 * math.pi / 2.0:
        return False
    center = arc.circle[:2]
    handle = 4.0 / 3.0 * math.tan(turn / 4.0)
    away = arc.points - center
    left = handle * np.stack([-away[:, 1], away[:, 0]], 1) * [[1.0], [-1.0]]
    off = np.hypot(*(cubic[1:3] - arc.points - left).T)
    return bool(0.75 * off.max() <= ARC_ERROR)  # a point of a cubic has at most 3/4 of its handles


def _cubic_points(cubic: Floats, error: float) -> Floats:
    """Return points along a cubic without its end.

    A chord over the share 1/n of a cubic is at most 1/8 of the second derivative over n squared off.
    """
    bend = np.hypot(*(cubic[:-2] - 2.0 * cubic[1:-1] + cubic[2:]).T).max()
    count = max(1, math.ceil(math.sqrt(0.75 * float(bend) / error)))
    return cubic_at(cubic, np.arange(count) / count)


def cubic_at(cubic: Floats, t: Floats) -> Floats:
    """Return the points [K, 2] of a cubic [4, 2] at ``t`` [K]."""
    t = t[:, None]
    points: Floats = (
        (1 - t) ** 3 * cubic[0] + 3 * (1 - t) ** 2 * t * cubic[1] + 3 * (1 - t) * t**2 * cubic[2] + t**3 * cubic[3]
    )
    return points
