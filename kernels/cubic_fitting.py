"""Cubics with given ends that are closest to rows of points."""

from types import SimpleNamespace

import warp as wp

from warpvec.kernels import bezier
from warpvec.kernels.lanes import bundle, make_lanes, unit
from warpvec.kernels.making import made_once
from warpvec.kernels.vectors import vec2

real = wp.float64


@made_once
def make_kernels() -> SimpleNamespace:
    """Return ``fit_rows``."""
    module = unit("cubic_fitting")
    curves = bezier.make_functions(make_lanes(1, real))
    tiny = wp.constant(real(1e-20))  # added to what is divided by, which vanishes where points coincide
    zero, one, two, three = (wp.constant(real(value)) for value in (0.0, 1.0, 2.0, 3.0))
    least = wp.constant(real(0.0))  # a bound; sums that begin with the constant ``zero`` change it

    @wp.func
    def closest_handles(
        row: int,
        count: int,
        a: vec2,
        d: vec2,
        points: wp.array2d(dtype=vec2),
        places: wp.array2d(dtype=real),
        weight: real,
    ):
        """Return the handles that are closest to the points of a row, in squares."""
        xx = real(weight)
        xy = real(zero)
        yy = real(weight)
        p = weight * (a + (d - a) / three)
        q = weight * (a + (d - a) * two / three)
        for k in range(count):
            u = places[row, k]
            v = one - u
            first, second = three * u * v * v, three * u * u * v
            rest = points[row, k] - v * v * v * a - u * u * u * d
            xx += first * first
            xy += first * second
            yy += second * second
            p += first * rest
            q += second * rest
        determinant = xx * yy - xy * xy
        return (yy * p - xy * q) / determinant, (xx * q - xy * p) / determinant

    @wp.func
    def handles_along(
        row: int,
        count: int,
        a: vec2,
        d: vec2,
        forward: vec2,
        backward: vec2,
        points: wp.array2d(dtype=vec2),
        places: wp.array2d(dtype=real),
        weight: real,
    ):
        """Return the closest handles along two unit vectors, not backwards."""
        third = weight * wp.length(d - a) / three
        xx = real(weight)
        xy = real(zero)
        yy = real(weight)
        p = real(third)
        q = real(third)
        for k in range(count):
            u = places[row, k]
            v = one - u
            first, second = three * u * v * v, three * u * u * v
            rest = points[row, k] - (v * v * v + first) * a - (u * u * u + second) * d
            xx += first * first
            xy += first * second
            yy += second * second
            p += first * wp.dot(rest, forward)
            q += second * wp.dot(rest, backward)
        xy = xy * wp.dot(forward, backward)
        determinant = xx * yy - xy * xy
        first_length = wp.max((yy * p - xy * q) / determinant, least)
        second_length = wp.max((xx * q - xy * p) / determinant, least)
        return a + first_length * forward, d + second_length * backward

    @wp.kernel(module=module)
    def fit_rows(
        first: int,
        row_count: int,  # B
        point_count: int,  # S
        start: wp.array(dtype=vec2),  # [B]
        end: wp.array(dtype=vec2),  # [B]
        points: wp.array2d(dtype=vec2),  # [B, S]
        directions: wp.array2d(dtype=vec2),  # [B, 2] of the handles, for ``has_directions``
        has_directions: int,
        rounds: int,
        factor: real,  # of the steps of the places between rounds
        thirds_weight: real,  # of handles at thirds of the chord, where all points together have 1
        # in and out
        places: wp.array2d(dtype=real),  # [B, S] where along the cubic each point is, in [0, 1]
        # outputs
        handles: wp.array2d(dtype=vec2),  # [B, 2]
        squares: wp.array2d(dtype=real),  # [B, 2] largest and mean squared distance of the points from the cubic
    ):
        """Find handles, and the places where the cubic is closest to the points, in turns; row by row."""
        weight = thirds_weight * real(point_count)
        for row in range(row_count):
            a = start[row]
            d = end[row]
            for turn in range(rounds):
                if has_directions != 0:
                    b, c = handles_along(
                        row, point_count, a, d, directions[row, 0], directions[row, 1], points, places, weight
                    )
                else:
                    b, c = closest_handles(row, point_count, a, d, points, places, weight)
                handles[row, 0] = b
                handles[row, 1] = c
                slope1, slope2 = three * (b - a), three * (a - two * b + c)
                slope3 = d - a - three * (c - b)
                for k in range(point_count):
                    u = places[row, k]
                    offset = ((slope3 * u + slope2) * u + slope1) * u + a - points[row, k]
                    slope = (three * slope3 * u + two * slope2) * u + slope1
                    step = wp.dot(offset, slope) / (wp.dot(slope, slope) + tiny)
                    share = wp.where(turn < rounds - 1, factor, one)
                    places[row, k] = wp.clamp(u - share * step, least, one)
            largest = real(zero)
            total = real(zero)
            for k in range(point_count):
                w = curves.weights(places[row, k])
                offset = w[0] * a + w[1] * handles[row, 0] + w[2] * handles[row, 1] + w[3] * d - points[row, k]
                square = wp.dot(offset, offset)
                largest = wp.max(largest, square)
                total += square
            squares[row, 0] = largest
            squares[row, 1] = total / real(point_count)

    return bundle(fit_rows)
