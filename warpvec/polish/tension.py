"""The tension of outlines: a little loss for their length, which decides where pixels hardly tell.

The length of a curve is the root of three times the sum of the squares of the steps between its control points. Of a
line it is the true length, of other curves it is more, above all of one with uneven handles. So spikes and hooks, which
pixels hardly show, become short and simple. Edges that pixels show hardly move.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import torch
from torch import Tensor

from warpvec.geometry.bezier import whole_curves
from warpvec.geometry.scene import Scene
from warpvec.kernels.crossed_pixels import ROW_VALUES
from warpvec.polish.curve_rows import RowSlopes

if TYPE_CHECKING:  # photos need no matrix, and loading SciPy takes a tenth of a second
    from scipy import sparse

LENGTH_MIN = 0.05
"""Length in pixels that is added to each curve, in the square: that of one without length would have no derivative."""


def tension_of(scene: Scene, weight: Tensor) -> tuple[float, Tensor]:
    """Return the sum of the lengths of the segments of ``scene`` times their ``weight`` [R], and its adjoint [R, 3, 2].

    The row of an open line that is only its end counts nothing.
    """
    steps = whole_curves(scene).double().diff(dim=1)
    length, weight = _lengths(steps), _weights(scene, weight)
    slopes = (3.0 * weight / length)[:, None, None] * steps
    adjoint = -slopes
    adjoint[:, 1:] += slopes[:, :2]
    adjoint[scene.structure.segment_next.long(), 0] += slopes[:, 2]
    return float((weight * length).sum()), adjoint.to(scene.segments)


def tension_matrix(scene: Scene, weight: Tensor, rows: RowSlopes, count: int) -> sparse.coo_matrix:
    """Return a matrix [count, count] that bounds the second derivatives of `tension_of` by the values of ``rows``.

    It is that of the squares of the steps, with the lengths as they are.
    """
    from scipy import sparse

    squares = (_weights(scene, weight) / _lengths(whole_curves(scene).double().diff(dim=1))).cpu().numpy()
    used = rows.count.numpy()[: len(squares)]
    is_used = np.arange(int(used.max(initial=1))) < used[:, None]
    most = is_used.shape[1]
    slopes = rows.slopes.numpy()[: len(squares), :most, : ROW_VALUES - 1].astype(np.float64) * is_used[..., None]
    values = np.where(is_used, rows.value.numpy()[: len(squares), :most], 0)
    blocks = squares[:, None, None] * (slopes @ _SQUARED_STEPS @ slopes.swapaxes(1, 2))
    first, second = (np.broadcast_to(each, blocks.shape) for each in (values[:, :, None], values[:, None]))
    return sparse.coo_matrix((blocks.ravel(), (first.ravel(), second.ravel())), shape=(count, count))


_STEPS = np.kron(np.diff(np.eye(4), axis=0), np.eye(2))
_SQUARED_STEPS = 3.0 * _STEPS.T @ _STEPS
"""The matrix [8, 8] of three times the sum of the squares of the steps of a curve, by its four points."""


def _lengths(steps: Tensor) -> Tensor:
    """Return the length [R] of curves by their three ``steps`` [R, 3, 2]."""
    return (3.0 * steps.square().sum((1, 2)) + LENGTH_MIN**2).sqrt()


def _weights(scene: Scene, weight: Tensor) -> Tensor:
    return torch.where(scene.structure.end_rows, 0.0, weight.double())
