"""Gradient paints: the share t of the end colour in a pixel, and the derivatives of t.

The colour of a path with a gradient is (1 - t) color + t end_color, evaluated at the centre of a pixel, as SVG
renderers do. With q the vector from the gradient's first point to the pixel:

- linear from p1 to p2, d = p2 - p1: t = q . d / |d|^2;
- radial about c with radius r: t = |q| / r, where c takes the place of p1.

t is clamped to [0, 1] ("pad"). A gradient whose ends are equal, whose radius is not positive, or which is not finite
shows its end colour (the rule of SVG 2, section 14.2.2) and has no derivative.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from warpvec.geometry.gradients import EXTENT_MIN, LINEAR
from warpvec.kernels.constants import TILE
from warpvec.kernels.lanes import Lanes

GRADIENT_TERMS = 6
"""Sums a pair has for a gradient: three of t dL/d(colour), and three of dL/dt times 1, q_x, q_y (linear) or times
t, q_x / |q|, q_y / |q| (radial)."""


@cache
def make_functions(lanes: Lanes) -> SimpleNamespace:
    """Return the functions of a gradient at the pixels of a lane value, and ``geometry_adjoint``."""
    dtype, vec2, vec3, vec4, vector = lanes.dtype, lanes.vec2, lanes.vec3, lanes.vec4, lanes.vector
    mul, fma, spread, root = lanes.mul, lanes.fma, lanes.spread, lanes.root
    minimum, maximum, where_less, quotient = lanes.minimum, lanes.maximum, lanes.where_less, lanes.quotient
    zero, half, one, two = (wp.constant(dtype(value)) for value in (0.0, 0.5, 1.0, 2.0))
    smallest = wp.constant(dtype(EXTENT_MIN))
    blocks, width = wp.constant(lanes.blocks), wp.constant(lanes.width)

    @wp.func
    def slopes(kind: int, geometry: vec4):
        """Return dt/dq of a linear gradient and 0, or 0, 0 and 1 / r of a radial one; 0 if it is degenerate."""
        result = vec3()
        if kind == wp.static(LINEAR):
            d = vec2(geometry[2] - geometry[0], geometry[3] - geometry[1])
            squared = wp.dot(d, d)
            if squared >= smallest * smallest and wp.isfinite(squared):
                result = vec3(d[0] / squared, d[1] / squared, zero)
        elif geometry[2] >= smallest and wp.isfinite(geometry[2]) and wp.isfinite(geometry[0] + geometry[1]):
            result = vec3(zero, zero, one / geometry[2])
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
        return lanes.ramp_from(dtype(row) + half - geometry[1])

    @wp.func
    def free_share(slope: vec3, qx: dtype, qy: vector):
        """Return t before it is clamped; 1 for a degenerate gradient."""
        if slope[2] > zero:
            return mul(root(fma(qy, qy, spread(qx * qx))), spread(slope[2]))
        if slope[0] == zero and slope[1] == zero:
            return spread(one)
        return fma(qy, spread(slope[1]), spread(qx * slope[0]))

    @wp.func
    def share(free: vector):
        """Return t."""
        return minimum(maximum(free, spread(zero)), spread(one))

    @wp.func
    def on_ramp(free: vector, value: vector):
        """Return ``value`` where t is not clamped, else 0."""
        below = where_less(free, spread(one), value, spread(zero))
        return where_less(spread(zero), free, below, spread(zero))

    @wp.func
    def inverse_length(slope: vec3, qx: dtype, qy: vector):
        """Return 1 / |q| of a radial gradient, 0 at its centre; 1 for a linear one."""
        if slope[2] > zero:
            length = root(fma(qy, qy, spread(qx * qx)))
            return where_less(spread(zero), length, quotient(spread(one), length), length)
        return spread(one)

    @wp.func
    def unit_or_share(slope: vec3, t: vector):
        """Return t of a radial gradient, and 1 for a linear one."""
        if slope[2] > zero:
            return t
        return spread(one)

    @wp.func
    def geometry_adjoint(kind: int, geometry: vec4, sums: vec3):
        """Return dL/d(geometry) from the three sums over dL/dt; ``GRADIENT_TERMS`` describes them."""
        slope = slopes(kind, geometry)
        adj = vec4()
        if slope[2] > zero:
            adj = vec4(-sums[1] * slope[2], -sums[2] * slope[2], -sums[0] * slope[2], zero)
        elif kind == wp.static(LINEAR) and (slope[0] != zero or slope[1] != zero):
            inv_squared = slope[0] * slope[0] + slope[1] * slope[1]  # 1 / |d|^2
            sum_t = sums[1] * slope[0] + sums[2] * slope[1]
            end_x = sums[1] * inv_squared - two * sum_t * slope[0]
            end_y = sums[2] * inv_squared - two * sum_t * slope[1]
            adj = vec4(-sums[0] * slope[0] - end_x, -sums[0] * slope[1] - end_y, end_x, end_y)
        return adj

    return SimpleNamespace(
        slopes=slopes,
        offset_x=offset_x,
        offset_y=offset_y,
        free_share=free_share,
        share=share,
        on_ramp=on_ramp,
        inverse_length=inverse_length,
        unit_or_share=unit_or_share,
        geometry_adjoint=geometry_adjoint,
    )
