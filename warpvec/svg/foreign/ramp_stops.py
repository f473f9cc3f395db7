"""The stops of a ramp, and fewer stops that show nearly the same."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from warpvec.geometry.stops import STOPS_MAX
from warpvec.svg.foreign.color_ramps import Array, RampPiece


class RampStop(NamedTuple):
    """A stop: its offset, and its colour [3], or its colour and opacity [4]."""

    offset: float
    color: Array


def ramp_stops(pieces: Sequence[RampPiece]) -> list[RampStop]:
    """Return the stops of neighbouring ``pieces``; where two do not meet there are two stops with one offset.

    A stop at either end whose neighbour has its colour is left out, as the ends go on.
    """
    stops = [RampStop(pieces[0].start, pieces[0].first)]
    for piece in pieces:
        if not np.array_equal(stops[-1].color, piece.first):
            stops.append(RampStop(piece.start, piece.first))
        stops.append(RampStop(piece.end, piece.last))
    for first, second in ((0, 1), (-1, -2)):
        if len(stops) > 2 and np.array_equal(stops[first].color, stops[second].color):
            stops.pop(first)
    return stops


def reduced_stops(stops: Sequence[RampStop], most: int = STOPS_MAX) -> list[RampStop]:
    """Return at most so many of the ``stops``: those go first that a straight line between the others shows best."""
    left = list(stops)
    while len(left) > most:
        costs = [_missing(*left[row - 1 : row + 2]) for row in range(1, len(left) - 1)]
        left.pop(1 + int(np.argmin(costs)))
    return left


def _missing(before: RampStop, stop: RampStop, after: RampStop) -> float:
    """Return what a ramp loses without a ``stop``: its difference from a straight line, times the length of that."""
    width = after.offset - before.offset
    share = (stop.offset - before.offset) / width if width > 0.0 else 0.5
    between = before.color + share * (after.color - before.color)
    return float(np.abs(stop.color - between).max()) * width
