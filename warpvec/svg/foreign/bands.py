"""Paint shapes with gradients of any stops by paths of up to ``STOPS_MAX`` stops each.

If a path cannot have as many stops as a ramp needs, the ramp is cut at its stops: each band of the shape is a path with
the gradient between two stops. A band reaches a little below the next band, which is painted over it, so that no seam
shows. A radial ramp becomes a stack of discs.
"""

from __future__ import annotations

import math
from collections import Counter
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray

from warpvec.arrays import interpolated
from warpvec.geometry.loops import Color, OutlineGradient, OutlineStop
from warpvec.geometry.paints.kind import GradientKind
from warpvec.geometry.paints.registry import ELLIPTIC, LINEAR, RADIAL, kind_of
from warpvec.geometry.stops import STOPS_MAX
from warpvec.geometry.trim import cut_at
from warpvec.svg.foreign.budget import WorkBudget
from warpvec.svg.foreign.color_ramps import (
    EXACT,
    LEVEL,
    Array,
    ColorRamp,
    RampPiece,
    central,
    clipped,
    difference,
    elliptic_range,
    linear_range,
    merged_pieces,
    radial_range,
    shown_periods,
    straight_pieces,
    unrolled,
)
from warpvec.svg.foreign.discs import disc_in
from warpvec.svg.foreign.ramp_stops import RampStop, ramp_stops, reduced_stops
from warpvec.svg.foreign.shapes import Loop, curves_of
from warpvec.svg.foreign.skia import Combiner

MAX_BANDS = 16
"""Most paths that one shape becomes. Ramps that need more, such as spectra, get two fitted stops."""

_CLOSE = 1.5 * LEVEL
"""Largest difference of two fitted stops from a ramp for which a shape is not cut: about 48 dB."""

_RING_CLOSE = 2.5 * LEVEL
"""Largest difference in a ring of a radial ramp that is too steep for one disc; it is largest at the ring's edges."""

_RINGS_MAX = 5
"""Most discs for one stop of such a ramp."""

_OVERLAP = 0.01
"""How far a band reaches below the next one, as a fraction of the longer side: a pixel where that side has 100."""

_SAMPLES = 129
"""Number of places at which two stops are fitted to a ramp, and compared with it."""

_ENDS_MAX = 12
"""Most stops that are tried as the ends of two fitted stops."""

RAMP_EFFORT = 2**19
"""Most stops that are read for a file, some 5 s of work; other work on gradients counts as stops. Thousands of shapes
may each show a ramp of thousands of stops."""

_FIT_EFFORT, _BAND_EFFORT = 3, 60
"""Stops that take as long as fitting two stops once, and as making a band or a disc: 30 and 600 microseconds."""

_RANGES = {LINEAR: linear_range, RADIAL: radial_range, ELLIPTIC: elliptic_range}
"""Kind of a gradient of another program's file -> the offsets that the visible part of a shape may show."""

_REACH = 2.0**24
"""Largest coordinate of a gradient in pixels, where float32 still tells neighbouring pixels apart."""


class Painted(NamedTuple):
    """A part of a shape, in pixels, and its paint: a colour, or a gradient that starts with it; and its opacity."""

    loops: list[Loop]
    color: Color
    gradient: OutlineGradient | None
    opacity: float = 1.0


def painted(
    loops: list[Loop],
    ramp: ColorRamp,
    is_opaque: bool,
    size: tuple[float, float],
    combiner: Combiner,
    budget: WorkBudget,
    omitted: Counter[str],
) -> list[Painted] | None:
    """Return the parts of a shape, from bottom to top, that show ``ramp`` on it; None if ``budget`` does not allow it.

    If there is only little of it left, a ramp gets two stops.

    Args:
        loops: those of the shape, in pixels.
        ramp: its colours.
        is_opaque: whether parts may overlap.
        size: width and height of the canvas; what lies beyond it does not count.
        combiner: cuts discs.
        budget: ``RAMP_EFFORT`` for a file.
        omitted: counts what the parts do not show.
    """
    if not np.isfinite(ramp.geometry).all() or np.abs(ramp.geometry).max() > _REACH:
        omitted["gradient out of reach"] += 1
        return [_flat(loops, ramp.colors[-1])]
    kind = kind_of(ramp.kind)
    if not kind.is_drawn(torch.tensor([ramp.geometry], dtype=torch.float64)).item():
        return [_flat(loops, ramp.colors[-1])]
    low, high = _RANGES[ramp.kind](loops, ramp.geometry, size)
    stop_count = len(ramp.offsets) * max(len(shown_periods(ramp, low, high)), 1)
    if stop_count > 2 and not budget.takes(stop_count):
        return None
    ramp = unrolled(ramp, low, high, omitted)
    straight = straight_pieces(ramp, low, high)
    pieces = merged_pieces(straight)
    is_opaque_ramp = ramp.colors.shape[1] == 3
    if len(pieces) == 1 and is_opaque_ramp and _fits_one(kind, pieces[0]):
        return [Painted(loops, *_paint(ramp, pieces[0]))]
    if len(stops := ramp_stops(pieces)) <= STOPS_MAX:
        return [Painted(loops, *_with_stops(ramp, stops))]
    if not is_opaque_ramp or ramp.kind == ELLIPTIC:
        omitted["gradient of many stops"] += 1
        return [Painted(loops, *_with_stops(ramp, reduced_stops(stops)))]
    fitted, error = _fitted(ramp, low, high, budget)
    parts: list[Painted] | None = None
    band_count = len(pieces) if kind.has_free_start else min(_RINGS_MAX * len(pieces), MAX_BANDS)
    if error > _CLOSE and len(pieces) <= MAX_BANDS and budget.takes(_BAND_EFFORT * band_count):
        parts = _bands(loops, ramp, pieces, is_opaque, size) if ramp.kind == LINEAR else None
        if ramp.kind == RADIAL and is_opaque:
            parts = _discs(loops, ramp, pieces, combiner, omitted)
    if parts is None and error > _CLOSE:
        omitted["gradient of many stops"] += 1
        return [Painted(loops, *_with_stops(ramp, reduced_stops(stops)))]
    if parts is None:
        return [Painted(loops, *_paint(ramp, fitted))]
    omitted["gradient part"] += len(parts) - 1
    return parts


def _flat(loops: list[Loop], color: Array) -> Painted:
    """Return a shape in a colour [3], or in a colour and an opacity [4]."""
    return Painted(loops, _color(color[:3]), None, *color[3:].tolist())


def _with_stops(ramp: ColorRamp, stops: list[RampStop]) -> tuple[Color, OutlineGradient]:
    """Return the first colour and the gradient of these stops, whose ends are those of the gradient if they must be."""
    kind, first, last = kind_of(ramp.kind), stops[0].offset, stops[-1].offset
    start = min(first, 0.0) if kind.has_free_start else 0.0
    end = max(last, 1.0)
    geometry = kind.between(ramp.geometry, start, end)
    own = tuple(
        OutlineStop((stop.offset - start) / (end - start), _color(stop.color[:3]), *stop.color[3:].tolist())
        for stop in stops
    )
    return own[0].color, OutlineGradient(ramp.kind, geometry, own[-1].color, own)


def _fits_one(kind: GradientKind, piece: RampPiece) -> bool:
    """Return whether one gradient shows ``piece``: without a free start, its centre must have a colour."""
    return kind.has_free_start or bool(np.abs(central(piece) - clipped(central(piece))).max() <= EXACT)


def _paint(ramp: ColorRamp, piece: RampPiece) -> tuple[Color, OutlineGradient | None]:
    """Return the first colour and the gradient of two stops that continue ``piece``."""
    kind = kind_of(ramp.kind)
    first, last = piece.first if kind.has_free_start else clipped(central(piece)), piece.last
    geometry = kind.between(ramp.geometry, piece.start, piece.end)
    if (first == last).all():
        return _color(first), None
    return _color(first), OutlineGradient(ramp.kind, geometry, _color(last))


def _fitted(ramp: ColorRamp, low: float, high: float, budget: WorkBudget) -> tuple[RampPiece, float]:
    """Return the straight part, padded, that is closest to ``ramp`` over its area, and the largest difference.

    Its ends are at stops, or at the ends of what is visible; at these alone if ``budget`` allows no more.
    """
    has_free_start = kind_of(ramp.kind).has_free_start
    low = low if has_free_start else 0.0
    t = np.linspace(low, high, _SAMPLES)
    shown = interpolated(t, ramp.offsets, ramp.colors)
    weight = np.ones((len(t), 1)) if has_free_start else np.sqrt(t / t[-1])[:, None]
    inner = np.unique(ramp.offsets[(ramp.offsets > low) & (ramp.offsets < high)])[:_ENDS_MAX]
    fit_count = math.comb(len(inner) + 2, 2) if has_free_start else len(inner) + 1
    ends = [low, *inner.tolist(), high] if budget.takes(_FIT_EFFORT * fit_count) else [low, high]
    best, least = None, math.inf
    for i, start in enumerate(ends if has_free_start else ends[:1]):
        for end in ends[i + 1 :]:
            share = np.clip((t - start) / (end - start), 0.0, 1.0)[:, None]
            basis = np.hstack([1.0 - share, share])
            fitted = clipped(np.linalg.lstsq(weight * basis, weight * shown, rcond=None)[0])
            residual = basis @ fitted - shown
            loss = float((weight * residual**2).sum())
            if loss < least:
                best, least, error = RampPiece(start, end, *fitted), loss, float(np.abs(residual).max())
    if best is None:
        return RampPiece(low, low + 1.0, shown[-1], shown[-1]), math.inf
    return best, error


def _bands(
    loops: list[Loop], ramp: ColorRamp, pieces: list[RampPiece], is_opaque: bool, size: tuple[float, float]
) -> list[Painted]:
    """Return the bands of a shape between the stops of a linear ramp."""
    start, along = np.array(ramp.geometry[:2]), np.subtract(ramp.geometry[2:4], ramp.geometry[:2])
    length = float(np.hypot(*along))
    across, down = along / length
    frame = np.array([[across, down], [-down, across]])
    origin, overlap = float(frame[0] @ start), _OVERLAP * max(size) if is_opaque else 0.0
    parts = []
    for row, piece in enumerate(pieces):
        low = origin + piece.start * length if row else -math.inf
        high = origin + piece.end * length + overlap if row + 1 < len(pieces) else math.inf
        band = [part for loop in loops if (part := _between(loop, frame, low, high)) is not None]
        if band:
            parts.append(Painted(band, *_paint(ramp, piece)))
    return parts


def _between(loop: Loop, frame: Array, low: float, high: float) -> Loop | None:
    """Return the part of ``loop`` whose first coordinate in ``frame`` [2, 2] is from ``low`` to ``high``."""
    whole = curves = curves_of(loop) @ frame.T
    if low > -math.inf:
        curves = cut_at(curves, 0, low, -1.0)
    if high < math.inf and len(curves):
        curves = cut_at(curves, 0, high, 1.0)
    if curves is whole:
        return loop
    if not len(curves):
        return None
    thirds = np.stack([(2.0 * curves[:, 0] + curves[:, 3]) / 3.0, (curves[:, 0] + 2.0 * curves[:, 3]) / 3.0], 1)
    is_line: NDArray[np.bool_] = np.all(np.abs(curves[:, 1:3] - thirds) < 1e-6, (1, 2))
    return Loop((curves[:, :3] @ frame).reshape(-1, 2), is_line)


def _discs(
    loops: list[Loop], ramp: ColorRamp, pieces: list[RampPiece], combiner: Combiner, omitted: Counter[str]
) -> list[Painted] | None:
    """Return the shape in the outermost colours of a radial ramp, and the discs on it; None if one cannot be cut."""
    rings = [_rings(piece) for piece in reversed(pieces)]
    steps = [step for ring, _ in rings for step in ring]
    parts = [Painted(loops, *_paint(ramp, steps[0]))]
    x, y, radius = ramp.geometry[:3]
    for step in steps[1:] if len(steps) <= MAX_BANDS else ():
        disc = disc_in(loops, x, y, radius * step.end, combiner)
        if disc is None:
            return None
        if disc:
            parts.append(Painted(disc, *_paint(ramp, step)))
    omitted["steep radial gradient"] += max(error for _, error in rings) > _RING_CLOSE
    return parts if len(steps) <= MAX_BANDS else None


def _rings(piece: RampPiece) -> tuple[list[RampPiece], float]:
    """Return parts, from the outside, that one disc each shows, and their largest difference from ``piece``.

    There are several if the colours change too fast for one disc.
    """
    for count in range(1, _RINGS_MAX + 1):
        edges = np.linspace(piece.start, piece.end, count + 1)
        rings = [_ring(piece, low, high) for low, high in pairwise(edges.tolist())]
        worst = max(error for _, error in rings)
        if worst <= _RING_CLOSE:
            break
    return [ring for ring, _ in reversed(rings)], worst


def _ring(piece: RampPiece, low: float, high: float) -> tuple[RampPiece, float]:
    """Return the part of ``piece`` from ``low`` to ``high`` as a disc can show it, and its largest difference."""
    slope = (piece.last - piece.first) / (piece.end - piece.start)
    ends = [piece.first + slope * (at - piece.start) for at in (low, high)]
    center = clipped(central(piece))
    middle = (low + high) / 2
    last = clipped(center + (sum(ends) / 2 - center) * high / middle)
    shown = RampPiece(0.0, high, center, last)
    return shown, max(difference(shown, at, color) for at, color in zip((low, high), ends, strict=True))


def _color(values: Array) -> Color:
    red, green, blue = values.tolist()
    return red, green, blue
