"""Gradients of up to ``STOPS_MAX`` stops with an opacity each: the colour in a pixel, and its derivatives.

A pixel has a *place* t, which is not limited. With q the vector from the origin of the gradient to the pixel, t is
g . q for linear gradients, and the root of q . S q for radial and elliptic ones. Stop k (from 1 on) adds its difference
from stop k - 1 times its *share*: 0 before the offset of stop k - 1, 1 from its own offset on, and linear in between.
Where two offsets are equal the share jumps, and has no derivative. So the colour continues beyond the ends ("pad").

``warpvec/rendering/stop_paints.py`` makes these arrays, and turns the sums over the pixels into derivatives:

- ``stop_count`` [N]: 1 for a path of one colour, which has no place;
- ``place_kind`` [N]: ``LINEAR_PLACE`` or ``ROOT_PLACE``;
- ``place_form`` [N, 5]: the origin, and g and 0, or the numbers xx, xy and yy of S;
- ``stop_ramps`` [N, STOPS_MAX, 8]: the colour and opacity of stop 0, or the difference of stop k (last four numbers);
  before them the two offsets, and 1 over their distance, or 0 if they are equal.

Sums of a path: dL/d(opacity) of all its stops together; those of a = dL/dt, w a q_x, w a q_y, w a q_x^2, w a q_x q_y
and w a q_y^2 with the weight w = 1 for linear places and 1 / t for others; and for each stop after the first those of
its share times dL/d(red, green, blue, opacity), and of a' and a' times the share with a' its own part of dL/dt.
"""

from types import SimpleNamespace

import warp as wp

from warpvec.geometry.stops import STOPS_MAX
from warpvec.kernels.constants import TILE
from warpvec.kernels.lanes import Lanes, bundle
from warpvec.kernels.making import made_once

LINEAR_PLACE, ROOT_PLACE = 0, 1
"""Kinds of places."""

WHOLE_TERMS = 7
"""Sums of a pair for its gradient as a whole."""

SEGMENT_TERMS = 6
"""Sums of a pair for each stop after the first."""

STOP_TERMS = WHOLE_TERMS + SEGMENT_TERMS * (STOPS_MAX - 1)
"""Sums of a pair for all its stops."""


@made_once
def make_functions(lanes: Lanes) -> SimpleNamespace:
    """Return the functions of gradients of several stops at the pixels of a lane value, and their types of rows."""
    dtype, vector = lanes.dtype, lanes.vector
    vec5, vec8 = wp.types.vector(5, dtype=dtype), wp.types.vector(8, dtype=dtype)
    v = lanes.functions
    zero, half, one, two = (wp.constant(dtype(value)) for value in (0.0, 0.5, 1.0, 2.0))
    blocks, width = wp.constant(lanes.blocks), wp.constant(lanes.width)

    @wp.func
    def offset_x(form: vec5, tile: int, part: int, tile_columns: int):
        """Return q_x of the pixels of ``part`` of a tile, which are all in one column."""
        column = (tile % tile_columns) * TILE + part // blocks
        return dtype(column) + half - form[0]

    @wp.func
    def offset_y(form: vec5, tile: int, part: int, tile_columns: int):
        """Return q_y of the pixels of ``part`` of a tile."""
        row = (tile // tile_columns) * TILE + (part % blocks) * width
        return v.ramp_from(dtype(row) + half - form[1])

    @wp.func
    def place_in(form: vec5, count: int, kind: int, tile: int, part: int, tile_columns: int):
        """Return t of the pixels of ``part`` of a tile; 0 for a path of one colour."""
        t = v.spread(zero)
        if count > 1:
            qx = offset_x(form, tile, part, tile_columns)
            qy = offset_y(form, tile, part, tile_columns)
            if kind == wp.static(LINEAR_PLACE):
                t = v.fma(qy, v.spread(form[3]), v.spread(qx * form[2]))
            else:
                first = v.spread(qx * qx * form[2])
                rest = v.fma(qy, v.spread(form[4]), v.spread(two * qx * form[3]))
                t = v.root(v.maximum(v.fma(qy, rest, first), v.spread(zero)))
        return t

    @wp.func
    def offset_weight(kind: int, t: vector):
        """Return 1 for a linear place, else 1 / t, 0 at the centre."""
        result = v.spread(one)
        if kind != wp.static(LINEAR_PLACE):
            result = v.where_less(v.spread(zero), t, v.quotient(v.spread(one), t), v.spread(zero))
        return result

    @wp.func
    def share(t: vector, row: vec8):
        """Return the share of a stop."""
        rising = v.mul(v.sub(t, v.spread(row[0])), v.spread(row[2]))
        return v.where_less(t, v.spread(row[1]), v.maximum(rising, v.spread(zero)), v.spread(one))

    @wp.func
    def steepness(t: vector, row: vec8, red: vector, green: vector, blue: vector, alpha: vector):
        """Return the part of a stop in dL/dt, from dL/d(colour) and dL/d(opacity) of the gradient."""
        along = v.fma(red, v.spread(row[4]), v.mul(green, v.spread(row[5])))
        along = v.fma(blue, v.spread(row[6]), v.fma(alpha, v.spread(row[7]), along))
        below = v.where_less(t, v.spread(row[1]), v.mul(along, v.spread(row[2])), v.spread(zero))
        return v.where_less(v.spread(row[0]), t, below, v.spread(zero))

    @wp.func
    def color_at(t: vector, path: int, count: int, stop_ramps: wp.array2d(dtype=vec8)):
        """Return red, green, blue and opacity."""
        first = stop_ramps[path, 0]
        red, green, blue, alpha = v.spread(first[4]), v.spread(first[5]), v.spread(first[6]), v.spread(first[7])
        for stop in range(1, count):
            row = stop_ramps[path, stop]
            part = share(t, row)
            red = v.fma(part, v.spread(row[4]), red)
            green = v.fma(part, v.spread(row[5]), green)
            blue = v.fma(part, v.spread(row[6]), blue)
            alpha = v.fma(part, v.spread(row[7]), alpha)
        return red, green, blue, alpha

    @wp.func
    def adj_place(
        t: vector,
        red: vector,
        green: vector,
        blue: vector,
        alpha: vector,
        path: int,
        count: int,
        stop_ramps: wp.array2d(dtype=vec8),
    ):
        """Return dL/dt from dL/d(colour) and dL/d(opacity) of the gradient."""
        total = v.spread(zero)
        for stop in range(1, count):
            total = v.add(total, steepness(t, stop_ramps[path, stop], red, green, blue, alpha))
        return total

    own = bundle(offset_x, offset_y, place_in, offset_weight, share, steepness, color_at, adj_place)
    return SimpleNamespace(vec5=vec5, vec8=vec8, **vars(own))
