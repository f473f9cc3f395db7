"""Fit all numbers of a ramp to the pixels of its area at once: its direction, the places and the colours of its stops.

The colours of stops are whole levels, as a file states them. The places follow, so that the ramp shows the picture as
well with these colours. A designer's stops have such colours, so they are found again.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec.arrays import Mask
from warpvec.flat.constants.regions import REGIONS
from warpvec.flat.regions.ramp_fitting import Ramp, stop_weights
from warpvec.geometry.paints.registry import kind_of

Floats = NDArray[np.floating[Any]]


def refitted(ramp: Ramp, points: Floats, colors: Floats) -> Ramp:
    """Return ``ramp`` fitted to the colours [N, 3 or 4] of ``points`` [N, 2]; itself if that shows them worse."""
    few = slice(None, None, -(-len(points) // REGIONS.refit_samples_max))
    points, colors = points[few], colors[few]
    free = _moved(ramp, points, colors, are_colors_free=True)
    free = _with_level_ends(free, points)
    levels = free.colors.copy()
    levels[:, :3] = np.round(255 * np.clip(levels[:, :3], 0, 1)) / 255
    found = _moved(replace(free, colors=levels), points, colors, are_colors_free=False)
    before, after = (each.error_on(points, colors) for each in (ramp, found))
    return replace(found, error=after) if after < before else ramp


def _moved(ramp: Ramp, points: Floats, colors: Floats, *, are_colors_free: bool) -> Ramp:
    """Return ``ramp`` after steps of Gauss and Newton, as long as these lower the error."""
    error = _error(ramp, points, colors)
    for _ in range(REGIONS.refit_rounds):
        trial = _stepped(ramp, points, colors, are_colors_free=are_colors_free)
        trial_error = np.inf if trial is None else _error(trial, points, colors)
        if trial is None or trial_error > error:
            break
        is_idle = trial_error > (1.0 - REGIONS.refit_gain) * error
        ramp, error = trial, trial_error
        if is_idle:
            break
    return ramp


def _error(ramp: Ramp, points: Floats, colors: Floats) -> float:
    return float(np.square(colors - stop_weights(ramp.knots, ramp.direction.places(points)) @ ramp.colors).sum())


def _stepped(ramp: Ramp, points: Floats, colors: Floats, *, are_colors_free: bool) -> Ramp | None:
    """Return ``ramp`` after a step; None if its stops would change their order."""
    places = ramp.direction.places(points)
    weights = stop_weights(ramp.knots, places)
    slopes = _slopes(ramp, places)
    rest = colors - weights @ ramp.colors
    change = ramp.direction.changes(points, places)
    moves = _is_told(ramp, places)
    columns = [slopes[:, :, None] * change[:, None], -slopes[:, :, None] * weights[:, None, moves]]
    if are_colors_free:
        # Each channel has colours of its own, which do not depend on those of others.
        count, channels = ramp.colors.shape
        own = weights[:, None, :, None] * np.eye(channels)[None, :, None, :]
        columns.append(own.reshape(len(points), channels, count * channels))
    rows = np.concatenate(columns, 2).reshape(-1, sum(each.shape[2] for each in columns))
    step = _least_squares(rows, rest.ravel())
    turn, shift, tint = np.split(step, np.cumsum([change.shape[1], int(moves.sum())]))
    knots = ramp.knots.copy()
    knots[moves] += shift
    if (np.diff(knots) <= 0).any():
        return None
    changed = ramp.colors + tint.reshape(ramp.colors.shape) if are_colors_free else ramp.colors
    return replace(ramp, direction=ramp.direction.moved(turn), knots=knots, colors=changed)


def _is_told(ramp: Ramp, places: Floats) -> Mask:
    """Return which stops [M] have a place that the pixels tell: there, the colours bend."""
    pads = np.array([(places < ramp.knots[0]).mean(), (places > ramp.knots[-1]).mean()])
    told = np.ones(len(ramp.knots), np.bool_)
    told[[0, -1]] = pads >= REGIONS.refit_pad_min
    return told


def _slopes(ramp: Ramp, places: Floats) -> Floats:
    """Return how the colours [N, D] change per pixel at ``places`` [N]; not at all beyond the ends."""
    per_pixel = np.diff(ramp.colors, axis=0) / np.maximum(np.diff(ramp.knots), 1e-9)[:, None]
    segment = np.clip(np.searchsorted(ramp.knots, places, side="right") - 1, 0, len(per_pixel) - 1)
    is_inside = (places > ramp.knots[0]) & (places < ramp.knots[-1])
    slopes: Floats = per_pixel[segment] * is_inside[:, None]
    return slopes


def _with_level_ends(ramp: Ramp, points: Floats) -> Ramp:
    """Return ``ramp`` with the ends that no pixel tells moved out to the first place of nearly whole levels.

    A ramp of opacities stays: beyond what is seen, its colours are too uncertain.
    """
    if ramp.colors.shape[1] > 3:
        return ramp
    told = _is_told(ramp, ramp.direction.places(points))
    knots, values = ramp.knots.copy(), ramp.colors.copy()
    extent = float(np.ptp(knots))
    for end, inner in ((0, 1), (-1, -2)):
        is_fixed = end == 0 and not kind_of(ramp.direction.kind).has_free_start
        if told[end] or is_fixed:
            continue
        reach = knots[end] - knots[inner]
        parts = 1.0 + np.linspace(0.0, REGIONS.refit_reach * extent / abs(reach), REGIONS.refit_places)
        shown = values[inner] + parts[:, None] * (values[end] - values[inner])
        levels = 255.0 * shown
        off = np.abs(levels - np.round(levels)).max(1)
        off[((shown < 0.0) | (shown > 1.0)).any(1)] = np.inf
        best = int(np.argmax(off <= max(REGIONS.refit_level, off.min())))
        if np.isfinite(off[best]):
            knots[end], values[end] = knots[inner] + parts[best] * reach, shown[best]
    return replace(ramp, knots=knots, colors=values)


def _least_squares(rows: Floats, values: Floats) -> Floats:
    """Solve ``rows`` [N, P] x = ``values`` [N] by sums that are the same for any number of threads: no BLAS."""
    scale = np.maximum(np.sqrt((rows**2).sum(0)), 1e-9)
    rows = rows / scale
    matrix = np.einsum("np,nq->pq", rows, rows) + REGIONS.refit_damping * np.eye(rows.shape[1])
    return np.linalg.solve(matrix, (rows * values[:, None]).sum(0)) / scale
