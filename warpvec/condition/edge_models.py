"""Compare edges with those that a kernel makes when a large drawing is reduced.

A straight or slightly round edge between two even areas has five unknowns: its angle, its distance from the middle of
the patch, its curvature, and the levels on its two sides. The rest that the best of them leave tells kernels apart:
means over pixels have no rim, and cubic and Lanczos kernels overshoot by 3 to 9 % of the step.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import torch
import warp as wp

from warpvec.arrays import Floats
from warpvec.condition.constants import CONDITION
from warpvec.condition.resampling import KERNELS, Kernel
from warpvec.kernels.edge_fitting import make_kernels
from warpvec.rendering.launch import Launcher, as_warp, once_per_thread, start_warp

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


@cache
def _grid() -> tuple[Floats, Floats]:
    reach = CONDITION.patch_reach
    y, x = np.mgrid[-reach : reach + 1, -reach : reach + 1].astype(np.float64)
    return y.ravel(), x.ravel()


def fit_edges(patches: Floats, kernels: Iterable[str]) -> dict[str, EdgeFit]:
    """Fit edges of each of the ``kernels`` to ``patches`` [N, side, side] in [0, 255]."""
    side, start = patches.shape[1], _guess(patches)
    levels, cost = np.ascontiguousarray(patches.reshape(len(patches), -1)), np.empty(len(patches))
    fits = {}
    for kernel in kernels:
        known = start.copy()
        numbers = [CONDITION.patch_rounds, side, CONDITION.curvature_max, _STEP]
        arrays = [_doubles(each) for each in (_profiles(kernel), levels, known, cost)]
        _launcher()(make_kernels().fit_edges, len(patches), [*numbers, *arrays])
        step = np.abs(known[:, 4] - known[:, 3])
        fits[kernel] = EdgeFit(np.sqrt(cost / levels.shape[1]) / np.maximum(step, CONDITION.step_min), step)
    return fits


@once_per_thread
def _launcher() -> Launcher:
    start_warp()
    return Launcher("cpu", 1)


def _doubles(values: Floats) -> Any:
    return as_warp(torch.from_numpy(values), wp.float64)


def _guess(patches: Floats) -> Floats:
    """Return the first unknowns [N, 5] of ``patches``: from their mean slope, and the pixels far from the edge."""
    angle = np.arctan2(np.diff(patches, axis=1).sum((1, 2)), np.diff(patches, axis=2).sum((1, 2)))
    y, x = _grid()
    across = np.cos(angle)[:, None] * x + np.sin(angle)[:, None] * y
    levels = patches.reshape(len(patches), -1)
    low, high = (np.nanmedian(np.where(is_far, levels, np.nan), axis=1) for is_far in (across < -2.0, across > 2.0))
    step = np.where(np.abs(high - low) < 1.0, 1.0, high - low)
    share = (high[:, None] - levels).mean(1) / step
    offset = ((share - 0.5) * patches.shape[1]).clip(-2.5, 2.5)
    return np.stack([angle, offset, np.zeros(len(angle)), low, high], 1)
