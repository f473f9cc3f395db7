"""Compare edges with those that a kernel makes when a large drawing is reduced.

A straight or slightly round edge between two even areas has five unknowns: its angle, its distance from the middle of
the patch, its curvature, and the levels on its two sides. The rest that the best of them leave tells kernels apart:
means over pixels have no rim, and cubic and Lanczos kernels overshoot by 3 to 9 % of the step.
"""

from __future__ import annotations

import math
from functools import cache
from typing import NamedTuple

import numpy as np

from warpvec.arrays import Floats
from warpvec.condition.constants import CONDITION
from warpvec.condition.resampling import KERNELS, Kernel

MEANS = "means"

REDUCTIONS = {
    MEANS: Kernel(lambda distance: np.where(distance <= 0.5, 1.0, 0.0), 1),
    **{name: KERNELS[name] for name in ("bilinear", "bicubic", "lanczos")},
}
"""The kernels that pictures are reduced with; a renderer draws means over pixels."""

_STEP, _REACH, _ANGLES = 0.02, 7.0, 24
"""Step in pixels and reach of the tables of edges, and number of steps of the angle up to 45 degrees."""

_PLACES = np.arange(-_REACH, _REACH + _STEP / 2.0, _STEP)


class EdgeFit(NamedTuple):
    """The best edges of a kernel in N patches.

    Attributes:
        rest: root mean square of what they leave unexplained, as a share of the step [N].
        step: difference of levels of both sides [N].
    """

    rest: Floats
    step: Floats


@cache
def _profiles(kernel: str) -> Floats:
    """Return the levels [angles, places] of a step from 0 to 1, by distance from it and by angle up to 45 degrees."""
    rows = []
    for angle in np.linspace(0.0, math.pi / 4.0, _ANGLES + 1):
        spread = _weights(kernel, math.cos(angle))
        if math.sin(angle) > _STEP:
            spread = np.convolve(spread, _weights(kernel, math.sin(angle)), "same")
        total = np.cumsum(spread)
        rows.append(np.interp(_PLACES, _PLACES + _STEP / 2.0, total / total[-1]))
    return np.array(rows)


def _weights(kernel: str, breadth: float) -> Floats:
    """Return the weights at all places of a ``kernel`` that is ``breadth`` times as broad; their sum is 1."""
    weights = REDUCTIONS[kernel].weight(np.abs(_PLACES) / breadth)
    return np.asarray(weights / weights.sum())


def _edge(kernel: str, angle: Floats, distance: Floats) -> Floats:
    """Return the levels [N, P] of steps from 0 to 1 at the ``distance`` [N, P] from edges of the ``angle`` [N]."""
    table, sides = _profiles(kernel), np.abs([np.cos(angle), np.sin(angle)])
    row = np.arctan2(sides.min(0), sides.max(0)) * (4.0 * _ANGLES / math.pi)
    above = row.astype(np.int64).clip(0, _ANGLES - 1)[:, None]
    column = ((distance + _REACH) / _STEP).clip(0.0, len(_PLACES) - 1.001)
    left = column.astype(np.int64)
    down, right = row[:, None] - above, column - left
    first = (1.0 - right) * table[above, left] + right * table[above, left + 1]
    second = (1.0 - right) * table[above + 1, left] + right * table[above + 1, left + 1]
    return np.asarray((1.0 - down) * first + down * second)


def _drawn(kernel: str, known: Floats) -> tuple[Floats, Floats]:
    """Return the levels [N, P] of patches with the unknowns ``known`` [5, N], and their share of the second side."""
    angle, offset, curvature, low, high = known[:, :, None]
    y, x = _grid()
    along, across = np.cos(angle) * y - np.sin(angle) * x, np.cos(angle) * x + np.sin(angle) * y
    share = _edge(kernel, known[0], across - offset - curvature / 2.0 * along**2)
    return np.asarray(low + (high - low) * share), share


@cache
def _grid() -> tuple[Floats, Floats]:
    reach = CONDITION.patch_reach
    y, x = np.mgrid[-reach : reach + 1, -reach : reach + 1].astype(np.float64)
    return y.ravel(), x.ravel()


def fit_edges(patches: Floats, kernel: str) -> EdgeFit:
    """Fit edges of ``kernel`` to ``patches`` [N, side, side] in [0, 255] by damped least squares."""
    levels = patches.reshape(len(patches), -1)
    known = _guess(patches)
    damping = np.full(len(levels), 1e-3)
    cost = _cost(kernel, known, levels)
    for _ in range(CONDITION.patch_rounds):
        tried = known + _move(kernel, known, levels, damping)
        tried[2] = tried[2].clip(-CONDITION.curvature_max, CONDITION.curvature_max)
        tried[3:] = tried[3:].clip(0.0, 255.0)  # or shading beside a side of 255 levels looks like the rim of 400
        new = _cost(kernel, tried, levels)
        is_better = new < cost
        known, cost = np.where(is_better, tried, known), np.where(is_better, new, cost)
        damping = np.where(is_better, 0.3 * damping, 5.0 * damping)
    step = np.abs(known[4] - known[3])
    return EdgeFit(np.sqrt(cost / levels.shape[1]) / np.maximum(step, CONDITION.step_min), step)


def _guess(patches: Floats) -> Floats:
    """Return the first unknowns [5, N] of ``patches``: from their mean slope, and the pixels far from the edge."""
    angle = np.arctan2(np.diff(patches, axis=1).sum((1, 2)), np.diff(patches, axis=2).sum((1, 2)))
    y, x = _grid()
    across = np.cos(angle)[:, None] * x + np.sin(angle)[:, None] * y
    levels = patches.reshape(len(patches), -1)
    low, high = (np.nanmedian(np.where(is_far, levels, np.nan), axis=1) for is_far in (across < -2.0, across > 2.0))
    step = np.where(np.abs(high - low) < 1.0, 1.0, high - low)
    share = (high[:, None] - levels).mean(1) / step
    offset = ((share - 0.5) * patches.shape[1]).clip(-2.5, 2.5)
    return np.array([angle, offset, np.zeros(len(angle)), low, high])


def _cost(kernel: str, known: Floats, levels: Floats) -> Floats:
    """Return the sum [N] of squares of what the unknowns ``known`` [5, N] leave; saved levels are cut off."""
    return np.asarray(((_drawn(kernel, known)[0].clip(0.0, 255.0) - levels) ** 2).sum(1))


def _move(kernel: str, known: Floats, levels: Floats, damping: Floats) -> Floats:
    """Return the step [5, N] of damped least squares from ``known``."""
    drawn, share = _drawn(kernel, known)
    change, slopes = 0.01, []
    for row in range(3):
        moved = known.copy()
        moved[row] += change
        slopes.append((_drawn(kernel, moved)[0] - drawn) / change)
    is_open = ((drawn > 0.0) | (levels > 0.5)) & ((drawn < 255.0) | (levels < 254.5))
    jacobian = np.stack([*slopes, 1.0 - share, share], -1) * is_open[..., None]
    square = np.einsum("npi,npj->nij", jacobian, jacobian)
    square += (damping[:, None] * np.einsum("nii->ni", square) + 1e-6)[:, :, None] * np.eye(5)
    slope = np.einsum("npi,np->ni", jacobian, (drawn.clip(0.0, 255.0) - levels) * is_open)
    limit = np.array([0.2, 0.5, 0.05, 255.0, 255.0])[:, None]
    return np.clip(-np.linalg.solve(square, slope[..., None])[..., 0].T, -limit, limit)
