"""Points of Bezier curves by de Casteljau's algorithm."""

from __future__ import annotations

from torch import Tensor


def de_casteljau(points: Tensor, t: Tensor) -> Tensor:
    """Return points [N, K, 2] of curves [N, M + 1, 2] at parameters [K], by repeated interpolation."""
    left = points[:, None].expand(-1, len(t), -1, -1)
    while left.shape[2] > 1:
        left = (1 - t)[None, :, None, None] * left[:, :, :-1] + t[None, :, None, None] * left[:, :, 1:]
    return left[:, :, 0]
