"""Outlines in pictures of two levels: slopes in place of staircases, but the corners that are meant."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats, Integers, Mask
from warpvec.flat.constants.mono import MONO
from warpvec.flat.curves.contours import interpolated_contours

_CONVEX, _CONCAVE = 1, 3
"""Pixels of ink around the point where four pixels meet, at a corner of ink and at one of paper."""


_CUT = 0.55
"""Largest distance, along the axes together, of a square corner from both ends of the chord that cuts it off."""


def staircase_outlines(coverage: Floats) -> list[Floats]:
    """Return the closed outlines [n, 2] of the ink in a picture of two levels with ``coverage`` [h, w], in pixels.

    A blur makes slopes of staircases. It would round off the ends of strokes, so square corners are left out of it.
    """
    is_square = square_corners(coverage > 0.5)
    around = is_square[:-1, :-1] | is_square[:-1, 1:] | is_square[1:, :-1] | is_square[1:, 1:]
    field = np.where(around, coverage, ndimage.gaussian_filter(coverage, MONO.staircase_blur))
    field += _joining(field, coverage > 0.5)
    for _ in range(MONO.ink_rounds if coverage.size <= MONO.ink_pixels_max else 0):
        field += _missing_ink(field, coverage)
    return [_with_corners(outline, is_square) for outline in interpolated_contours(np.pad(field, 1), 1)]


def _missing_ink(field: Floats, coverage: Floats) -> Floats:
    """Return what to add to ``field`` [h, w] where its contour has less ink than the ``coverage`` [h, w], or more.

    Blur takes ink from dots and thin lines, and closes narrow gaps. What a few steps of a staircase lack, others have.
    """
    missing = ndimage.gaussian_filter(coverage - _inside_contour(field), MONO.ink_reach)
    beyond = np.maximum(np.abs(missing) - MONO.ink_missing_min, 0.0)
    return np.asarray(MONO.ink_gain * np.copysign(beyond, missing))


def _inside_contour(field: Floats) -> Floats:
    """Return the share of each pixel [h, w] in which ``field``, interpolated between pixels, is over a half."""
    shape, side = field.shape, MONO.ink_samples
    rows, columns = (np.clip((np.arange(side * size) + 0.5) / side - 0.5, 0.0, size - 1.0) for size in shape)
    upper, left = (places.astype(np.int64) for places in (rows, columns))
    down, right = (rows - upper)[:, None], columns - left
    between = field[upper] + down * (field[np.minimum(upper + 1, shape[0] - 1)] - field[upper])
    values = between[:, left] + right * (between[:, np.minimum(left + 1, shape[1] - 1)] - between[:, left])
    return (values > 0.5).reshape(shape[0], side, shape[1], side).mean((1, 3))


def _joining(field: Floats, ink: Mask) -> Floats:
    """Return what to add to ``field`` [h, w] to join two pixels of a line of ``ink`` that touch at a corner alone.

    A contour joins them if the mean of the four pixels around the corner is over a half. Where most is ink, the line is
    one of paper.
    """
    is_touching = (ink[:-1, :-1] == ink[1:, 1:]) & (ink[:-1, 1:] == ink[1:, :-1]) & (ink[:-1, :-1] != ink[:-1, 1:])
    share = ndimage.uniform_filter(ink.astype(np.float64), MONO.joint_window)
    row, column = np.nonzero(is_touching)
    places = [(row, column), (row, column + 1), (row + 1, column), (row + 1, column + 1)]
    sign = np.where(share[places[0]] + share[places[3]] < 1.0, 1.0, -1.0)
    lacking = np.maximum(MONO.joint_level - sign * (np.mean([field[place] for place in places], 0) - 0.5), 0.0)
    more, less = np.zeros(field.shape), np.zeros(field.shape)
    for place in places:
        np.maximum.at(more, place, np.where(sign > 0.0, lacking, 0.0))
        np.maximum.at(less, place, np.where(sign < 0.0, lacking, 0.0))
    return more - less


def _with_corners(outline: Floats, is_square: Mask) -> Floats:
    """Return ``outline`` [n, 2] with the corners at the points ``is_square`` [h + 1, w + 1] that its chords cut off."""
    following = np.roll(outline, -1, axis=0)
    corner = np.rint((outline + following) / 2)
    is_near = np.maximum(np.abs(outline - corner).sum(1), np.abs(following - corner).sum(1)) <= _CUT
    is_chord = np.abs(outline - following).min(1) > 0.0
    column, row = corner.astype(np.int64).T
    cut_off = np.flatnonzero(is_near & is_chord & is_square[row, column])
    return np.insert(outline, cut_off + 1, corner[cut_off], axis=0)


def square_corners(ink: Mask) -> Mask:
    """Return at which points between the pixels of ``ink`` [h, w] a square corner is meant [h + 1, w + 1].

    Its two edges are long, or one is, and the other is an end of a stroke: it turns the same way at both of its ends. A
    step of a staircase turns one way and the other.
    """
    padded = np.pad(ink, 1).astype(np.int64)
    turn = padded[:-1, :-1] + padded[:-1, 1:] + padded[1:, :-1] + padded[1:, 1:]
    length, is_end = _edges(padded, turn)
    other_length, other_is_end = (values.T for values in _edges(padded.T, turn.T))
    is_corner = (turn == _CONVEX) | (turn == _CONCAVE)
    is_long, other_is_long = length >= MONO.long_edge, other_length >= MONO.long_edge
    return np.asarray(is_corner & (is_long | is_end) & (other_is_long | other_is_end) & (is_long | other_is_long))


def _edges(padded: Integers, turn: Integers) -> tuple[Integers, Mask]:
    """Return the length of the level edge that ends at each point [h + 1, w + 1], and whether it is an end of a stroke.

    Args:
        padded: 1 where ink is, with a pixel of paper around it [h + 2, w + 2].
        turn: pixels of ink around each point [h + 1, w + 1].
    """
    side = np.diff(padded, axis=0)  # [h + 1, w + 2]; what is between two points of a row has the column of the second
    is_start = (side != 0) & (side != np.roll(side, 1, 1))
    is_stop = (side != 0) & (side != np.roll(side, -1, 1))
    (row, first), (_, last) = np.nonzero(is_start), np.nonzero(is_stop)
    same_turn = (turn[row, first - 1] == turn[row, last]) & (turn[row, last] != 2)
    length, is_end = np.zeros(turn.shape, np.int64), np.zeros(turn.shape, bool)
    for column in (first - 1, last):
        length[row, column] = last - first + 1
        is_end[row, column] = same_turn
    return length, is_end
