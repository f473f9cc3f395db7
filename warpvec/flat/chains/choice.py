"""Choose the parts of a chain by price: one exact search over all places where a part may begin and end.

The price of a part is the numbers that it says, and how far it misses the chain. A number is worth some nats. What is
said already is free: a smooth joint says one number less, and so does a line that is level or upright.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warpvec.arrays import Floats, Integers
from warpvec.flat import price
from warpvec.flat.chains.chain import Chain, angle_between
from warpvec.flat.chains.parts import CUBIC, LINE, unit
from warpvec.flat.constants.curves import CURVES
from warpvec.flat.curves.cubic_fitting import fit_cubics

NUMBERS = (price.LINE, price.ARC, price.CUBIC)
"""Numbers of the parts of each kind."""

SMOOTH_DEGREES = 3.0
SMOOTH_DEGREES_MAX = 10.0
"""Angle in degrees between the end of a part and the chain up to which a joint is smooth, for long parts and at most.
A part that is off by as much as outlines may be, at one end only, turns by the ratio of that to its length."""

WORD = 1.5
"""Numbers that a part costs beside its own: for where it ends, and for which kind it is."""

LEVEL_DEGREES = 1.0
"""Angle in degrees from level or upright up to which a line saves a number."""

KINK = 2.0
"""Numbers that a joint costs which is neither smooth nor a corner of the chain."""

REACH = 4.0
"""Length in pixels over which the places of an outline depend on each other: they are those of fitted curves."""

SWEEP_MAX = np.radians(330.0)
"""Most that an arc turns. Whole circles are forms."""


RISE = 3.0
"""Least rise of an arc over its chord, in deviations of places: with less it may be a line that is off at its ends."""

JOINED_SAMPLES = 16
"""Points of the chain to which a cubic over several curves is fitted."""

LENGTH_ERROR = 0.2
"""Largest share by which the length of a line or an arc may differ from that of the chain: a hairpin lies on a line,
and a whole turn ends where it begins."""


class Part(NamedTuple):
    """A part of a chain.

    Attributes:
        kind: line, arc or cubic.
        first, last: its first and last point.
        ways: its unit directions at both [2, 2].
        bulge: that of the arc.
        handles: of a cubic along several curves [2, 2]; None for one along a part of a curve.
    """

    kind: int
    first: int
    last: int
    ways: Floats
    bulge: float
    handles: Floats | None = None


def chosen_parts(chain: Chain, spread: float, number_nats: float) -> list[Part]:
    """Return the cheapest parts of ``chain`` from its first point to its last.

    A first search takes cubics from the curves of the chain; a second one also tries cubics over several of them, from
    and to where its parts end and where the curves do.

    Args:
        chain: the chain of K points.
        spread: standard deviation in pixels of its places.
        number_nats: nats of a number.
    """
    first, last = _pairs(chain)
    if not len(first):
        return []
    count, per_square = len(chain.points), 1.0 / (2.0 * spread**2 * REACH * number_nats)
    moments = _moments(chain, first, last)
    line, line_ways = _lines(moments, chain, first, last)
    arc, arc_ways, bulge = _arcs(moments, chain, first, last, RISE * spread)
    cubic = np.where(chain.curve[first] == chain.curve[last - 1], 0.0, np.inf)
    cubic_ways = np.stack([chain.along[first], chain.along[last]], 1)
    ways = np.stack([line_ways, arc_ways, cubic_ways], 1)
    words = _words(chain, ways, first, last, spread)
    offers = _Offers(first, last, np.stack([line, arc, cubic], 1) * per_square + words, ways, bulge, {})
    parts = _cheapest(count, offers)
    ends = np.union1d([part.first for part in parts], np.flatnonzero(np.diff(chain.curve)) + 1)
    rows = np.flatnonzero(np.isin(first, ends) & np.isin(last, [*ends, count - 1]) & np.isinf(cubic))
    if not len(rows):
        return parts
    handles, square = joined(chain, first[rows], last[rows])
    start, end = handles[:, 0] - chain.points[first[rows]], chain.points[last[rows]] - handles[:, 1]
    ways[rows, CUBIC] = unit(np.stack([start, end], 1))
    words = _words(chain, ways[rows], first[rows], last[rows], spread)
    offers.prices[rows, CUBIC] = square * per_square + words[:, CUBIC]
    return _cheapest(count, offers._replace(handles=dict(zip(rows.tolist(), handles, strict=True))))


class _Offers(NamedTuple):
    """Parts between B pairs of points: prices [B, 3], directions [B, 3, 2, 2], bulges [B], and some handles [2, 2]."""

    first: Integers
    last: Integers
    prices: Floats
    ways: Floats
    bulge: Floats
    handles: dict[int, Floats]


def _words(chain: Chain, ways: Floats, first: Integers, last: Integers, spread: float) -> Floats:
    """Return the numbers that parts say [B, 3], with directions ``ways`` [B, 3, 2, 2], between points [B]."""
    saved, kinks = np.zeros((2, len(first), 3))
    reach = np.linalg.norm(chain.points[last] - chain.points[first], axis=1)
    smooth = np.minimum(SMOOTH_DEGREES + np.degrees(3.0 * spread / np.maximum(reach, 1e-6)), SMOOTH_DEGREES_MAX)
    for side, place in ((0, first), (1, last)):
        off = angle_between(ways[:, :, side], chain.along[place][:, None])
        is_free = chain.is_corner[place][:, None]
        saved += np.where(is_free | (off > smooth[:, None]), 0.0, 0.5)
        kinks += np.where(is_free | (off <= smooth[:, None]), 0.0, 0.5 * KINK)
    tilt = np.abs(ways[:, LINE, 0]).min(1)
    saved[:, LINE] = np.maximum(saved[:, LINE], tilt <= np.sin(np.radians(LEVEL_DEGREES)))
    found: Floats = WORD + np.array(NUMBERS) - saved + kinks
    return found


def joined(chain: Chain, first: Integers, last: Integers) -> tuple[Floats, Floats]:
    """Return the handles [B, 2, 2] of cubics along the chain between points, and their sums of squared distances."""
    share = (np.arange(JOINED_SAMPLES) + 0.5) / JOINED_SAMPLES
    length = chain.length_between(first, last)
    place = chain.reached[first][:, None] + share * length[:, None]
    points = np.stack([np.interp(place, chain.reached, chain.points[:, k]) for k in (0, 1)], 2)
    shared = np.interp(place, chain.reached, chain.shared_parameters)
    begin, end = (chain.shared_parameters[each][:, None] for each in (first, last))
    parameters = (shared - begin) / (end - begin)
    found = fit_cubics(chain.points[first], chain.points[last], points, parameters, CURVES.precise_plan)
    return found.handles, np.where(np.isnan(found.square), np.inf, found.square) * length


def numbers_of(parts: list[Part]) -> float:
    """Return the numbers that ``parts`` say."""
    return sum(NUMBERS[part.kind] + WORD for part in parts)


def _pairs(chain: Chain) -> tuple[Integers, Integers]:
    """Return the first and last points of all parts that pass no corner."""
    count = len(chain.points)
    first, last = np.triu_indices(count, 1)
    passed = np.concatenate([[0], np.cumsum(chain.is_corner)])
    own = passed[last] - passed[first + 1] == 0
    return first[own], last[own]


class _Moments(NamedTuple):
    """Sums over the points of each pair: of 1, x, y, x x, x y, y y, q, q x, q y and q q, with q = x x + y y."""

    sums: Floats
    center: Floats


def _moments(chain: Chain, first: Integers, last: Integers) -> _Moments:
    center = chain.middles.mean(0)
    x, y = (chain.middles - center).T
    q = x * x + y * y
    terms = np.stack([np.ones(len(x)), x, y, x * x, x * y, y * y, q, q * x, q * y, q * q])
    sums = np.concatenate([np.zeros((10, 1)), np.cumsum(terms * chain.lengths * chain.weights, 1)], 1)
    return _Moments(sums[:, last] - sums[:, first], center)


def _lines(moments: _Moments, chain: Chain, first: Integers, last: Integers) -> tuple[Floats, Floats]:
    """Return the sums of squared distances from the nearest lines [B], and their directions at both ends [B, 2, 2]."""
    n, x, y, xx, xy, yy = moments.sums[:6]
    a, b, c = xx - x * x / n, xy - x * y / n, yy - y * y / n
    root = np.hypot((a - c) / 2.0, b)
    angle = np.arctan2(b, (a - c) / 2.0) / 2.0
    way = np.stack([np.cos(angle), np.sin(angle)], 1)
    chord = chain.points[last] - chain.points[first]
    way *= np.where((way * chord).sum(1) < 0.0, -1.0, 1.0)[:, None]
    is_there = np.linalg.norm(chord, axis=1) >= (1.0 - LENGTH_ERROR) * chain.length_between(first, last)
    return np.where(is_there, np.maximum((a + c) / 2.0 - root, 0.0), np.inf), np.repeat(way[:, None], 2, 1)


def _arcs(
    moments: _Moments, chain: Chain, first: Integers, last: Integers, rise_min: float
) -> tuple[Floats, Floats, Floats]:
    """Return the sums of squared distances from the nearest arcs [B], their directions [B, 2, 2] and bulges [B].

    Arcs that rise by less than ``rise_min`` pixels over their chords are lines.
    """
    n, x, y, xx, xy, yy, q, qx, qy, qq = moments.sums
    a, b, c = xx - x * x / n, xy - x * y / n, yy - y * y / n
    u, v, w = qx - q * x / n, qy - q * y / n, qq - q * q / n
    determinant = a * c - b * b
    is_bent = determinant > 1e-9 * np.maximum(a + c, 1e-12) ** 2
    safe = np.where(is_bent, determinant, 1.0)
    cx, cy = (u * c - v * b) / safe / 2.0, (v * a - u * b) / safe / 2.0
    left = np.maximum(w - 2.0 * (cx * u + cy * v), 0.0)
    square = (q - 2.0 * (cx * x + cy * y)) / n + cx * cx + cy * cy
    center = np.stack([cx, cy], 1) + moments.center
    start, end = chain.points[first] - center, chain.points[last] - center
    along = chain.along[first]
    side = np.sign(start[:, 0] * along[:, 1] - start[:, 1] * along[:, 0])
    turn = np.arctan2(start[:, 0] * end[:, 1] - start[:, 1] * end[:, 0], (start * end).sum(1)) * side
    turn = np.where(turn < 0.0, turn + 2.0 * np.pi, turn)
    ways = unit(np.stack([start, end], 1)) * side[:, None, None]
    ways = np.stack([-ways[..., 1], ways[..., 0]], -1)
    is_bent &= (turn <= SWEEP_MAX) & (last - first >= 3) & (square > 0.0) & (side != 0.0)
    length = np.sqrt(np.maximum(square, 0.0)) * turn
    is_bent &= np.abs(length - chain.length_between(first, last)) <= LENGTH_ERROR * length
    is_bent &= np.sqrt(np.maximum(square, 0.0)) * (1.0 - np.cos(turn / 2.0)) >= rise_min
    distance = np.where(is_bent, left / (4.0 * np.maximum(square, 1e-9)), np.inf)
    return distance, ways, side * np.tan(np.minimum(turn, SWEEP_MAX) / 4.0)


def _cheapest(count: int, offers: _Offers) -> list[Part]:
    """Return the parts of the cheapest way from the first of ``count`` points to the last."""
    first, last, prices, ways, bulge, handles = offers
    kind = np.argmin(prices, 1)
    lowest = np.take_along_axis(prices, kind[:, None], 1)[:, 0]
    order = np.argsort(last, kind="stable")
    bounds = np.searchsorted(last[order], np.arange(count + 1))
    so_far, chosen = np.zeros(count), np.zeros(count, np.int64)
    for end in range(1, count):
        own = order[bounds[end] : bounds[end + 1]]
        total = so_far[first[own]] + lowest[own]
        best = int(np.argmin(total))
        so_far[end], chosen[end] = total[best], own[best]
    parts, at = list[Part](), count - 1
    while at > 0:
        row = int(chosen[at])
        found = int(kind[row])
        joined_handles = handles.get(row) if found == CUBIC else None
        parts.append(Part(found, int(first[row]), at, ways[row, found], float(bulge[row]), joined_handles))
        at = int(first[row])
    return parts[::-1]


def is_smooth_joint(before: Part, after: Part, spread: float, lengths: tuple[float, float]) -> bool:
    """Return whether two parts that meet away from a corner of the chain go on in one direction."""
    allowed = SMOOTH_DEGREES + float(np.degrees(3.0 * spread / max(min(lengths), 1e-6)))
    turn = float(angle_between(before.ways[1], after.ways[0]))
    both_lines = before.kind == LINE and after.kind == LINE
    return not both_lines and turn <= min(2.0 * allowed, 2.0 * SMOOTH_DEGREES_MAX)
