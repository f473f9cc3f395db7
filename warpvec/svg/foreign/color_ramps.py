"""The colours along a gradient, and the straight parts of which they consist."""

from __future__ import annotations

import math
from collections import Counter
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from warpvec.geometry.paints.kind import Geometry
from warpvec.geometry.paints.registry import ELLIPTIC, kind_of
from warpvec.svg.foreign.shapes import Loop, bounding_box, curves_of

LEVEL = 1.0 / 255.0
"""One of the levels of a channel of 8 bits."""

EXACT = 0.75 * LEVEL
"""Largest difference from a ramp that is not worth a remark."""

PERIODS_MAX = 32
"""Most repetitions of a ramp that are told apart."""

Array = NDArray[np.float64]


class ColorRamp(NamedTuple):
    """The colours along a gradient.

    Attributes:
        kind, geometry: as in `warpvec.geometry.gradients.Gradients`, in pixels.
        offsets: of its stops [K], not decreasing.
        colors: sRGB-encoded colours [K, 3], or colours and opacities [K, 4].
        spread: "pad", "repeat" or "reflect".
    """

    kind: int
    geometry: Geometry
    offsets: Array
    colors: Array
    spread: str = "pad"


class RampPiece(NamedTuple):
    """A straight part of a ramp."""

    start: float
    end: float
    first: Array
    last: Array


def shown_periods(ramp: ColorRamp, low: float, high: float) -> range:
    """Return which repetitions of ``ramp`` show from ``low`` to ``high``; none if it pads, or if there are too many."""
    first, last = math.floor(low), math.ceil(high)
    repeats = ramp.spread in ("repeat", "reflect") and last - first <= PERIODS_MAX
    return range(first, last) if repeats else range(0)


def unrolled(ramp: ColorRamp, low: float, high: float, omitted: Counter[str]) -> ColorRamp:
    """Return a ramp that pads and is the same from ``low`` to ``high``."""
    periods = shown_periods(ramp, low, high)
    if not periods:
        omitted["repeating gradient"] += ramp.spread in ("repeat", "reflect")
        return ramp
    offsets = np.concatenate([[0.0], ramp.offsets, [1.0]])
    colors = np.concatenate([ramp.colors[:1], ramp.colors, ramp.colors[-1:]])
    turns = [ramp.spread == "reflect" and period % 2 == 1 for period in periods]
    forth, back = offsets, 1.0 - offsets[::-1]
    places = [periods[0] + period + (back if turn else forth) for period, turn in enumerate(turns)]
    shades = [colors[::-1] if turn else colors for turn in turns]
    return ramp._replace(offsets=np.concatenate(places), colors=np.concatenate(shades))


def linear_range(loops: list[Loop], geometry: tuple[float, ...], size: tuple[float, float]) -> tuple[float, float]:
    """Return the least and the largest offset that the visible part of a shape may show."""
    start, along = np.array(geometry[:2]), np.subtract(geometry[2:4], geometry[:2])
    along = along / (along @ along)
    curves = np.concatenate([curves_of(loop) for loop in loops])
    offsets = (curves - start) @ along
    low, _, high, _ = bounding_box(np.stack([offsets, offsets], -1))
    corners = (_corners(0.0, 0.0, *size) - start) @ along
    inner = max(low, float(corners.min())), min(high, float(corners.max()))
    return inner if inner[0] < inner[1] else (low, high)


def elliptic_range(loops: list[Loop], geometry: tuple[float, ...], size: tuple[float, float]) -> tuple[float, float]:
    """Return 0 and the largest offset that the visible part of a shape in an ellipse may show."""
    left, top, right, bottom = bounding_box(np.concatenate([curves_of(loop) for loop in loops]))
    box = max(left, 0.0), max(top, 0.0), min(right, size[0]), min(bottom, size[1])
    seen = box if box[0] < box[2] and box[1] < box[3] else (left, top, right, bottom)
    x, y = _corners(*seen).T
    return 0.0, float(kind_of(ELLIPTIC).share(np.array(geometry), x, y).max())


def radial_range(loops: list[Loop], geometry: tuple[float, ...], size: tuple[float, float]) -> tuple[float, float]:
    """Return the least and the largest offset, distances from the centre, that the visible part may show."""
    center, radius = np.array(geometry[:2]), geometry[2]
    curves = np.concatenate([curves_of(loop) for loop in loops])
    left, top, right, bottom = bounding_box(curves)
    box = np.array([max(left, 0.0), max(top, 0.0), min(right, size[0]), min(bottom, size[1])])
    if (box[2:] <= box[:2]).any():
        box = np.array([left, top, right, bottom])
    near = np.clip(center, box[:2], box[2:])
    far = np.hypot(*(_corners(*box.tolist()) - center).T).max()
    reach = np.hypot(*(curves.reshape(-1, 2) - center).T).max()
    return float(np.hypot(*(near - center))) / radius, float(min(far, reach)) / radius


def _corners(left: float, top: float, right: float, bottom: float) -> Array:
    return np.array([[left, top], [right, top], [right, bottom], [left, bottom]])


def straight_pieces(ramp: ColorRamp, low: float, high: float) -> list[RampPiece]:
    """Return the straight parts of ``ramp`` between ``low`` and ``high``.

    A flat part at either end is left out where padding with the next colour draws the same. The part around the centre
    of a ramp without a free start is kept.
    """
    offsets = np.concatenate([[min(low, ramp.offsets[0])], ramp.offsets, [max(high, ramp.offsets[-1])]])
    colors = np.concatenate([ramp.colors[:1], ramp.colors, ramp.colors[-1:]])
    margin = 1e-9 * max(high - low, 1e-9)
    pieces = [
        RampPiece(float(a), float(b), colors[row], colors[row + 1])
        for row, (a, b) in enumerate(pairwise(offsets))
        if b > a and b > low + margin and a < high - margin
    ]
    if not pieces:
        return [RampPiece(low, high, ramp.colors[-1], ramp.colors[-1])]
    if len(pieces) > 1 and kind_of(ramp.kind).has_free_start and _is_flat(pieces[0]) and _joins(pieces[0], pieces[1]):
        pieces.pop(0)
    if len(pieces) > 1 and _is_flat(pieces[-1]) and _joins(pieces[-2], pieces[-1]):
        pieces.pop()
    return pieces


def _is_flat(piece: RampPiece) -> bool:
    return bool((piece.first == piece.last).all())


def _joins(before: RampPiece, after: RampPiece) -> bool:
    return bool((before.last == after.first).all())


def merged_pieces(pieces: list[RampPiece]) -> list[RampPiece]:
    """Join neighbouring ``pieces`` that one straight part shows."""
    starts, firsts = np.array([piece.start for piece in pieces]), np.array([piece.first for piece in pieces])
    merged, run = [pieces[0]], 1
    for row, piece in enumerate(pieces[1:], 1):
        last = merged[-1]
        longer = RampPiece(last.start, piece.end, last.first, piece.last)
        if _joins(last, piece) and difference(longer, starts[run : row + 1], firsts[run : row + 1]) <= EXACT:
            merged[-1] = longer
        else:
            merged.append(piece)
            run = row + 1
    return merged


def difference(piece: RampPiece, places: Array | float, colors: Array) -> float:
    """Return the largest difference of ``piece`` at ``places`` [K] from ``colors`` [K, 3]."""
    share = (np.reshape(places, (-1, 1)) - piece.start) / (piece.end - piece.start)
    return float(np.abs((1.0 - share) * piece.first + share * piece.last - colors).max())


def central(piece: RampPiece) -> Array:
    """Return the colour in the centre that goes on from a part of a radial ramp."""
    return piece.first - (piece.last - piece.first) * piece.start / (piece.end - piece.start)


def clipped(color: Array) -> Array:
    """Return ``color`` with channels in [0, 1]."""
    return np.clip(color, 0.0, 1.0)
