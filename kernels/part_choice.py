"""The cheapest parts of a chain of points: lines, arcs and cubics, each from one of the points to a later one.

``warpvec/flat/chains/choice.py`` says what parts cost. Sums over the points of a part are differences of running sums.
One work item does all, pair by pair and then point by point.
"""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels.lanes import bundle, unit
from warpvec.kernels.making import made_once
from warpvec.kernels.vectors import cross, unit_of, vec2

real = wp.float64

SUM_COUNT = 10
"""Sums over points: of 1, x, y, x x, x y, y y, q, q x, q y and q q, with q = x x + y y."""

sums10 = wp.types.vector(SUM_COUNT, dtype=wp.float64)

LINE, ARC, CUBIC = 0, 1, 2
"""The kinds of parts."""

SAME_QUARTER = 1e-3
"""Quarters of a turn that count as none where an arc is drawn by a cubic for each."""


@wp.struct
class Rules:
    """What parts cost, in numbers."""

    spread: real  # standard deviation of places in pixels
    per_square: real  # numbers that a squared distance costs
    word: real  # a part costs that beside the numbers of its kind
    line_numbers: real
    arc_numbers: real
    cubic_numbers: real
    is_fitted: int  # whether arcs count as the cubics that draw them
    saved_max: real  # most that a part saves
    kink: real  # cost of an end that is neither smooth nor a corner
    line_kink: real  # cost where two lines meet without a corner
    smooth_angle: real  # radians up to which an end is smooth, and at most, for short parts
    smooth_angle_max: real
    level_sine: real  # sine of the angle up to which a line is level or upright
    length_error: real  # largest share by which the length of a part may differ
    sweep_max: real  # most radians that an arc turns
    rise: real  # least rise of an arc over its chord, in pixels
    rounding: real  # numbers by which two sums of equal prices may differ


@wp.struct
class Points:
    """The points of a chain, from the mean of their places."""

    place: wp.array(dtype=vec2)  # [K] px
    along: wp.array(dtype=vec2)  # [K] unit directions
    is_corner: wp.array(dtype=int)  # [K] 0 or 1
    reached: wp.array(dtype=real)  # [K] length of the chain up to each
    sums: wp.array(dtype=sums10)  # [K] running sums
    begins: wp.array(dtype=int)  # [K] the first pair from each point on; each of the next ends one point later


@made_once
def make_kernels() -> SimpleNamespace:
    """Return ``price_parts``, ``price_cubics`` and ``choose_parts``."""
    module = unit("part_choice")
    zero, half, one, two, three, four = (wp.constant(real(value)) for value in (0.0, 0.5, 1.0, 2.0, 3.0, 4.0))
    least = wp.constant(real(0.0))  # a bound; a sum that begins with the constant ``zero`` is written over it
    tiny = wp.constant(real(1e-9))  # what is divided by is at least that
    rounding = wp.constant(real(1e-12))  # share of running sums by which they may be off
    flat = wp.constant(real(1e-9))  # share of the squared spread of points below which they lie on a line
    whole_turn, quarter_turn = wp.constant(real(2.0 * wp.pi)), wp.constant(real(0.5 * wp.pi))
    same = wp.constant(real(SAME_QUARTER))
    infinity = wp.constant(real(wp.inf))
    line, arc, cubic = wp.constant(LINE), wp.constant(ARC), wp.constant(CUBIC)

    @wp.struct
    class Found:
        """The line or arc that is nearest to the chain between two points."""

        is_there: int
        square: real  # sum of squared distances
        first_way: vec2
        last_way: vec2
        bulge: real

    @wp.func
    def nearest_line(rules: Rules, at: Points, first: int, last: int, square_max: real):
        """Return the nearest line, if its squares are at most ``square_max``."""
        found = Found()
        found.is_there = int(0)
        s = at.sums[last] - at.sums[first]
        if s[0] <= least:
            return found
        n = one / s[0]
        a, b, c = s[3] - n * s[1] * s[1], s[4] - n * s[1] * s[2], s[5] - n * s[2] * s[2]
        difference = half * (a - c)
        found.square = wp.max(half * (a + c) - wp.sqrt(difference * difference + b * b), least)
        chord = at.place[last] - at.place[first]
        length = at.reached[last] - at.reached[first]
        if found.square <= square_max and wp.length(chord) >= (one - rules.length_error) * length:
            angle = half * wp.atan2(b, difference)
            way = vec2(wp.cos(angle), wp.sin(angle))
            total = at.sums[last]
            if a + c <= rounding * (one + total[3] + total[5]):
                way = vec2(zero, zero)  # one place has no direction, so nothing goes on in it
            way = wp.where(wp.dot(way, chord) < least, -way, way)
            found.first_way = way
            found.last_way = way
            found.is_there = int(1)
        return found

    @wp.func
    def nearest_arc(rules: Rules, at: Points, first: int, last: int, square_max: real):
        """Return the nearest arc by its algebraic distance, if its squares are at most ``square_max``."""
        found = Found()
        found.is_there = int(0)
        s = at.sums[last] - at.sums[first]
        if s[0] <= least or last - first < 3:
            return found
        n = one / s[0]
        a, b, c = s[3] - n * s[1] * s[1], s[4] - n * s[1] * s[2], s[5] - n * s[2] * s[2]
        u, v, w = s[7] - n * s[6] * s[1], s[8] - n * s[6] * s[2], s[9] - n * s[6] * s[6]
        determinant = a * c - b * b
        extent = wp.max(a + c, wp.static(real(1e-12)))
        if determinant <= flat * extent * extent:
            return found
        center = vec2(u * c - v * b, v * a - u * b) / (two * determinant)
        left = wp.max(w - two * (center[0] * u + center[1] * v), least)
        radius_square = n * (s[6] - two * (center[0] * s[1] + center[1] * s[2])) + wp.dot(center, center)
        found.square = left / (four * wp.max(radius_square, tiny))
        if radius_square <= least or found.square > square_max:
            return found
        start, end = at.place[first] - center, at.place[last] - center
        leaning = cross(start, at.along[first])
        if leaning == least:
            return found
        side = wp.sign(leaning)
        turn = side * wp.atan2(cross(start, end), wp.dot(start, end))
        turn = wp.where(turn < least, turn + whole_turn, turn)
        radius = wp.sqrt(radius_square)
        length = radius * turn
        is_long = wp.abs(length - (at.reached[last] - at.reached[first])) <= rules.length_error * length
        if turn <= rules.sweep_max and is_long and radius * (one - wp.cos(half * turn)) >= rules.rise:
            start, end = side * unit_of(start, tiny), side * unit_of(end, tiny)
            found.first_way = vec2(-start[1], start[0])
            found.last_way = vec2(-end[1], end[0])
            found.bulge = side * wp.tan(turn / four)
            found.is_there = int(1)
        return found

    @wp.func
    def end_words(rules: Rules, at: Points, place: int, way: vec2, cosine: real):
        """Return the numbers that a part with this unit direction ``way`` saves at a point, or costs there, below 0."""
        if at.is_corner[place] != 0:
            return real(zero)
        return wp.where(wp.dot(way, at.along[place]) >= cosine, half, -rules.kink)

    @wp.func
    def ends_words(rules: Rules, at: Points, first: int, last: int, first_way: vec2, last_way: vec2, is_level: bool):
        """Return the numbers that both ends of a part cost; a level line saves as many as two smooth ends."""
        reach = wp.max(wp.length(at.place[last] - at.place[first]), wp.static(real(1e-6)))
        cosine = wp.cos(wp.min(rules.smooth_angle + three * rules.spread / reach, rules.smooth_angle_max))
        begin, end = end_words(rules, at, first, first_way, cosine), end_words(rules, at, last, last_way, cosine)
        saved = wp.max(begin, least) + wp.max(end, least)
        saved = wp.where(is_level, wp.max(saved, one), saved)
        return -saved - wp.min(begin, least) - wp.min(end, least)

    @wp.func
    def quarters(bulge: real):
        """Return how many quarters of a turn an arc begins."""
        return wp.max(wp.ceil(four * wp.atan(wp.abs(bulge)) / quarter_turn - same), one)

    @wp.kernel(module=module)
    def price_parts(
        first: int,
        rules: Rules,
        at: Points,
        curve: wp.array(dtype=int),  # [K - 1] the curve between each point and the next
        joint: wp.array(dtype=real),  # [K] what the end of a cubic along a curve costs at each point
        passed: wp.array(dtype=real),  # [K - 1] running sum of what whole curves cost
        # outputs
        prices: wp.array2d(dtype=real),  # [3, B] of each kind
    ):
        """Price the parts between all pairs of points; infinity for what is never the cheapest."""
        for begin in range(at.place.shape[0] - 1):
            for pair in range(at.begins[begin], at.begins[begin + 1]):
                end = begin + 1 + pair - at.begins[begin]
                by_curves = (
                    rules.word + rules.cubic_numbers + joint[begin] + joint[end] + passed[end - 1] - passed[begin]
                )
                prices[cubic, pair] = wp.where(curve[begin] == curve[end - 1], by_curves, infinity)
                prices[line, pair] = infinity
                prices[arc, pair] = infinity
                # What costs more than cubics along each curve is never the cheapest.
                room = by_curves + rules.rounding + rules.saved_max - rules.word
                found = nearest_line(rules, at, begin, end, (room - rules.line_numbers) / rules.per_square)
                if found.is_there != 0:
                    way = found.first_way
                    is_level = wp.min(wp.abs(way[0]), wp.abs(way[1])) <= rules.level_sine and wp.length(way) > half
                    words = ends_words(rules, at, begin, end, way, way, is_level)
                    prices[line, pair] = found.square * rules.per_square + rules.word + rules.line_numbers + words
                found = nearest_arc(rules, at, begin, end, (room - rules.arc_numbers) / rules.per_square)
                if found.is_there != 0:
                    words = ends_words(rules, at, begin, end, found.first_way, found.last_way, False)
                    drawn = quarters(found.bulge) * rules.cubic_numbers
                    words += wp.where(rules.is_fitted != 0, drawn, rules.arc_numbers)
                    prices[arc, pair] = found.square * rules.per_square + rules.word + words

    @wp.kernel(module=module)
    def price_cubics(
        first: int,
        rules: Rules,
        at: Points,
        pairs: wp.array2d(dtype=int),  # [R, 3] each pair, and its points
        squares: wp.array(dtype=real),  # [R] sums of squared distances
        ways: wp.array2d(dtype=vec2),  # [R, 2] unit directions of the cubics at the points
        # outputs
        prices: wp.array2d(dtype=real),  # [3, B]
    ):
        """Price cubics over several curves between some pairs of points."""
        for row in range(pairs.shape[0]):
            words = ends_words(rules, at, pairs[row, 1], pairs[row, 2], ways[row, 0], ways[row, 1], False)
            prices[cubic, pairs[row, 0]] = squares[row] * rules.per_square + rules.word + rules.cubic_numbers + words

    @wp.kernel(module=module)
    def choose_parts(
        first: int,
        rules: Rules,
        at: Points,
        prices: wp.array2d(dtype=real),  # [3, B]
        # buffers, each by whether the part that ends at a point is a line (0) or bent (1)
        costs: wp.array2d(dtype=real),  # [2, K] of the cheapest way to each point
        before: wp.array2d(dtype=int),  # [2, K] where its last part begins
        kind_before: wp.array2d(dtype=int),  # [2, K] whether the part before that is bent
        # outputs
        count: wp.array(dtype=int),  # [1] P
        numbers: wp.array2d(dtype=int),  # [K, 4] kind, first and last point, and pair of each part, from the last one
        bulges: wp.array(dtype=real),  # [K] that of an arc
        ways: wp.array2d(dtype=vec2),  # [K, 2] its unit directions at its ends, for lines and arcs
    ):
        """Find the cheapest way from the first point to the last.

        Two lines that meet away from a corner have a kink, though each may go on smoothly into something else.
        """
        point_count = at.place.shape[0]
        for point in range(point_count):
            for kind in range(2):
                costs[kind, point] = wp.where(point == 0 and kind == 1, zero, infinity)
                # Of a chain that has no way, because its places are no numbers, each point is a node.
                before[kind, point] = wp.max(point - 1, 0)
                kind_before[kind, point] = 1
        for begin in range(point_count - 1):
            kink = wp.where(at.is_corner[begin] != 0, zero, rules.line_kink)
            line_from = wp.where(costs[1, begin] < costs[0, begin] + kink, 1, 0)
            bent_from = wp.where(costs[1, begin] < costs[0, begin], 1, 0)
            line_cost = wp.min(costs[0, begin] + kink, costs[1, begin])
            bent_cost = wp.min(costs[0, begin], costs[1, begin])
            for pair in range(at.begins[begin], at.begins[begin + 1]):
                end = begin + 1 + pair - at.begins[begin]
                cost = line_cost + prices[line, pair]
                if cost < costs[0, end]:
                    costs[0, end] = cost
                    before[0, end] = begin
                    kind_before[0, end] = line_from
                cost = bent_cost + wp.min(prices[arc, pair], prices[cubic, pair])
                if cost < costs[1, end]:
                    costs[1, end] = cost
                    before[1, end] = begin
                    kind_before[1, end] = bent_from
        end = point_count - 1
        is_bent = wp.where(costs[1, end] < costs[0, end], 1, 0)
        part = int(0)
        while end > 0:
            begin = before[is_bent, end]
            pair = at.begins[begin] + end - begin - 1
            kind = wp.where(prices[arc, pair] <= prices[cubic, pair], arc, cubic)
            kind = wp.where(is_bent != 0, kind, line)
            numbers[part, 0] = kind
            numbers[part, 1] = begin
            numbers[part, 2] = end
            numbers[part, 3] = pair
            if kind != cubic:
                found = nearest_line(rules, at, begin, end, infinity)
                if kind == arc:
                    found = nearest_arc(rules, at, begin, end, infinity)
                ways[part, 0] = found.first_way
                ways[part, 1] = found.last_way
                bulges[part] = found.bulge
            is_bent = kind_before[is_bent, end]
            end = int(begin)
            part += 1
        count[0] = part

    return bundle(price_parts, price_cubics, choose_parts)
