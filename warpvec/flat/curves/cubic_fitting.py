"""The host side of ``kernels/cubic_fitting.py``: cubics with given ends that are closest to rows of points."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warpvec.arrays import Floats
from warpvec.flat.constants.curves import CURVES
from warpvec.polish.machine import machine_of_thread, on_host, vectors_on_host


class Cubics(NamedTuple):
    """B cubics: handles [B, 2, 2], and the largest and the mean squared distance [B] from points to the cubic."""

    handles: Floats
    distance: Floats
    square: Floats


def fit_cubics(
    start: Floats, end: Floats, points: Floats, parameters: Floats, plan: tuple[int, float] = CURVES.fit_plan
) -> Cubics:
    """Return the cubics from ``start`` to ``end`` [B, 2] that are closest to ``points`` [B, S, 2], in squares.

    Args:
        start, end: ends of the cubics.
        points: points along each of them, in order.
        parameters: where along the cubic each point is about [B, S], in (0, 1); lengths over the whole length do.
        plan: rounds and the factor of steps, as ``CURVES.fit_plan`` has them.
    """
    return _fitted(start, end, None, points, parameters, plan)


def fit_lengths(start: Floats, end: Floats, directions: Floats, points: Floats, parameters: Floats) -> Cubics:
    """Return the closest cubics as `fit_cubics`, with handles along given directions.

    Args:
        start, end, points, parameters: as in `fit_cubics`.
        directions: unit vectors [B, 2, 2] of the first handle from ``start`` and of the second one from ``end``.
    """
    return _fitted(start, end, directions, points, parameters, CURVES.fit_plan)


def _fitted(
    start: Floats, end: Floats, directions: Floats | None, points: Floats, parameters: Floats, plan: tuple[int, float]
) -> Cubics:
    rows, count = parameters.shape
    handles, squares = np.empty((rows, 2, 2)), np.empty((rows, 2))
    if rows:
        ways = np.zeros((1, 2, 2)) if directions is None else directions
        vectors = [vectors_on_host(each) for each in (start, end, points, ways)]
        numbers = [int(directions is not None), *plan, CURVES.thirds_weight]
        places = np.array(parameters, np.float64, order="C")
        outputs = [on_host(places), vectors_on_host(handles), on_host(squares)]
        machine_of_thread().run("fit_rows", [rows, count, *vectors, *numbers, *outputs])
    # What is no number is as far as that: the largest of the squares would not tell.
    largest = np.where(np.isnan(squares[:, 1]), np.nan, squares[:, 0])
    return Cubics(handles, np.sqrt(largest), squares[:, 1])
