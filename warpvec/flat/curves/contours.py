"""Closed contours of a field of coverage, as precise as its anti-aliased pixels are."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Mask = NDArray[np.bool_]

LEVEL = 0.5
"""Coverage of a pixel whose centre the contour passes."""

SATURATED = 0.95
"""An edge ends at the first pixel that is covered at least so much, or at most 1 less this."""

REACH = 2
"""Pixels beyond the crossing that an edge may take on either side: at 45 degrees it covers two in all."""

DOMINANCE = 0.8
"""A vertex counts if the field changes along its grid line at least by so much of its change across it. The others are
less precise, and beside each of them is one that counts."""

COUNTING_MIN = 0.25
"""Least share of vertices that count; a contour with fewer is a speck, of which all are kept."""

_LOOP_MIN = 3


def contours_of(coverage: NDArray[Any]) -> list[Floats]:
    """Return the closed contours [n, 2] of a field of ``coverage`` [h, w] in [0, 1], in pixels, x right, y down.

    Beyond the picture the field is 0, so contours end at its border. Holes run the other way. Along a straight edge the
    points are exact: a point of a contour in the centre of a row of pixels lies where the sum of their coverage says
    that the edge crosses the row on average; accordingly in columns. Marching squares, which only interpolate, are off
    by up to 0.1 px.
    """
    from contourpy import contour_generator

    margin = REACH + 1
    field = np.pad(coverage.astype(np.float64), margin)
    height, width = field.shape
    # With corners of pixels on whole numbers, their centres lie at + 0.5.
    loops = contour_generator(x=np.arange(width), y=np.arange(height), z=field).lines(LEVEL)
    found = (_refined(field, np.asarray(loop)[:-1]) for loop in loops if len(loop) > _LOOP_MIN)
    limit = np.array(coverage.shape[::-1], np.float64)
    return [np.clip(loop + (0.5 - margin), 0.0, limit) for loop in found]


def _refined(field: Floats, loop: Floats) -> Floats:
    """Return the vertices [m, 2] of a ``loop`` [n, 2] that count, in their precise places, in pixel centres."""
    whole = loop == np.floor(loop)
    across, is_across = _crossing(field, loop[:, 1], loop[:, 0])
    down, is_down = _crossing(field.T, loop[:, 0], loop[:, 1])
    in_row = whole[:, 1] & (~whole[:, 0] | is_across)
    x, y = np.where(in_row, across, loop[:, 0]), np.where(in_row, loop[:, 1], down)
    counts, refined = np.where(in_row, is_across, is_down), np.stack([x, y], 1)
    return refined[counts] if counts.sum() > _LOOP_MIN and counts.mean() > COUNTING_MIN else refined


def _crossing(field: Floats, row: Floats, place: Floats) -> tuple[Floats, Mask]:
    """Return where an edge crosses ``row`` [n] near ``place`` [n], and whether the edge is rather across than along it.

    Rows that are not whole numbers get values without meaning.
    """
    height, width = field.shape
    r = np.clip(np.rint(row), 1, height - 2).astype(np.int64)
    c = np.clip(np.floor(place), REACH, width - 2 - REACH).astype(np.int64)
    values = field[r[:, None], c[:, None] + np.arange(-REACH, REACH + 2)]
    is_falling = values[:, REACH] > values[:, REACH + 1]
    values = np.where(is_falling[:, None], values, 1.0 - values)  # now covered on the left
    left = _to_saturation(values[:, REACH::-1])
    right = 1.0 - _to_saturation(1.0 - values[:, REACH + 1 :])
    edge = c - REACH - 0.5 + left.sum(1) + right.sum(1)
    along = np.abs(field[r, c] - field[r, c + 1])
    above = field[r + 1, c] + field[r + 1, c + 1] - field[r - 1, c] - field[r - 1, c + 1]
    return edge, along >= DOMINANCE * np.abs(above) / 4.0


def _to_saturation(values: Floats) -> Floats:
    """Return ``values`` [n, k], going away from an edge into the shape, where they rise to 1, else 1 after the first.

    A shape of a few pixels' width has its other edge there, which is none of this one's concern.
    """
    rises = (np.diff(values, axis=1) >= -1e-6).all(1) & (values[:, -1] >= SATURATED)
    beyond = np.where(rises[:, None], values[:, 1:], 1.0)
    return np.concatenate([values[:, :1], beyond], 1)
