"""The parts of a chain: lines, circular arcs and cubics, as numbers, and what these numbers draw.

A part has the numbers of its kind: both ends, then the bulge of an arc, or both handles of a cubic, as places. The
bulge is the tangent of a quarter of the angle by which an arc turns, above 0 if it is clockwise on a screen.
"""

from __future__ import annotations

import math

import numpy as np

from warpvec.arrays import Floats, lengths_of
from warpvec.flat.simplification.outline_samples import cubic_points, cubic_slopes
from warpvec.kernels import part_choice

LINE, ARC, CUBIC = part_choice.LINE, part_choice.ARC, part_choice.CUBIC
"""The kinds of parts."""

SIZES = {LINE: 4, ARC: 5, CUBIC: 8}
"""Numbers of a part of each kind."""

SAMPLES = 12
"""Points of a part at which its distance from the chain is taken."""

_T = (np.arange(SAMPLES) + 0.5) / SAMPLES

_ENDS = np.array([0.0, 1.0])

_FLAT = 1e-9
"""Half an angle in radians below which an arc is a line."""


def drawn(kind: int, numbers: Floats) -> tuple[Floats, Floats]:
    """Return points [B, SAMPLES, 2] of parts of one ``kind``, and their unit directions at both ends [B, 2, 2]."""
    start, end = numbers[:, :2], numbers[:, 2:4]
    if kind == CUBIC:
        control = np.stack([start, numbers[:, 4:6], numbers[:, 6:8], end], 1)
        return cubic_points(control, _T), unit(cubic_slopes(control, _ENDS))
    chord = end - start
    if kind == LINE:
        return start[:, None] + _T[:, None] * chord[:, None], np.repeat(unit(chord)[:, None], 2, 1)
    half = 2.0 * np.arctan(numbers[:, 4])
    half = np.where(np.abs(half) < _FLAT, _FLAT, half)[:, None]
    share = np.sin(half * _T) / np.sin(half)
    points = start[:, None] + share[..., None] * turned(chord[:, None], half * (_T - 1.0))
    return points, turned(unit(chord)[:, None], half * np.array([-1.0, 1.0]))


def radius_of(numbers: Floats) -> Floats:
    """Return the radii of arcs [B], signed as their bulges are."""
    chord, bulge = np.linalg.norm(numbers[:, 2:4] - numbers[:, :2], axis=1), numbers[:, 4]
    return chord * (1.0 + bulge * bulge) / (4.0 * np.where(np.abs(bulge) < _FLAT, _FLAT, bulge))


def bulge_of(numbers: Floats, radius: float) -> float:
    """Return the bulge by which an arc with ``numbers`` [5] has this ``radius``; 1 or -1 if its chord is too long.

    An arc without a chord keeps its own.
    """
    chord, bulge = float(np.linalg.norm(numbers[2:4] - numbers[:2])), float(numbers[4])
    if chord == 0.0:
        return bulge
    rise = math.sqrt(max(radius * radius - chord * chord / 4.0, 0.0))
    share = (radius + rise if abs(bulge) > 1.0 else radius - rise) / (chord / 2.0)
    return math.copysign(share if rise > 0.0 else 1.0, bulge)


def rows_of(kind: int, numbers: Floats) -> Floats:
    """Return the rows [n, 3, 2] that draw one part: an arc has one for each quarter of a turn that it begins."""
    start, end = numbers[:2], numbers[2:4]
    if kind == CUBIC:
        return np.stack([start, numbers[4:6], numbers[6:8]])[None]
    if kind == LINE or abs(numbers[4]) < _FLAT:
        return np.stack([start, start + (end - start) / 3.0, start + (end - start) * (2.0 / 3.0)])[None]
    half = 2.0 * math.atan(numbers[4])
    count = _quarters_of(float(numbers[4]))
    t = np.arange(count + 1) / count
    share = np.sin(half * t) / math.sin(half)
    nodes = start + share[:, None] * turned((end - start)[None], half * (t - 1.0))
    nodes[-1] = end
    ways = turned(unit(end - start)[None], half * (2.0 * t - 1.0))
    reach = 4.0 / 3.0 * abs(math.tan(half / count / 2.0) * radius_of(numbers[None])[0])
    return np.stack([nodes[:-1], nodes[:-1] + reach * ways[:-1], nodes[1:] - reach * ways[1:]], 1)


def _quarters_of(bulge: float) -> int:
    """Return how many quarters of a turn an arc with this ``bulge`` begins, at least one, as kernels count them."""
    return max(math.ceil(4.0 * math.atan(abs(bulge)) / (math.pi / 2.0) - part_choice.SAME_QUARTER), 1)


def turned(vectors: Floats, angle: Floats) -> Floats:
    """Return ``vectors`` [..., 2] turned by ``angle`` [...] in radians, clockwise on a screen."""
    cosine, sine = np.cos(angle), np.sin(angle)
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([cosine * x - sine * y, sine * x + cosine * y], -1)


def unit(vectors: Floats) -> Floats:
    """Return ``vectors`` [..., 2] with the length 1."""
    return vectors / np.maximum(lengths_of(vectors)[..., None], 1e-12)
