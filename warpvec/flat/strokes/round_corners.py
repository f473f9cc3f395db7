"""Round the corners of a centre line, so that the fit to the picture can tell how much."""

from __future__ import annotations

import numpy as np

from warpvec.arrays import Floats, Mask
from warpvec.flat.constants.strokes import STROKES
from warpvec.flat.simplification.outline_samples import cubic_points
from warpvec.flat.strokes.line_fitting import Rows, corner_turns, curves_of

_CHORDS = 32
"""Chords of a curve whose lengths are added."""

_HANDLE = 0.55
"""Length of the handles of a quarter of a circle, in radii."""


def corners_of(rows: Rows) -> Mask:
    """Return which curves [S] of a centre line begin at a corner."""
    is_corner = corner_turns(curves_of(rows)) > STROKES.corner_degrees
    is_corner[0] &= not rows.is_open
    return is_corner


def with_round_corners(rows: Rows, is_corner: Mask, width: float) -> Rows:
    """Return a centre line of a stroke of ``width`` pixels, with short cubics in place of some corners [S]."""
    if not is_corner.any():
        return rows
    curves = curves_of(rows)
    shares = _shares(curves, is_corner, STROKES.round_reach * width)
    parts = [_part(curve, first, last) for curve, (first, last) in zip(curves, shares, strict=True)]
    control, is_line = [], []
    for k, part in enumerate(parts):
        if is_corner[k]:
            control.append(_corner(parts[k - 1][3], curves[k, 0], part[0]))
            is_line.append(False)
        control.append(part[:3])
        is_line.append(bool(rows.is_line[k]))
    if rows.is_open:
        control.append(rows.control[-1])
        is_line.append(True)
    return Rows(np.stack(control), np.array(is_line), rows.is_open)


def _shares(curves: Floats, is_corner: Mask, reach: float) -> Floats:
    """Return from where to where each curve is kept [S, 2], as its parameter: corners take up to ``reach`` pixels."""
    found = np.tile([0.0, 1.0], (len(curves), 1))
    at_end = np.roll(is_corner, -1)
    t = np.linspace(0.0, 1.0, _CHORDS + 1)
    for k, curve in enumerate(curves):
        steps = np.linalg.norm(np.diff(cubic_points(curve, t), axis=0), axis=1)
        along = np.concatenate([[0.0], np.cumsum(steps)])
        cut = min(reach, STROKES.round_share * along[-1])
        if is_corner[k]:
            found[k, 0] = np.interp(cut, along, t)
        if at_end[k]:
            found[k, 1] = np.interp(along[-1] - cut, along, t)
    return found


def _part(curve: Floats, first: float, last: float) -> Floats:
    """Return the part of a cubic [4, 2] between two parameters."""
    start = curve.copy()
    for k in (1, 2, 3):
        start[k:] = start[k - 1 : -1] * (1.0 - last) + start[k:] * last
    left, share = start.copy(), first / last
    for k in (1, 2, 3):
        left[: 4 - k] = left[: 4 - k] * (1.0 - share) + left[1 : 5 - k] * share
    return left


def _corner(start: Floats, corner: Floats, end: Floats) -> Floats:
    """Return the row [3, 2] of a cubic from ``start`` to ``end`` that is drawn to the ``corner``."""
    return np.stack([start, start + _HANDLE * (corner - start), end + _HANDLE * (corner - end)])
