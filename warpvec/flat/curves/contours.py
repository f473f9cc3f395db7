"""Closed contours of a field of coverage, as precise as its anti-aliased pixels are."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec.arrays import Floats, Mask, blocks
from warpvec.flat.constants.curves import CURVES

_LOOP_MIN = 3


def contours_of(coverage: NDArray[Any]) -> list[Floats]:
    """Return the closed contours [n, 2] of a field of ``coverage`` [h, w] in [0, 1], in pixels, x right, y down.

    Beyond the picture the field is 0, so contours end at its border. Holes run the other way. Along a straight edge the
    points are exact: a point of a contour in the centre of a row of pixels lies where the sum of their coverage says
    that the edge crosses the row on average; accordingly in columns. Marching squares, which only interpolate, are off
    by up to 0.1 px.
    """
    from contourpy import contour_generator

    margin = CURVES.contour_reach + 1
    field = np.pad(coverage.astype(np.float64), margin)
    height, width = field.shape
    # With corners of pixels on whole numbers, their centres lie at + 0.5.
    loops = contour_generator(x=np.arange(width), y=np.arange(height), z=field).lines(CURVES.contour_level)
    found = (_refined(field, np.asarray(loop)[:-1]) for loop in loops if len(loop) > _LOOP_MIN)
    limit = np.array(coverage.shape[::-1], np.float64)
    return [np.clip(loop + (0.5 - margin), 0.0, limit) for loop in found]


def interpolated_contours(field: NDArray[np.float64], margin: int, fineness: int = 1) -> list[Floats]:
    """Return the closed contours [n, 2] where a ``field``, interpolated between its values, is a half, in pixels.

    Args:
        field: values [f (h + 2 margin), f (w + 2 margin)], with ``margin`` pixels around the picture [h, w].
        margin: those pixels.
        fineness: f, values along the side of a pixel.
    """
    from contourpy import contour_generator

    limit = np.array(field.shape[::-1], np.float64) / fineness - 2 * margin
    loops: list[Any] = list(contour_generator(z=field).lines(CURVES.contour_level))
    # The first value stands for the centre of its part of a pixel.
    first = 0.5 / fineness - margin
    return [np.clip(loop[:-1] / fineness + first, 0.0, limit) for loop in loops if len(loop) > _LOOP_MIN]


def signed_area(loop: Floats) -> float:
    """Return the area in square pixels that a polyline [n, 2] encloses; its sign says which way it runs."""
    following = np.roll(loop, -1, axis=0)
    return float((loop[:, 0] * following[:, 1] - loop[:, 1] * following[:, 0]).sum() / 2.0)


def _refined(field: Floats, loop: Floats) -> Floats:
    """Return the vertices [m, 2] of a ``loop`` [n, 2] that count, in their precise places, in pixel centres."""
    found = [_placed(field, loop[part]) for part in blocks(len(loop), CURVES.samples_at_once)]
    refined, counts = (np.concatenate(values) for values in zip(*found, strict=True))
    return refined[counts] if counts.sum() > _LOOP_MIN and counts.mean() > CURVES.vertex_share_min else refined


def _placed(field: Floats, vertices: Floats) -> tuple[Floats, Mask]:
    """Return the precise places of ``vertices`` [n, 2], and which of them count."""
    whole = vertices == np.floor(vertices)
    across, is_across = _crossing(field, vertices[:, 1], vertices[:, 0])
    down, is_down = _crossing(field.T, vertices[:, 0], vertices[:, 1])
    in_row = whole[:, 1] & (~whole[:, 0] | is_across)
    x, y = np.where(in_row, across, vertices[:, 0]), np.where(in_row, vertices[:, 1], down)
    return np.stack([x, y], 1), np.where(in_row, is_across, is_down)


def _crossing(field: Floats, row: Floats, place: Floats) -> tuple[Floats, Mask]:
    """Return where an edge crosses ``row`` [n] near ``place`` [n], and whether the edge is rather across than along it.

    Rows that are not whole numbers get values without meaning.
    """
    height, width = field.shape
    r = np.clip(np.rint(row), 1, height - 2).astype(np.int64)
    c = np.clip(np.floor(place), CURVES.contour_reach, width - 2 - CURVES.contour_reach).astype(np.int64)
    values = field[r[:, None], c[:, None] + np.arange(-CURVES.contour_reach, CURVES.contour_reach + 2)]
    is_falling = values[:, CURVES.contour_reach] > values[:, CURVES.contour_reach + 1]
    values = np.where(is_falling[:, None], values, 1.0 - values)  # now covered on the left
    left = _to_saturation(values[:, CURVES.contour_reach :: -1])
    right = 1.0 - _to_saturation(1.0 - values[:, CURVES.contour_reach + 1 :])
    edge = c - CURVES.contour_reach - 0.5 + left.sum(1) + right.sum(1)
    along = np.abs(field[r, c] - field[r, c + 1])
    above = field[r + 1, c] + field[r + 1, c + 1] - field[r - 1, c] - field[r - 1, c + 1]
    return edge, along >= CURVES.vertex_dominance * np.abs(above) / 4.0


def _to_saturation(values: Floats) -> Floats:
    """Return ``values`` [n, k], going away from an edge into the shape, where they rise to 1, else 1 after the first.

    A shape of a few pixels' width has its other edge there, which is none of this one's concern.
    """
    rises = (np.diff(values, axis=1) >= -1e-6).all(1) & (values[:, -1] >= CURVES.saturated)
    beyond = np.where(rises[:, None], values[:, 1:], 1.0)
    return np.concatenate([values[:, :1], beyond], 1)
