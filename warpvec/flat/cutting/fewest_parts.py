"""Say outlines with few parts: one curve or line takes the place of neighbours that it follows closely.

Where outlines of two paths nearly coincide, or slivers went to their neighbours, an edge is a row of short parts.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from warpvec.arrays import Floats, Integers, Mask, counted
from warpvec.flat.constants.cutting import CUTTING
from warpvec.flat.curves.cubic_fitting import fit_cubics
from warpvec.watch.watch import UNWATCHED, Watch

_RATIO_MAX = 4.0
"""Largest factor by which handles may say another ratio of two parts than their lengths: tiny handles say nothing."""


class CurvePart(NamedTuple):
    """A part of a curve: its control points [4, 2] in pixels, and whether it is a line."""

    cubic: Floats
    is_line: bool

    def reversed(self) -> CurvePart:
        """Return it from its end to its start."""
        return CurvePart(self.cubic[::-1], self.is_line)


def fewest_parts(chains: list[list[CurvePart]], watch: Watch = UNWATCHED) -> list[list[CurvePart]]:
    """Return ``chains`` of consecutive parts, each with as few as stay within ``CUTTING.joined_error`` of it.

    The ends of chains stay. Parts that are not joined stay as they are, and so do all once the ``watch`` is over.
    """
    parts = [part for chain in chains for part in chain]
    counts = np.array([len(chain) for chain in chains], np.int64)
    if not len(parts) or watch.is_over():
        return chains
    left = np.repeat(counts, counts) - counted(counts)
    joints = _joints(np.stack([part.cubic for part in parts]), np.array([part.is_line for part in parts]), left)
    starts = np.cumsum(counts) - counts
    return [_shortest(parts, joints, *place) for place in zip(starts.tolist(), counts.tolist(), strict=True)]


_Joints = dict[tuple[int, int], CurvePart]
"""What replaces parts, by the first of them and their number."""


def _joints(cubics: Floats, is_line: Mask, left: Integers) -> _Joints:
    """Return the parts that may replace two or more of ``cubics`` [P, 4, 2].

    Args:
        is_line: which of them are lines [P].
        left: number of parts from each to the end of its chain [P].
    """
    found: _Joints = {}
    can_join = np.ones(len(cubics), bool)
    for size in range(2, CUTTING.joined_max + 1):
        # Where fewer do not join, more do not.
        rows = np.flatnonzero((left >= size) & can_join & np.append(can_join[1:], False))
        can_join = np.zeros(len(cubics), bool)
        if not len(rows):
            break
        members = rows[:, None] + np.arange(size)
        handles, straight, close = _fitted(cubics[members], is_line[members].all(1))
        can_join[rows[close]] = True
        for row, pair, line in zip(rows[close].tolist(), handles[close], straight[close].tolist(), strict=True):
            found[row, size] = CurvePart(np.stack([cubics[row, 0], *pair, cubics[row + size - 1, 3]]), line)
    return found


def _fitted(rows: Floats, are_lines: Mask) -> tuple[Floats, Mask, Mask]:
    """Return handles [B, 2, 2] for ``rows`` [B, k, 4, 2], which are lines [B], and which are close enough [B]."""
    start, end = rows[:, 0, 0], rows[:, -1, 3]
    points, share = _samples(rows)
    chord = end - start
    square = (chord**2).sum(1)[:, None] + 1e-12
    along = np.clip(((points - start[:, None]) * chord[:, None]).sum(2) / square, 0.0, 1.0)
    off = np.hypot(*np.moveaxis(start[:, None] + along[..., None] * chord[:, None] - points, 2, 0)).max(1)
    is_straight = off <= CUTTING.joined_error
    curves = fit_cubics(start, end, points, share)
    is_close = is_straight | (~are_lines & (curves.distance <= CUTTING.joined_error))
    thirds = np.stack([start + chord / 3.0, start + chord * (2.0 / 3.0)], 1)
    return np.where(is_straight[:, None, None], thirds, curves.handles), is_straight, is_close


def _samples(rows: Floats) -> tuple[Floats, Floats]:
    """Return the nodes of ``rows`` [B, k, 4, 2] and points at equal steps [B, S, 2], and parameters to begin with."""
    number = CUTTING.joined_samples
    t = np.linspace(0.0, 1.0, number + 1)[:-1]
    basis = np.stack([(1 - t) ** 3, 3 * (1 - t) ** 2 * t, 3 * (1 - t) * t**2, t**3], 1)
    line = np.concatenate([(basis @ rows).reshape(len(rows), -1, 2), rows[:, -1, 3:]], 1)
    walked = np.hypot(*np.moveaxis(np.diff(line, axis=1), 2, 0)).cumsum(1)
    walked = np.concatenate([np.zeros((len(rows), 1)), walked], 1)
    first = _first_parameters(rows, np.diff(walked[:, ::number], axis=1))
    begun = np.concatenate(
        [(first[:, :-1, None] + np.diff(first)[..., None] * t).reshape(len(rows), -1), first[:, -1:]], 1
    )
    steps = np.linspace(0.0, 1.0, number + 1)[1:-1] * walked[:, -1:]
    places = np.sort(np.concatenate([steps, walked[:, number:-1:number]], 1), 1)
    values = np.concatenate([line, begun[..., None]], 2)
    found = np.array(
        [
            [np.interp(place, far, axis) for axis in each.T]
            for place, far, each in zip(places, walked, values, strict=True)
        ]
    )
    return np.moveaxis(found[:, :2], 1, 2), found[:, 2]


def _first_parameters(rows: Floats, length: Floats) -> Floats:
    """Return the parameters of one curve at the nodes [B, k + 1] of ``rows``, which are ``length`` [B, k] long.

    Parts of one curve have handles in the ratio of their shares of its parameter.
    """
    leaving = np.hypot(*np.moveaxis(rows[:, 1:, 1] - rows[:, 1:, 0], 2, 0))
    arriving = np.hypot(*np.moveaxis(rows[:, :-1, 3] - rows[:, :-1, 2], 2, 0))
    by_length = np.maximum(length[:, 1:], 1e-9) / np.maximum(length[:, :-1], 1e-9)
    ratio = np.clip(leaving / np.maximum(arriving, 1e-9), by_length / _RATIO_MAX, by_length * _RATIO_MAX)
    shares = np.concatenate([np.ones((len(rows), 1)), ratio.cumprod(1)], 1)
    return np.concatenate([np.zeros((len(rows), 1)), shares.cumsum(1) / shares.sum(1, keepdims=True)], 1)


def _shortest(parts: list[CurvePart], joints: _Joints, start: int, count: int) -> list[CurvePart]:
    """Return the fewest parts of a chain of ``count`` parts from ``start`` on."""
    fewest, sizes = [0], [0]  # the number of parts up to each place, and how many parts the last of them replaces
    for stop in range(1, count + 1):
        joined = (size for size in range(2, min(CUTTING.joined_max, stop) + 1) if (start + stop - size, size) in joints)
        sizes.append(min((1, *joined), key=lambda size: fewest[stop - size]))
        fewest.append(fewest[stop - sizes[-1]] + 1)
    chosen, stop = list[CurvePart](), start + count
    while stop > start:
        size = sizes[stop - start]
        stop -= size
        chosen.append(parts[stop] if size == 1 else joints[stop, size])
    return chosen[::-1]
