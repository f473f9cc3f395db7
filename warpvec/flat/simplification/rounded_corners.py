"""Make the rounded corners between two lines true arcs, with one radius where they nearly have."""

from __future__ import annotations

import numpy as np

from warpvec.arrays import Floats, Integers, Mask
from warpvec.flat.constants.simplification import SIMPLIFICATION
from warpvec.flat.simplification.straight_lines import groups


def rounded_corners(
    control: Floats, is_line: Mask, following: Integers, preceding: Integers, loop: Integers
) -> tuple[Floats, Floats, Floats, Mask]:
    """Return anchors, leaving and arriving handles [R, 2] of a scene with true arcs between lines, and which arcs [R].

    Args:
        control: control points [R, 4, 2] of all segments.
        is_line: which are lines [R].
        following, preceding: the row after and before each [R].
        loop: the loop of each [R].
    """
    anchor, leaving = control[:, 0].copy(), control[:, 1] - control[:, 0]
    arriving = (control[:, 2] - control[:, 3])[preceding]
    rows, corner, u, v, turn, reach = _arcs(control, is_line, following, preceding)
    half = np.tan(turn / 2.0)
    reach = (_alike(reach / half, loop[rows]) * half)[:, None]
    handle = reach * (4.0 / 3.0 * np.tan(turn / 4.0) / half)[:, None]
    anchor[rows], anchor[following[rows]] = corner - reach * u, corner + reach * v
    leaving[rows], arriving[following[rows]] = handle * u, -handle * v
    arcs = np.zeros(len(control), np.bool_)
    arcs[rows] = True
    return anchor, leaving, arriving, arcs


def _arcs(
    control: Floats, is_line: Mask, following: Integers, preceding: Integers
) -> tuple[Integers, Floats, Floats, Floats, Floats, Floats]:
    """Return the curves between two lines that are nearly arcs.

    Returns:
        their rows [K], the corner of both lines [K, 2], the lines' directions [K, 2], the angle between these in
        radians [K], and the mean distance of both ends from the corner [K].
    """
    rows = np.flatnonzero(~is_line & is_line[following] & is_line[preceding] & (following != preceding))
    before, after = control[preceding[rows]], control[following[rows]]
    u, v = _unit(before[:, 3] - before[:, 0]), _unit(after[:, 3] - after[:, 0])
    sine = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    turn = np.arctan2(np.abs(sine), (u * v).sum(1))
    offset = after[:, 0] - before[:, 3]
    safe = np.where(np.abs(sine) < 1e-9, 1.0, sine)
    first = (offset[:, 0] * v[:, 1] - offset[:, 1] * v[:, 0]) / safe
    second = (offset[:, 1] * u[:, 0] - offset[:, 0] * u[:, 1]) / safe
    is_arc = (
        (np.degrees(turn) >= SIMPLIFICATION.arc_turn_min)
        & (np.degrees(turn) <= SIMPLIFICATION.arc_turn_max)
        & (first > 0.0)
        & (second > 0.0)
    )
    is_arc &= np.abs(first - second) <= SIMPLIFICATION.arc_unequal_max
    control = control[rows]
    is_arc &= _is_along(control[:, 1] - control[:, 0], u) & _is_along(control[:, 3] - control[:, 2], v)
    corner, reach = before[:, 3] + first[:, None] * u, (first + second) / 2.0
    return rows[is_arc], corner[is_arc], u[is_arc], v[is_arc], turn[is_arc], reach[is_arc]


def _alike(radius: Floats, loop: Integers) -> Floats:
    """Return the radii [K] with nearly equal ones of a ``loop`` [K] equal."""
    result = radius.copy()
    for each in np.unique(loop):
        rows = np.flatnonzero(loop == each)
        for group in groups(radius[rows], SIMPLIFICATION.arc_radii_alike):
            result[rows[group]] = radius[rows[group]].mean()
    return result


def _is_along(handle: Floats, direction: Floats) -> Mask:
    return (_unit(handle) * direction).sum(1) > np.cos(np.radians(SIMPLIFICATION.arc_smooth_degrees))


def _unit(vectors: Floats) -> Floats:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9)
