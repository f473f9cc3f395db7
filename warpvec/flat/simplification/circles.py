"""Find the closed outlines that are circles and ellipses, and draw them by four arcs."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from warpvec.arrays import Floats
from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.geometry.quarter import QUARTER_HANDLE


class Ellipse(NamedTuple):
    """An ellipse: its centre, its half axes, and the angle of the first in radians."""

    x: float
    y: float
    a: float
    b: float
    angle: float

    def segments(self, is_clockwise: bool) -> Floats:
        """Return the control points [4, 3, 2] of its arcs, from the end of the first axis on."""
        turn = np.radians([0.0, 90.0, 180.0, 270.0])
        if not is_clockwise:
            turn = -turn
        unit = np.round(np.stack([np.cos(turn), np.sin(turn)], 1))
        following = np.roll(unit, -1, 0)
        corners = np.stack([unit, unit + QUARTER_HANDLE * following, following + QUARTER_HANDLE * unit], 1)
        cosine, sine = math.cos(self.angle), math.sin(self.angle)
        axes = np.array([[self.a * cosine, self.a * sine], [-self.b * sine, self.b * cosine]])
        return corners @ axes + np.array([self.x, self.y])

    def distances(self, points: Floats) -> Floats:
        """Return about how far ``points`` [K, 2] are from it [K], in pixels."""
        cosine, sine = math.cos(self.angle), math.sin(self.angle)
        offset = points - np.array([self.x, self.y])
        u = (offset @ np.array([cosine, sine])) / self.a
        v = (offset @ np.array([-sine, cosine])) / self.b
        value = u * u + v * v - 1.0
        slope = 2.0 * np.hypot(u / self.a, v / self.b)
        return np.abs(value) / np.maximum(slope, 1e-9)


def ellipse_of(points: Floats, weights: Floats) -> Ellipse | None:
    """Return the ellipse that an outline is, or None. A circle is preferred to a level ellipse, that to a tilted one.

    Args:
        points: points along the outline [K, 2].
        weights: length of the outline that each stands for, as far as the picture shows it [K].
    """
    if len(points) < 8 or weights.sum() <= 0.0:
        return None
    free = _fitted(points, weights, 5)
    if free is None or min(free.a, free.b) < SIMPLIFICATION.ellipse_radius_min or not _is_near(free, points, weights):
        return None
    if _seen_share(free, points, weights) < SIMPLIFICATION.ellipse_seen_min:
        return None
    for count in _simpler(free):
        found = _fitted(points, weights, count)
        if found is not None and _is_near(found, points, weights):
            return found
    return free


def _simpler(free: Ellipse) -> list[int]:
    """Return the numbers of free parameters of simpler forms that ``free`` may have: 3 for a circle, 4 if level."""
    if abs(free.a - free.b) < SIMPLIFICATION.circle_difference:
        return [3, 4]
    tilt = (free.angle + math.pi / 4) % (math.pi / 2) - math.pi / 4
    return [4] if abs(tilt) * abs(free.a - free.b) < SIMPLIFICATION.ellipse_tilt_move else []


def _fitted(points: Floats, weights: Floats, count: int) -> Ellipse | None:
    """Return the ellipse of ``count`` free parameters with the least squares of the distance; None if there is none.

    The squares of an equation come first. Divided by the slope of that equation they are distances, which takes two
    more rounds.
    """
    centre = np.average(points, axis=0, weights=weights)
    scale = float(np.sqrt(np.average(np.square(points - centre).sum(1), weights=weights)))
    if scale <= 0.0:  # all that the picture shows of it is one point
        return None
    x, y = ((points - centre) / scale).T
    quadratic = {3: [x * x + y * y], 4: [x * x, y * y], 5: [x * x, x * y, y * y]}[count]
    terms = np.stack([*quadratic, x, y], 1)
    share, found = weights, None
    for _ in range(3):
        root = np.sqrt(share)[:, None]
        solution = np.linalg.lstsq(terms * root, np.ones(len(x)) * root[:, 0], rcond=None)[0]
        conic = _full_conic(solution.tolist())
        found = _from_conic(conic)
        if found is None:
            return None
        a, b, c, d, e = conic
        slope = np.hypot(2 * a * x + b * y + d, b * x + 2 * c * y + e)
        share = weights / np.maximum(np.square(slope), 1e-6)
    assert found is not None
    return Ellipse(
        found.x * scale + centre[0], found.y * scale + centre[1], found.a * scale, found.b * scale, found.angle
    )


def _full_conic(terms: list[float]) -> tuple[float, ...]:
    """Return a, b, c, d, e of a x x + b x y + c y y + d x + e y = 1 from those of a circle, a level ellipse, or all."""
    if len(terms) == 5:
        return tuple(terms)
    first, last = terms[0], terms[-3]
    return (first, 0.0, last, *terms[-2:])


def _from_conic(conic: tuple[float, ...]) -> Ellipse | None:
    """Return the ellipse a x x + b x y + c y y + d x + e y = 1, or None if that is none."""
    a, b, c, d, e = conic
    matrix = np.array([[a, b / 2.0], [b / 2.0, c]])
    if a + c <= 0.0 or np.linalg.det(matrix) <= 1e-12:
        return None
    centre = np.linalg.solve(matrix, [-d / 2.0, -e / 2.0])
    level = 1.0 + float(centre @ matrix @ centre)
    if level <= 0.0:
        return None
    if b == 0.0:
        return Ellipse(centre[0], centre[1], math.sqrt(level / a), math.sqrt(level / c), 0.0)
    values, vectors = np.linalg.eigh(matrix)
    angle = math.atan2(vectors[1, 0], vectors[0, 0])
    return Ellipse(centre[0], centre[1], math.sqrt(level / values[0]), math.sqrt(level / values[1]), angle)


def _is_near(ellipse: Ellipse, points: Floats, weights: Floats) -> bool:
    distance = ellipse.distances(points)
    mean = float(np.average(np.square(distance), weights=weights))
    return mean <= SIMPLIFICATION.ellipse_distance_rms**2 and bool(
        (distance[weights > 0.0] <= SIMPLIFICATION.ellipse_distance_max).all()
    )


def _seen_share(ellipse: Ellipse, points: Floats, weights: Floats) -> float:
    """Return the share of the full turn around ``ellipse`` in which its outline has weight."""
    x, y = (points[weights > 0.0] - np.array([ellipse.x, ellipse.y])).T
    angle = np.sort(np.degrees(np.arctan2(y, x)))
    gaps = np.diff(np.append(angle, angle[0] + 360.0))
    return float(gaps[gaps <= SIMPLIFICATION.ellipse_gap_max].sum() / 360.0)
