"""Gradient paints: the share t of the end colour in a pixel, and the derivatives of t.

The colour of a path with a gradient is (1 - t) color + t end_color, evaluated at the centre of a pixel, as SVG
renderers do. t is clamped to [0, 1] ("pad"). A gradient whose ends are equal, whose radius is not positive, or which is
not finite shows its end colour (the rule of SVG 2, section 14.2.2) and has no derivative.

These are the gradients of two opaque stops; ``stops.py`` draws all others. Each kind of paint of
``warpvec/geometry/paints/`` that needs no stops has a row in ``KNOWN``: a factory of its functions. With q the vector
from the first two numbers of the geometry to the pixel, these are

- ``slopes(geometry)``: three numbers that the other functions use, and that are not all 0 unless it is degenerate;
- ``free_share(slope, qx, qy)``: t before it is clamped;
- ``share_weight(t)`` and ``offset_weight(slope, qx, qy)``: the three sums of a pair over its pixels are dL/dt times the
  first weight, and times the second weight and q_x or q_y;
- ``geometry_adjoint(slope, sums)``: dL/d(geometry) from the three sums.

A kind whose derivatives do not follow from three sums needs more ``GRADIENT_TERMS``.
"""

from collections.abc import Callable
from types import SimpleNamespace

import warp as wp

from warpvec.geometry.paints.kind import RAMP_EXTENT_MIN
from warpvec.geometry.paints.registry import FLAT, KINDS, LINEAR, RADIAL
from warpvec.kernels.constants import TILE
from warpvec.kernels.lanes import Lanes, bundle
from warpvec.kernels.making import made_once

DEGENERATE = -1
"""In place of the kind of a gradient that shows its end colour alone."""

GRADIENT_TERMS = 6
"""Sums a pair has for a gradient: three of t dL/d(colour), and three of dL/dt; see above."""


def _linear(lanes: Lanes) -> SimpleNamespace:
    """Return the functions of t = q . d / |d|^2, with d from the first point to the second."""
    dtype, vec2, vec3, vec4, vector = lanes.dtype, lanes.vec2, lanes.vec3, lanes.vec4, lanes.vector
    v = lanes.functions
    zero, one, two = (wp.constant(dtype(value)) for value in (0.0, 1.0, 2.0))
    smallest = wp.constant(dtype(RAMP_EXTENT_MIN))

    @wp.func
    def slopes(geometry: vec4):
        """Return dt/dq and 0."""
        result = vec3()
        d = vec2(geometry[2] - geometry[0], geometry[3] - geometry[1])
        squared = wp.dot(d, d)
        if squared >= smallest * smallest and wp.isfinite(squared):
            result = vec3(d[0] / squared, d[1] / squared, zero)
        return result

    @wp.func
    def free_share(slope: vec3, qx: dtype, qy: vector):
        return v.fma(qy, v.spread(slope[1]), v.spread(qx * slope[0]))

    @wp.func
    def share_weight(t: vector):
        return v.spread(one)

    @wp.func
    def offset_weight(slope: vec3, qx: dtype, qy: vector):
        return v.spread(one)

    @wp.func
    def geometry_adjoint(slope: vec3, sums: vec3):
        inv_squared = slope[0] * slope[0] + slope[1] * slope[1]  # 1 / |d|^2
        sum_t = sums[1] * slope[0] + sums[2] * slope[1]
        end_x = sums[1] * inv_squared - two * sum_t * slope[0]
        end_y = sums[2] * inv_squared - two * sum_t * slope[1]
        return vec4(-sums[0] * slope[0] - end_x, -sums[0] * slope[1] - end_y, end_x, end_y)

    return bundle(slopes, free_share, share_weight, offset_weight, geometry_adjoint)


def _radial(lanes: Lanes) -> SimpleNamespace:
    """Return the functions of t = |q| / r about the centre c."""
    dtype, vec3, vec4, vector = lanes.dtype, lanes.vec3, lanes.vec4, lanes.vector
    v = lanes.functions
    zero, one = (wp.constant(dtype(value)) for value in (0.0, 1.0))
    smallest = wp.constant(dtype(RAMP_EXTENT_MIN))

    @wp.func
    def slopes(geometry: vec4):
        """Return 0, 0 and 1 / r."""
        result = vec3()
        if geometry[2] >= smallest and wp.isfinite(geometry[2]) and wp.isfinite(geometry[0] + geometry[1]):
            result = vec3(zero, zero, one / geometry[2])
        return result

    @wp.func
    def free_share(slope: vec3, qx: dtype, qy: vector):
        return v.mul(v.root(v.fma(qy, qy, v.spread(qx * qx))), v.spread(slope[2]))

    @wp.func
    def share_weight(t: vector):
        return t

    @wp.func
    def offset_weight(slope: vec3, qx: dtype, qy: vector):
        """Return 1 / |q|, 0 at the centre."""
        length = v.root(v.fma(qy, qy, v.spread(qx * qx)))
        return v.where_less(v.spread(zero), length, v.quotient(v.spread(one), length), length)

    @wp.func
    def geometry_adjoint(slope: vec3, sums: vec3):
        return vec4(-sums[1] * slope[2], -sums[2] * slope[2], -sums[0] * slope[2], zero)

    return bundle(slopes, free_share, share_weight, offset_weight, geometry_adjoint)


def _degenerate(lanes: Lanes) -> SimpleNamespace:
    """Return the functions of `_either` for a gradient that shows its end colour alone."""
    dtype, vec3, vec4, vector = lanes.dtype, lanes.vec3, lanes.vec4, lanes.vector
    v = lanes.functions
    zero, one = (wp.constant(dtype(value)) for value in (0.0, 1.0))

    @wp.func
    def slopes(kind: int, geometry: vec4):
        return vec3()

    @wp.func
    def free_share(kind: int, slope: vec3, qx: dtype, qy: vector):
        return v.spread(one)

    @wp.func
    def share_weight(kind: int, t: vector):
        return v.spread(zero)

    @wp.func
    def offset_weight(kind: int, slope: vec3, qx: dtype, qy: vector):
        return v.spread(zero)

    @wp.func
    def geometry_adjoint(kind: int, slope: vec3, sums: vec3):
        return vec4()

    return bundle(slopes, free_share, share_weight, offset_weight, geometry_adjoint)


def _either(number: int, own: SimpleNamespace, others: SimpleNamespace, lanes: Lanes) -> SimpleNamespace:
    """Return functions that take a kind first: they call those of ``own`` for the kind ``number``, else ``others``."""
    dtype, vec3, vec4, vector = lanes.dtype, lanes.vec3, lanes.vec4, lanes.vector
    number = wp.constant(number)

    # One result, not two returns: with those the compiler fuses other products, and last bits change.
    @wp.func
    def slopes(kind: int, geometry: vec4):
        result = vec3()
        if kind == number:
            result = own.slopes(geometry)
        else:
            result = others.slopes(kind, geometry)
        return result

    @wp.func
    def free_share(kind: int, slope: vec3, qx: dtype, qy: vector):
        if kind == number:
            return own.free_share(slope, qx, qy)
        return others.free_share(kind, slope, qx, qy)

    @wp.func
    def share_weight(kind: int, t: vector):
        if kind == number:
            return own.share_weight(t)
        return others.share_weight(kind, t)

    @wp.func
    def offset_weight(kind: int, slope: vec3, qx: dtype, qy: vector):
        if kind == number:
            return own.offset_weight(slope, qx, qy)
        return others.offset_weight(kind, slope, qx, qy)

    @wp.func
    def geometry_adjoint(kind: int, slope: vec3, sums: vec3):
        adj = vec4()
        if kind == number:
            adj = own.geometry_adjoint(slope, sums)
        else:
            adj = others.geometry_adjoint(kind, slope, sums)
        return adj

    return bundle(slopes, free_share, share_weight, offset_weight, geometry_adjoint)


KNOWN: dict[int, Callable[[Lanes], SimpleNamespace]] = {LINEAR: _linear, RADIAL: _radial}
"""Kind of paint -> the factory of its functions."""


@made_once
def make_functions(lanes: Lanes) -> SimpleNamespace:
    """Return the functions of a gradient of any kind at the pixels of a lane value.

    Raises:
        NotImplementedError: a kind in the registry has no functions in ``KNOWN``.
    """
    if missing := [kind.name for number, kind in KINDS.items() if not (number in KNOWN or kind.needs_stops)]:
        raise NotImplementedError(f"kernels/gradients.py has no functions for gradients of the kind {missing[0]!r}")
    dtype, vec3, vec4, vector = lanes.dtype, lanes.vec3, lanes.vec4, lanes.vector
    v = lanes.functions
    zero, half, one = (wp.constant(dtype(value)) for value in (0.0, 0.5, 1.0))
    blocks, width = wp.constant(lanes.blocks), wp.constant(lanes.width)
    any_kind = _degenerate(lanes)
    for number, make_own in reversed(KNOWN.items()):
        any_kind = _either(number, make_own(lanes), any_kind, lanes)

    @wp.func
    def shown_kind(kind: int, slope: vec3):
        """Return the kind for the functions below: ``DEGENERATE`` for a gradient that is so."""
        result = kind
        if kind != wp.static(FLAT) and slope[0] == zero and slope[1] == zero and slope[2] == zero:
            result = wp.static(DEGENERATE)
        return result

    @wp.func
    def offset_x(geometry: vec4, tile: int, part: int, tile_columns: int):
        """Return q_x of the pixels of ``part`` of a tile, which are all in one column."""
        column = (tile % tile_columns) * TILE + part // blocks
        return dtype(column) + half - geometry[0]

    @wp.func
    def offset_y(geometry: vec4, tile: int, part: int, tile_columns: int):
        """Return q_y of the pixels of ``part`` of a tile."""
        row = (tile // tile_columns) * TILE + (part % blocks) * width
        return v.ramp_from(dtype(row) + half - geometry[1])

    @wp.func
    def share(free: vector):
        """Return t."""
        return v.minimum(v.maximum(free, v.spread(zero)), v.spread(one))

    @wp.func
    def on_ramp(free: vector, value: vector):
        """Return ``value`` where t is not clamped, else 0."""
        below = v.where_less(free, v.spread(one), value, v.spread(zero))
        return v.where_less(v.spread(zero), free, below, v.spread(zero))

    @wp.func
    def geometry_adjoint(kind: int, geometry: vec4, sums: vec3):
        """Return dL/d(geometry) from the three sums over dL/dt."""
        slope = any_kind.slopes(kind, geometry)
        return any_kind.geometry_adjoint(shown_kind(kind, slope), slope, sums)

    own = bundle(shown_kind, offset_x, offset_y, share, on_ramp, geometry_adjoint)
    return SimpleNamespace(**(vars(any_kind) | vars(own)))
