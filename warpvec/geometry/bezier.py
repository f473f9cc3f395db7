"""Bernstein weights and bounding boxes of Bezier curves of any degree."""

from __future__ import annotations

import math

import torch
from torch import Tensor


def bernstein(degree: int, t: Tensor) -> Tensor:
    """Return the Bernstein weights [..., M + 1] of the control points of a curve of degree M at ``t`` [...]."""
    weights = [math.comb(degree, j) * (1.0 - t) ** (degree - j) * t**j for j in range(degree + 1)]
    return torch.stack(weights, -1)


# Points along a curve that its bounding box is taken from. A half circle exceeds the box by 0.5 % of its radius.
_BOX_SAMPLES = 17


def curve_boxes(points: Tensor, degree: int) -> Tensor:
    """Return left, top, right and bottom [N, 4] of closed paths [N, M S, 2], from sample points along the curves."""
    point_count = points.shape[1]
    first = torch.arange(0, point_count, degree, device=points.device)
    pieces = points[:, (first[:, None] + torch.arange(degree + 1, device=points.device)) % point_count]
    parameters = torch.linspace(0.0, 1.0, _BOX_SAMPLES, dtype=points.dtype, device=points.device)
    outline = (bernstein(degree, parameters) @ pieces).flatten(1, 2)
    return torch.cat([outline.amin(1), outline.amax(1)], -1)
