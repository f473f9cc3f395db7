"""Choose the parts of a chain by price: one exact search over all places where a part may begin and end.

The price of a part is the numbers that it says, and how far it misses the chain. A number is worth some nats. What is
said already is free: a smooth joint says one number less, and so does a line that is level or upright.
"""

from __future__ import annotations

from itertools import islice
from typing import Any, NamedTuple

import numpy as np

from warpvec.arrays import Floats, Integers, counted, interpolated
from warpvec.flat import price
from warpvec.flat.chains.chain import CURVE_POINTS_MIN, Chain, angle_between
from warpvec.flat.chains.parts import ARC, CUBIC, LINE, unit
from warpvec.flat.curves.cubic_fitting import fit_cubics
from warpvec.kernels.part_choice import SUM_COUNT, Points, Rules, sums10
from warpvec.polish.machine import machine_of_thread, on_host, vectors_on_host

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
    search = _Search(chain, first, last, _rules(chain, spread, number_nats))
    parts = search.cheapest()
    ends = [0, *(part.last for part in parts)]
    more = np.arange(0, len(chain.points), TRACED_ENDS) if chain.is_traced else np.flatnonzero(np.diff(chain.curve)) + 1
    is_end = chain.is_corner.copy() if chain.is_traced else np.zeros(len(chain.points), bool)
    is_end[ends] = is_end[more] = True
    # No cubic is cheaper than the numbers that it says.
    is_open = search.prices[[LINE, ARC]].min(0) > NUMBERS[CUBIC] + WORD - SAVED_MAX
    is_own = chain.curve[first] == chain.curve[last - 1]
    pairs = np.flatnonzero(is_open & is_end[first] & is_end[last] & ~is_own)
    if not len(pairs):
        return parts
    handles, ways, squares = _joined(chain, first[pairs], last[pairs])
    squares += _turned_squares(chain, first[pairs], last[pairs], ways, spread)
    search.add_cubics(pairs, handles, ways, squares)
    return search.cheapest()


def _rules(chain: Chain, spread: float, number_nats: float) -> Any:
    """Return what parts of ``chain`` cost, as kernels take it; see `chosen_parts`."""
    rules = Rules()
    rules.spread, rules.per_square = spread, 1.0 / (2.0 * spread**2 * REACH * number_nats)
    rules.word, rules.saved_max, rules.rounding = WORD, SAVED_MAX, ROUNDING
    rules.line_numbers, rules.arc_numbers, rules.cubic_numbers = NUMBERS
    # A traced outline is fitted next, and a fit knows no arcs.
    rules.is_fitted = chain.is_traced
    rules.kink = 0.5 * (NUMBERS[CUBIC] + WORD if chain.is_traced else KINK)
    rules.line_kink = KINK + SAVED_MAX
    rules.smooth_angle, rules.smooth_angle_max = np.radians([SMOOTH_DEGREES, SMOOTH_DEGREES_MAX]).tolist()
    rules.level_sine = np.sin(np.radians(LEVEL_DEGREES))
    rules.length_error, rules.sweep_max, rules.rise = LENGTH_ERROR, SWEEP_MAX, RISE * spread
    return rules


class _Search:
    """The host side of ``kernels/part_choice.py``: prices of the parts between B pairs of points, and the cheapest way.

    Attributes:
        prices: numbers that a part of each kind costs [3, B]; infinity for what is never the cheapest.
    """

    def __init__(self, chain: Chain, first: Integers, last: Integers, rules: Any) -> None:
        """Price the parts between ``first`` and ``last`` [B] by ``rules``, but for cubics over several curves."""
        self._machine = machine_of_thread()  # starts Warp, which makes the arrays of structures
        self._chain, self._first, self._last, self._rules = chain, first, last, rules
        self._points = _points_of(chain, first)
        self._cubics: dict[int, tuple[Floats, Floats]] = {}
        self.prices = np.empty((len(NUMBERS), len(first)))
        curve, (joint, passed) = chain.curve.astype(np.int32), _numbers_by_curves(chain)
        self._run("price_parts", [on_host(each) for each in (curve, joint, passed, self.prices)])

    def add_cubics(self, pairs: Integers, handles: Floats, ways: Floats, squares: Floats) -> None:
        """Add cubics over several curves for some ``pairs`` [R].

        They have ``handles`` and unit directions ``ways`` [R, 2, 2], and sums of squared distances ``squares`` [R].
        """
        numbers = np.stack([pairs, self._first[pairs], self._last[pairs]], 1).astype(np.int32)
        self._run("price_cubics", [on_host(numbers), on_host(squares), vectors_on_host(ways), on_host(self.prices)])
        self._cubics = dict(zip(pairs.tolist(), zip(handles, ways, strict=True), strict=True))

    def cheapest(self) -> list[Part]:
        """Return the parts of the cheapest way from the first point to the last."""
        size = len(self._chain.points)
        costs, before, count = np.empty((2, size)), np.empty((2, 2, size), np.int32), np.zeros(1, np.int32)
        numbers, ways, bulges = np.empty((size, 4), np.int32), np.zeros((size, 2, 2)), np.zeros(size)
        arrays = [on_host(each) for each in (self.prices, costs, *before, count, numbers, bulges)]
        self._run("choose_parts", [*arrays, vectors_on_host(ways)])
        chosen = zip(numbers.tolist(), ways, bulges.tolist(), strict=True)
        return [self._part(*each) for each in islice(chosen, int(count[0]))][::-1]

    def _part(self, numbers: list[int], ways: Floats, bulge: float) -> Part:
        kind, first, last, pair = numbers
        if kind != CUBIC:
            return Part(kind, first, last, ways, bulge)
        handles, ways = self._cubics.get(pair, (None, self._chain.along[[first, last]]))
        return Part(kind, first, last, ways, bulge, handles)

    def _run(self, kernel: str, arguments: list[Any]) -> None:
        self._machine.run(kernel, [self._rules, self._points, *arguments])


def _points_of(chain: Chain, first: Integers) -> Any:
    """Return the points of ``chain`` as kernels take them, with pairs that begin at ``first`` [B]."""
    center, points = chain.middles.mean(0), Points()
    x, y = (chain.middles - center).T
    q = x * x + y * y
    terms = np.stack([np.ones(len(x)), x, y, x * x, x * y, y * y, q, q * x, q * y, q * q], 1)
    sums = np.zeros((len(chain.points), SUM_COUNT))
    np.cumsum(terms * (chain.lengths * chain.weights)[:, None], 0, out=sums[1:])
    begins = np.searchsorted(first, np.arange(len(sums))).astype(np.int32)
    points.place, points.along = (vectors_on_host(each, whole=True) for each in (chain.points - center, chain.along))
    points.sums = on_host(sums, sums10, whole=True)
    rest = chain.is_corner.astype(np.int32), chain.reached, begins
    points.is_corner, points.reached, points.begins = (on_host(each, whole=True) for each in rest)
    return points


def _numbers_by_curves(chain: Chain) -> tuple[Floats, Floats]:
    """Return what cubics along curves cost at points [K], and a running sum [K - 1] of what they cost up to each.

    A cubic along each curve between two points costs, beside a word and its own numbers, what its ends do, and the
    difference of the running sums.
    """
    is_smooth = angle_between(chain.along, chain.along) <= SMOOTH_DEGREES  # a cusp has no direction
    joint = np.where(chain.is_corner, 0.0, np.where(is_smooth, -0.5, 0.5 * KINK))
    begins = np.append(True, np.diff(chain.curve) > 0)
    return joint, np.cumsum(np.where(begins, WORD + NUMBERS[CUBIC] + 2.0 * joint[:-1], 0.0))


def _joined(chain: Chain, first: Integers, last: Integers) -> tuple[Floats, Floats, Floats]:
    """Return cubics along the chain between points: handles and directions [B, 2, 2], sums of squared distances [B]."""
    share = (np.arange(JOINED_SAMPLES) + 0.5) / JOINED_SAMPLES
    length = chain.length_between(first, last)
    place = chain.reached[first][:, None] + share * length[:, None]
    points = interpolated(place, chain.reached, chain.points)
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


def is_smooth_joint(before: Part, after: Part, spread: float, lengths: tuple[float, float]) -> bool:
    """Return whether two parts that meet away from a corner of the chain go on in one direction."""
    allowed = SMOOTH_DEGREES + float(np.degrees(3.0 * spread / max(min(lengths), 1e-6)))
    turn = float(angle_between(before.ways[1], after.ways[0]))
    both_lines = before.kind == LINE and after.kind == LINE
    return not both_lines and turn <= min(2.0 * allowed, 2.0 * SMOOTH_DEGREES_MAX)
