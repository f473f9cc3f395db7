"""Undo the rims that a kernel with negative weights has left at edges when a picture was reduced.

Of all pictures of a finer grid that become the given one, the one with the least total variation has clean edges; the
means over its pixels have no rims. Source of the method: Condat, A primal-dual splitting method for convex
optimization, 2013.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix

from warpvec.arrays import Floats32
from warpvec.condition.constants import CONDITION
from warpvec.condition.edge_models import REDUCTIONS


class _Reduction:
    """The reduction of a fine picture to ``shape`` [h, w] by a kernel, and its adjoint."""

    def __init__(self, shape: tuple[int, int], kernel: str) -> None:
        self._matrices = [_reducing(side, kernel) for side in shape]
        self._adjoints = [matrix.T.tocsr() for matrix in self._matrices]

    def reduced(self, fine: Floats32) -> Floats32:
        return _on_both_axes(self._matrices, fine)

    def adjoint(self, small: Floats32) -> Floats32:
        return _on_both_axes(self._adjoints, small)


def _reducing(side: int, kernel: str) -> csr_matrix:
    """Return the weights [side, fine side] of a reduction by ``kernel``."""
    fine = (np.arange(side * CONDITION.fineness) + 0.5) / CONDITION.fineness
    weights = REDUCTIONS[kernel].weight(np.abs(np.arange(side)[:, None] + 0.5 - fine))
    return csr_matrix((weights / weights.sum(1, keepdims=True)).astype(np.float32))


def _on_both_axes(matrices: list[csr_matrix], image: Floats32) -> Floats32:
    for matrix in matrices:
        rows = matrix @ image.reshape(len(image), -1)
        image = rows.reshape(-1, *image.shape[1:]).swapaxes(0, 1)
    return image


def without_rims(pixels: Floats32, kernel: str) -> Floats32:
    """Return ``pixels`` [h, w, 3] in [0, 1], which were reduced by ``kernel``, as means over pixels would be."""
    height, width = pixels.shape[:2]
    side = CONDITION.fineness
    fine = _finer(pixels, _Reduction((height, width), kernel))
    means = fine.reshape(height, side, width, side, -1).mean((1, 3))
    return np.asarray(np.rint(255.0 * means) / 255.0, np.float32)


def _finer(pixels: Floats32, reduction: _Reduction) -> Floats32:
    """Return the fine picture [side h, side w, 3] of least variation that becomes ``pixels``."""
    weight, side = CONDITION.fine_weight, CONDITION.fineness
    step = 1.0 / (0.8 * weight + 3.0 * 8.0**0.5)
    dual_step = 0.95 * (1.0 / step - 0.8 * weight) / 8.0
    fine = pixels.repeat(side, 0).repeat(side, 1)
    down, across = np.zeros_like(fine), np.zeros_like(fine)
    for _ in range(CONDITION.fine_rounds):
        pull = weight * side**2 * reduction.adjoint(_unexplained(pixels, reduction.reduced(fine)))
        new = (fine - step * (pull + _adjoint_of_differences(down, across))).clip(0.0, 1.0)
        ahead, fine = 2.0 * new - fine, new
        down[:-1] += dual_step * np.diff(ahead, axis=0)
        across[:, :-1] += dual_step * np.diff(ahead, axis=1)
        length = np.maximum(1.0, np.sqrt((down**2 + across**2).sum(2, keepdims=True)))
        down, across = down / length, across / length
    return fine


def _unexplained(pixels: Floats32, reduced: Floats32) -> Floats32:
    """Return ``reduced`` less ``pixels``; a pixel at black or white may have been cut off there."""
    half_level = 0.5 / 255.0
    rest = reduced - pixels
    rest = np.where(pixels >= 1.0 - half_level, np.minimum(rest, 0.0), rest)
    return np.asarray(np.where(pixels <= half_level, np.maximum(rest, 0.0), rest), np.float32)


def _adjoint_of_differences(down: Floats32, across: Floats32) -> Floats32:
    result = np.zeros_like(down)
    result[:-1] -= down[:-1]
    result[1:] += down[:-1]
    result[:, :-1] -= across[:, :-1]
    result[:, 1:] += across[:, :-1]
    return result
