"""Draw a path with a gradient by bands: paths of one colour each, cut along lines of equal colour.

An opaque band reaches a little below the next one, so that no seam shows; one around the others fills their place too
if that saves its inner edge. Where one colour gets more opaque along the gradient, or less, bands lie on each other.
Other translucent bands lie side by side.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from warpvec.arrays import Floats, interpolated
from warpvec.geometry.bezier import path_boxes
from warpvec.geometry.loops import Color, Outline, make_scene
from warpvec.geometry.paints.registry import LINEAR, RADIAL
from warpvec.geometry.quarter import QUARTER_HANDLE
from warpvec.geometry.scene import Scene
from warpvec.purposes.levels import CLOSE, STEP, opacities
from warpvec.purposes.loops import loops_of, outline_of, polygon, short_numbers
from warpvec.svg.foreign.color_ramps import elliptic_range, linear_range
from warpvec.svg.foreign.shapes import Loop
from warpvec.svg.foreign.skia import Combiner

_SAMPLES = 513
"""Places along a gradient at which its colours are looked at."""

_SAME = 2.0 / 255.0
"""Largest difference of a channel within what counts as one colour."""

_HALF_HANDLE, _HALF_MISS = 5.0 * math.pi / 12.0, 0.018
"""Length of the handles of half a circle of radius 1 as one cubic of the same area, and its largest distance."""

_SHARP = 1.0 / 4000.0
"""Share of the longer side of the canvas by which an edge may move: half a 2000th."""

_OVERLAP = 1.0
"""Units by which an opaque band reaches below the next one: a pixel. More would draw the edge of the shape twice."""


class _Ramp(NamedTuple):
    """The colours along a gradient.

    Attributes:
        kind, geometry: of the gradient.
        cuts: values of t between bands, rising.
        shades: red, green, blue and opacity of each band [cuts + 1, 4].
    """

    kind: int
    geometry: Floats
    cuts: Floats
    shades: Floats


class _Band(NamedTuple):
    """Where t is from ``low`` to ``high``, None for no limit, in a colour with an opacity.

    ``is_below`` tells whether others are painted over all that is inside of it.
    """

    low: float | None
    high: float | None
    color: Color
    opacity: float
    is_below: bool = False


def bands_of(one: Scene, width: float, height: float, combiner: Combiner) -> Scene:
    """Return the bands of the filled path with a gradient that ``one`` has, on a canvas of ``width`` x ``height``.

    If its shape cannot be cut, it has one colour.
    """
    loops, ramp = loops_of(one), _ramp(one, width, height)
    outlines: list[Outline] = []
    for band in _bands(ramp):
        part = _cut(loops, band, ramp, one, combiner)
        if part is None:
            mean = ramp.shades.mean(0)
            outlines = [outline_of(loops, _color(mean), float(mean[3]), int(one.generation))]
            break
        if part and band.opacity > 0.0:
            part = [loop._replace(points=short_numbers(loop.points, _SHARP * max(width, height))) for loop in part]
            outlines.append(outline_of(part, band.color, band.opacity, int(one.generation)))
    made = make_scene(outlines, None)
    return Scene(**{**vars(made), "background": one.background, "transparent": one.transparent})


def _color(shade: Floats) -> Color:
    red, green, blue = shade[:3].tolist()
    return red, green, blue


def _ramp(one: Scene, width: float, height: float) -> _Ramp:
    """Return what the gradient shows on the canvas, in steps of at most ``STEP``."""
    assert one.gradients is not None
    paint, stops = one.gradients, one.gradients.all_stops()
    count, kind = int(stops.count), int(paint.kind)
    geometry = np.append(paint.geometry[0].double().numpy(), float(stops.breadth))
    offsets = stops.shown_offsets()[0, :count].double().numpy()
    colors = stops.colors(one.color, paint.end_color)[0, :count].double().numpy()
    values = np.column_stack([colors, float(one.opacity) * stops.opacity[0, :count].double().numpy()])
    if kind == LINEAR:
        low, high = linear_range(loops_of(one), tuple(geometry[:4].tolist()), (width, height))
    else:
        low, high = elliptic_range(loops_of(one), tuple(_axes(kind, geometry)), (width, height))
    t = np.linspace(max(low, float(offsets[0])), min(high, float(offsets[-1])), _SAMPLES)
    shades = interpolated(t, offsets, values)
    change = np.append(0.0, _differences(shades).cumsum())
    halves = _halves(float(change[-1]), low < offsets[0], high > offsets[-1])
    places = np.minimum(np.searchsorted(change, halves), _SAMPLES - 1)
    return _Ramp(kind, geometry, t[places[1::2]], shades[places[::2]])


def _halves(change: float, is_flat_before: bool, is_flat_after: bool) -> Floats:
    """Return the middles of bands, with the cuts between them, along a ``change`` of colour.

    Where the shape goes on beyond an end in one colour, the band there has that colour: it reaches half a step.
    """
    beyond = (is_flat_before + is_flat_after) / 2.0
    count = max(1, math.ceil(change / STEP + beyond))
    step = change / max(count - beyond, 0.5)
    return step * (np.arange(1.0, 2.0 * count) - is_flat_before) / 2.0


def _differences(shades: Floats) -> Floats:
    """Return how far each shade is from the one before on a black ground or a white one, where they differ more."""
    on_black = np.diff(shades[:, :3] * shades[:, 3:], axis=0)
    on_white = on_black - np.diff(shades[:, 3:], axis=0)
    found: Floats = np.sqrt(np.maximum(np.square(on_black).mean(1), np.square(on_white).mean(1)))
    return found


def _axes(kind: int, geometry: Floats) -> Floats:
    """Return centre, axis and breadth of a round gradient."""
    if kind != RADIAL:
        return geometry
    x, y, radius = geometry[:3].tolist()
    return np.array([x, y, radius, 0.0, radius])


def _bands(ramp: _Ramp) -> list[_Band]:
    """Return the bands, from bottom to top."""
    shades, edges = ramp.shades, [None, *ramp.cuts.tolist(), None]
    opacity, colors = shades[:, 3], [_color(shade) for shade in shades]
    if (opacity > 1.0 - _SAME).all():
        return _opaque_bands(ramp, edges, colors)
    is_even = bool(np.ptp(shades[opacity > 0.0, :3], axis=0).max() <= _SAME)
    if is_even and (np.diff(opacity) >= 0.0).all():
        rising = opacities(opacity.tolist())
        return [_Band(low, None, color, each) for low, color, each in zip(edges[:-1], colors, rising, strict=True)]
    if is_even and (np.diff(opacity) <= 0.0).all():
        rising = opacities(opacity[::-1].tolist())
        return [
            _Band(None, high, color, each) for high, color, each in zip(edges[:0:-1], colors[::-1], rising, strict=True)
        ]
    return [_Band(*each) for each in zip(edges[:-1], edges[1:], colors, opacity.tolist(), strict=True)]


def _opaque_bands(ramp: _Ramp, edges: list[float | None], colors: list[Color]) -> list[_Band]:
    """Return bands, each of which reaches a little below the next one. Of discs, the next one is the outer one."""
    below = _OVERLAP / _extent(ramp)
    lows, highs = edges[:-1], edges[1:]
    if ramp.kind == LINEAR:
        highs = [None if high is None else high + below for high in highs]
        return [_Band(low, high, color, 1.0) for low, high, color in zip(lows, highs, colors, strict=True)]
    lows = [None if low is None or low <= below else low - below for low in lows]
    return [_Band(low, high, color, 1.0, True) for low, high, color in zip(lows, highs, colors, strict=True)][::-1]


def _extent(ramp: _Ramp) -> float:
    """Return the least distance in units over which t grows by 1."""
    if ramp.kind == LINEAR:
        return float(np.hypot(*(ramp.geometry[2:4] - ramp.geometry[:2])))
    _, _, ax, ay, breadth = _axes(ramp.kind, ramp.geometry).tolist()
    return min(math.hypot(ax, ay), breadth)


def _cut(loops: list[Loop], band: _Band, ramp: _Ramp, one: Scene, combiner: Combiner) -> list[Loop] | None:
    """Return the part of a shape where t is that of a band; None if it cannot be told."""
    found: list[Loop] | None = loops
    if band.low is not None and found:
        inner = [_up_to(band.low, ramp, one)]
        is_covered = band.is_below and combiner.without(inner, loops) == []
        found = found if is_covered else combiner.without(found, inner)
    if band.high is not None and found:
        found = combiner.common(found, [_up_to(band.high, ramp, one)])
    return found


def _up_to(share: float, ramp: _Ramp, one: Scene) -> Loop:
    """Return the outline of the places around the shape whose t is at most ``share``."""
    if ramp.kind != LINEAR:
        x, y, ax, ay, breadth = _axes(ramp.kind, ramp.geometry).tolist()
        along = share * np.array([ax, ay])
        across = share * breadth / max(math.hypot(ax, ay), 1e-9) * np.array([-ay, ax])
        return _ellipse(np.array([x, y]), along, across, CLOSE * _narrowest(ramp))
    start, along = ramp.geometry[:2], ramp.geometry[2:4] - ramp.geometry[:2]
    left, top, right, bottom = path_boxes(one).double()[0].tolist()
    reach = 2.0 * (abs(right - left) + abs(bottom - top)) + 1.0
    unit = along / np.hypot(*along)
    middle = np.array([left + right, top + bottom]) / 2.0
    sideways = np.array([-unit[1], unit[0]])
    edge = middle + unit * (unit @ (start + share * along - middle))
    corners = np.stack([edge - reach * sideways, edge + reach * sideways])
    corners = np.concatenate([corners, corners[::-1] - reach * unit])
    return polygon(corners)


def _narrowest(ramp: _Ramp) -> float:
    """Return the width in units of the narrowest band between two others; that of all if there is none."""
    return _extent(ramp) * float(np.diff(ramp.cuts).min(initial=1.0))


def _ellipse(center: Floats, along: Floats, across: Floats, tolerance: float) -> Loop:
    """Return the ellipse about a centre with these half axes, within ``tolerance``: as two cubics, or as four."""
    ends = [along, across, -along, -across]
    if _HALF_MISS * max(np.hypot(*along), np.hypot(*across)) <= tolerance:
        rows = [
            np.stack([center + a, center + a + _HALF_HANDLE * b, center - a + _HALF_HANDLE * b])
            for a, b in (ends[:2], ends[2:])
        ]
    else:
        rows = [
            np.stack([center + a, center + a + QUARTER_HANDLE * b, center + b + QUARTER_HANDLE * a])
            for a, b in zip(ends, [*ends[1:], ends[0]], strict=True)
        ]
    return Loop(short_numbers(np.concatenate(rows), tolerance / 2.0), np.zeros(len(rows), np.bool_))
