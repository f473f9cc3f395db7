"""Choose the parts of a chain by price: one exact search over all places where a part may begin and end.

The price of a part is the numbers that it says, and how far it misses the chain. A number is worth some nats. What is
said already is free: a smooth joint says one number less, and so does a line that is level or upright.
"""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from warpvec.arrays import Floats, Integers, counted, cross, dot, lengths_of, turn_between
from warpvec.flat import price
from warpvec.flat.chains.chain import CURVE_POINTS_MIN, Chain, angle_between
from warpvec.flat.chains.parts import ARC, CUBIC, LINE, quarters_of, unit
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
"""Numbers that a joint costs which is neither smooth nor a corner of the chain. Along a traced outline, whose true
corners are found before, it costs as many as the short cubic that would round it."""

REACH = 4.0
"""Length in pixels over which the places of an outline depend on each other: they are those of fitted curves."""

SWEEP_MAX = np.radians(330.0)
"""Most that an arc turns. Whole circles are forms."""


RISE = 3.0
"""Least rise of an arc over its chord, in deviations of places: with less it may be a line that is off at its ends."""

JOINED_SAMPLES = 16
"""Points of the chain to which a cubic over several curves is fitted."""

SAVED_MAX = 1.0
"""Most numbers that a part saves: half of one at each smooth joint, or one if it is a level line."""

PAIRS_MAX = 400_000
"""Most pairs of points of a chain that are looked at: parts of longer chains are shorter, but reach along a whole curve
and two of the fewest points."""

TRACED_ENDS = 4
"""Along a traced outline, cubics over several curves may begin at one in so many points, beside corners and the ends
of parts: their places are solved for afterwards. All points make 16 times as many pairs."""

ROUNDING = 1e-6
"""Numbers by which two sums of equal prices may differ."""

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
    and to where its parts end and where the curves do, or some of these.

    Args:
        chain: the chain of K points.
        spread: standard deviation in pixels of its places.
        number_nats: nats of a number.
    """
    first, last = _pairs(chain)
    if not len(first):
        return []
    offers = _Offers.of(chain, first, last, spread, 1.0 / (2.0 * spread**2 * REACH * number_nats))
    by_curves, is_own = _numbers_by_curves(chain, first, last), chain.curve[first] == chain.curve[last - 1]
    offers.prices[CUBIC, is_own] = by_curves[is_own]
    moments = _moments(chain, first, last)
    for kind, find in ((LINE, _lines), (ARC, _arcs)):
        # What costs more than cubics along each curve is never the cheapest.
        room = by_curves + ROUNDING - (NUMBERS[kind] + WORD - SAVED_MAX)
        find(offers, moments, room / offers.per_square)
    parts = _cheapest(offers)
    ends = [0, *(part.last for part in parts)]
    more = np.arange(0, len(chain.points), TRACED_ENDS) if chain.is_traced else np.flatnonzero(np.diff(chain.curve)) + 1
    is_end = chain.is_corner.copy() if chain.is_traced else np.zeros(len(chain.points), bool)
    is_end[ends] = is_end[more] = True
    # No cubic is cheaper than the numbers that it says.
    is_open = offers.prices[[LINE, ARC]].min(0) > NUMBERS[CUBIC] + WORD - SAVED_MAX
    rows = np.flatnonzero(is_open & is_end[first] & is_end[last] & ~is_own)
    if not len(rows):
        return parts
    handles, ways, squares = _joined(chain, first[rows], last[rows])
    squares += _turned_squares(chain, first[rows], last[rows], ways, spread)
    offers.add(CUBIC, rows, squares, ways)
    offers.handles.update(zip(rows.tolist(), handles, strict=True))
    return _cheapest(offers)


class _Offers(NamedTuple):
    """Parts of a chain between B pairs of points.

    Attributes:
        chain: the chain.
        first, last: the pairs [B].
        spread: standard deviation in pixels of its places.
        per_square: numbers that a squared distance costs.
        prices: numbers that a part of each kind costs [3, B]; infinity for none.
        ways: its unit directions at both ends [3, B, 2, 2].
        bulge: those of arcs [B].
        handles: some of cubics along several curves [2, 2], by their pairs.
    """

    chain: Chain
    first: Integers
    last: Integers
    spread: float
    per_square: float
    prices: Floats
    ways: Floats
    bulge: Floats
    handles: dict[int, Floats]

    @staticmethod
    def of(chain: Chain, first: Integers, last: Integers, spread: float, per_square: float) -> _Offers:
        """Return no parts yet between the pairs ``first`` and ``last`` [B]."""
        count = len(first)
        prices, ways = np.full((3, count), np.inf), np.zeros((3, count, 2, 2))
        return _Offers(chain, first, last, spread, per_square, prices, ways, np.zeros(count), {})

    def add(self, kind: int, rows: Integers, squares: Floats, ways: Floats) -> None:
        """Add parts of one ``kind`` for the pairs ``rows`` [K]: sums of ``squares`` [K] and directions [K, 2, 2].

        A traced outline is fitted next. A fit knows no arcs, so they count as the cubics that draw them.
        """
        words = _words(self.chain, kind, ways, self.first[rows], self.last[rows], self.spread)
        if kind == ARC and self.chain.is_traced:
            words += NUMBERS[CUBIC] * quarters_of(self.bulge[rows]) - NUMBERS[ARC]
        self.prices[kind, rows] = squares * self.per_square + words
        self.ways[kind, rows] = ways


def _numbers_by_curves(chain: Chain, first: Integers, last: Integers) -> Floats:
    """Return the numbers of cubics along each curve of a chain between points [B]."""
    is_smooth = angle_between(chain.along, chain.along) <= SMOOTH_DEGREES  # a cusp has no direction
    joint = np.where(chain.is_corner, 0.0, np.where(is_smooth, -0.5, 0.5 * KINK))
    begins = np.append(True, np.diff(chain.curve) > 0)
    up_to = np.cumsum(np.where(begins, WORD + NUMBERS[CUBIC] + 2.0 * joint[:-1], 0.0))
    found: Floats = WORD + NUMBERS[CUBIC] + joint[first] + joint[last] + up_to[last - 1] - up_to[first]
    return found


def _words(chain: Chain, kind: int, ways: Floats, first: Integers, last: Integers, spread: float) -> Floats:
    """Return the numbers that parts of one ``kind`` say [B], with directions ``ways`` [B, 2, 2], between points [B]."""
    saved, kinks = np.zeros((2, len(first)))
    reach = lengths_of(chain.points[last] - chain.points[first])
    smooth = np.minimum(SMOOTH_DEGREES + np.degrees(3.0 * spread / np.maximum(reach, 1e-6)), SMOOTH_DEGREES_MAX)
    for side, place in ((0, first), (1, last)):
        off = angle_between(ways[:, side], chain.along[place])
        is_free = chain.is_corner[place]
        saved += np.where(is_free | (off > smooth), 0.0, 0.5)
        kinks += np.where(is_free | (off <= smooth), 0.0, 0.5 * (NUMBERS[CUBIC] + WORD if chain.is_traced else KINK))
    if kind == LINE:
        tilt = np.minimum(*np.abs(ways[:, 0]).T)
        saved = np.maximum(saved, tilt <= np.sin(np.radians(LEVEL_DEGREES)))
    found: Floats = WORD + NUMBERS[kind] - saved + kinks
    return found


def _joined(chain: Chain, first: Integers, last: Integers) -> tuple[Floats, Floats, Floats]:
    """Return cubics along the chain between points: handles and directions [B, 2, 2], sums of squared distances [B]."""
    share = (np.arange(JOINED_SAMPLES) + 0.5) / JOINED_SAMPLES
    length = chain.length_between(first, last)
    place = chain.reached[first][:, None] + share * length[:, None]
    points = np.stack([np.interp(place, chain.reached, chain.points[:, k]) for k in (0, 1)], 2)
    shared = np.interp(place, chain.reached, chain.shared_parameters)
    begin, end = (chain.shared_parameters[each][:, None] for each in (first, last))
    parameters = (shared - begin) / (end - begin)
    found = fit_cubics(chain.points[first], chain.points[last], points, parameters)
    ways = unit(np.stack([found.handles[:, 0] - chain.points[first], chain.points[last] - found.handles[:, 1]], 1))
    return found.handles, ways, np.where(np.isnan(found.square), np.inf, found.square) * length


def _turned_squares(chain: Chain, first: Integers, last: Integers, ways: Floats, spread: float) -> Floats:
    """Return the squared distances [B] of cubics after a turn from their ``ways`` [B, 2, 2] to directions of the chain.

    Corners cost nothing, and neither do turns within the ``spread`` of places. A turn costs at most what an arc costs
    that keeps both directions.
    """
    length, ends = chain.length_between(first, last), np.stack([first, last], 1)
    off = np.radians(angle_between(ways, chain.along[ends])) - 3.0 * spread / REACH
    off = np.where(chain.is_corner[ends], 0.0, np.maximum(off, 0.0))
    # A handle that turns by 1 moves its cubic by the length times t (1 - t)^2.
    turned = (off**2).sum(1) * length**2 / 105.0
    found: Floats = np.minimum(turned, _bend_square(chain.turn_along(first, last), length)) * length
    return found


def _bend_square(turn: Floats, length: Floats) -> Floats:
    """Return the mean squared distance from arcs that ``turn`` [B] radians to cubics with their directions at the ends.

    A cubic without neighbours comes nearer, by other directions. The largest distance over the radius is that of
    Goldapp (1991); along the arc it comes and goes twice, about as a squared sine.
    """
    quarter = np.minimum(np.abs(turn), 2.0 * np.pi - 1e-3) / 4.0
    off = 2.0 / 27.0 * np.sin(quarter) ** 6 / np.cos(quarter) ** 2 * length / np.maximum(np.abs(turn), 1e-9)
    found: Floats = 3.0 / 8.0 * off**2
    return found


def numbers_of(parts: list[Part]) -> float:
    """Return the numbers that ``parts`` say."""
    return sum(NUMBERS[part.kind] + WORD for part in parts)


def _pairs(chain: Chain) -> tuple[Integers, Integers]:
    """Return the first and last points of all parts that pass no corner, in the order of the first."""
    begin, end = np.arange(len(chain.points) - 1), len(chain.points) - 1
    corners = np.append(np.flatnonzero(chain.is_corner[:-1] & (not chain.is_traced)), end)
    counts = corners[np.searchsorted(corners, begin + 1)] - begin
    own = np.searchsorted(chain.curve, chain.curve, "right") - begin  # to the end of the curve
    counts = np.minimum(counts, np.maximum(own, max(PAIRS_MAX // len(chain.points), 2 * CURVE_POINTS_MIN)))
    first = np.repeat(begin, counts)
    return first, first + 1 + counted(counts)


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
    found = sums.take(last, 1) - sums.take(first, 1)
    # What has no weight has no nearest curve.
    found[0] = np.where(found[0] > 0.0, found[0], np.nan)
    return _Moments(found, center)


def _lines(offers: _Offers, moments: _Moments, most: Floats) -> None:
    """Add the nearest lines whose sums of squared distances are ``most`` [B] or less."""
    n, x, y, xx, xy, yy = moments.sums[:6]
    a, b, c = xx - x * x / n, xy - x * y / n, yy - y * y / n
    root = np.hypot((a - c) / 2.0, b)
    squares = np.maximum((a + c) / 2.0 - root, 0.0)
    rows = np.flatnonzero(squares <= most)
    chain, first, last = offers.chain, offers.first[rows], offers.last[rows]
    chord = chain.points[last] - chain.points[first]
    is_there = lengths_of(chord) >= (1.0 - LENGTH_ERROR) * chain.length_between(first, last)
    rows, chord = rows[is_there], chord[is_there]
    angle = np.arctan2(b[rows], (a[rows] - c[rows]) / 2.0) / 2.0
    way = np.stack([np.cos(angle), np.sin(angle)], 1)
    way *= np.where(dot(way, chord) < 0.0, -1.0, 1.0)[:, None]
    offers.add(LINE, rows, squares[rows], np.repeat(way[:, None], 2, 1))


def _arcs(offers: _Offers, moments: _Moments, most: Floats) -> None:
    """Add the nearest arcs whose sums of squared distances are ``most`` [B] or less.

    Arcs that rise by less than ``RISE`` over their chords are lines.
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
    squares = left / (4.0 * np.maximum(square, 1e-9))
    is_bent &= (offers.last - offers.first >= 3) & (square > 0.0) & (squares <= most)
    rows = np.flatnonzero(is_bent)
    radius, center = np.sqrt(square[rows]), np.stack([cx[rows], cy[rows]], 1) + moments.center
    chain, first, last = offers.chain, offers.first[rows], offers.last[rows]
    start, end = chain.points[first] - center, chain.points[last] - center
    side = np.sign(cross(start, chain.along[first]))
    turn = turn_between(start, end) * side
    turn = np.where(turn < 0.0, turn + 2.0 * np.pi, turn)
    length = radius * turn
    is_there = (turn <= SWEEP_MAX) & (side != 0.0)
    is_there &= np.abs(length - chain.length_between(first, last)) <= LENGTH_ERROR * length
    is_there &= radius * (1.0 - np.cos(turn / 2.0)) >= RISE * offers.spread
    ways = unit(np.stack([start, end], 1)) * side[:, None, None]
    ways = np.stack([-ways[..., 1], ways[..., 0]], -1)
    offers.bulge[rows] = side * np.tan(np.minimum(turn, SWEEP_MAX) / 4.0)
    offers.add(ARC, rows[is_there], squares[rows[is_there]], ways[is_there])


def _cheapest(offers: _Offers) -> list[Part]:
    """Return the parts of the cheapest way from the first point of the chain to the last.

    Two lines that meet away from a corner have a kink, though each may go on smoothly into something else.
    """
    chain, first, prices = offers.chain, offers.first, offers.prices
    count = len(chain.points)
    begins = np.searchsorted(first, np.arange(count))
    by_end = np.stack([prices[LINE], prices[[ARC, CUBIC]].min(0)])  # prices of parts that are a line, or are none
    so_far, chosen, after = np.full((2, count), np.inf), np.zeros((2, count), np.int64), np.zeros((2, count), np.int64)
    so_far[1, 0] = 0.0
    for begin, (start, stop) in enumerate(pairwise(begins.tolist())):
        reached = slice(begin + 1, begin + 1 + stop - start)
        before = so_far[:, begin] + [[0.0 if chain.is_corner[begin] else KINK + SAVED_MAX, 0.0], [0.0, 0.0]]
        for kind, previous in enumerate(before.argmin(1).tolist()):
            total = before[kind, previous] + by_end[kind, start:stop]
            is_less = total < so_far[kind, reached]
            so_far[kind, reached][is_less], chosen[kind, reached][is_less] = total[is_less], begin
            after[kind, reached][is_less] = previous
    parts, at, end = list[Part](), count - 1, int(so_far[:, -1].argmin())
    while at > 0:
        begin = int(chosen[end, at])
        row = int(begins[begin]) + at - begin - 1
        kind = LINE if end == 0 else int(1 + np.argmin(prices[1:, row]))
        handles = offers.handles.get(row) if kind == CUBIC else None
        ways = chain.along[[begin, at]] if kind == CUBIC and handles is None else offers.ways[kind, row]
        parts.append(Part(kind, begin, at, ways, float(offers.bulge[row]), handles))
        at, end = begin, int(after[end, at])
    return parts[::-1]


def is_smooth_joint(before: Part, after: Part, spread: float, lengths: tuple[float, float]) -> bool:
    """Return whether two parts that meet away from a corner of the chain go on in one direction."""
    allowed = SMOOTH_DEGREES + float(np.degrees(3.0 * spread / max(min(lengths), 1e-6)))
    turn = float(angle_between(before.ways[1], after.ways[0]))
    both_lines = before.kind == LINE and after.kind == LINE
    return not both_lines and turn <= min(2.0 * allowed, 2.0 * SMOOTH_DEGREES_MAX)
