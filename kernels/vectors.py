"""Plane vectors in float64, for the kernels of exact fits."""

import warp as wp

vec2 = wp.vec2d


@wp.func
def as_real(a: wp.vec2f):
    """Return ``a`` in float64."""
    return vec2(wp.float64(a[0]), wp.float64(a[1]))


@wp.func
def cross(a: vec2, b: vec2):
    """Return the area of the parallelogram of two vectors, positive from x to y."""
    return a[0] * b[1] - a[1] * b[0]


@wp.func
def unit_of(a: vec2, least: wp.float64):
    """Return ``a`` with the length 1; shorter than ``least`` it gets a shorter one."""
    return a / wp.max(wp.length(a), least)
