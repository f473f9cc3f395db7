"""Find at once, and without iterations, which cubic could replace the two at each anchor of a scene."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from warpvec.geometry.bezier import whole_curves
from warpvec.geometry.scene import Scene

_SPANS = 4
"""Spans between the points at which outlines are compared, along each old cubic."""

_ALONG = 0.02
"""Weight of a squared distance along the old outline, where that across it has 1: the points may slide along it."""

_TINY = 1e-12
"""Added to what is divided by: lengths in pixels, which vanish where points coincide."""

_RIDGE = 1e-9
"""Weight of handles that stay at the anchors. It decides where the points do not."""


@dataclass(frozen=True)
class QuickMerges:
    """The cubic that could replace each row and the one before it in its loop.

    Attributes:
        handles: its two handles [R, 2, 2] in pixels.
        share: share of the row before in the length of both [R].
        offset: how far the new outline lies from the old one at points along it [R, S], across the old one, in pixels.
        length: length of the old outline that each point stands for [R, S], in pixels.
    """

    handles: Tensor
    share: Tensor
    offset: Tensor
    length: Tensor


def quick_merges(scene: Scene) -> QuickMerges:
    """Return how the two cubics at each anchor of ``scene`` could become one, by weighted least squares (float64)."""
    ramp = torch.linspace(0.0, 1.0, _SPANS + 1, dtype=torch.float64, device=scene.segments.device)
    before, control = scene.structure.segment_previous.long(), whole_curves(scene).double()
    own_points, own_slopes = _weights(ramp) @ control, _slope_weights(ramp) @ control
    points = torch.cat([own_points[before], own_points[:, 1:]], 1)
    slopes = torch.cat([own_slopes[before], own_slopes[:, 1:]], 1)
    length = _lengths(points)
    part = length[:, :_SPANS].sum(1) + length[:, _SPANS] / 2.0
    share = (part + _TINY) / (length.sum(1) + 2.0 * _TINY)
    parameters = torch.cat([share[:, None] * ramp, share[:, None] + (1.0 - share[:, None]) * ramp[1:]], 1)
    along = slopes / (slopes.norm(dim=-1, keepdim=True) + _TINY)
    handles, offset = _least_squares(points, along, length, parameters)
    return QuickMerges(handles, share, offset, length)


def _lengths(points: Tensor) -> Tensor:
    """Return the length that each of the ``points`` [R, S, 2] stands for [R, S]: half of that to its neighbours."""
    steps = (points[:, 1:] - points[:, :-1]).norm(dim=-1) / 2.0
    return torch.nn.functional.pad(steps, (1, 0)) + torch.nn.functional.pad(steps, (0, 1))


def _least_squares(points: Tensor, along: Tensor, length: Tensor, parameters: Tensor) -> tuple[Tensor, Tensor]:
    """Return the handles [R, 2, 2] of the cubics closest to the points, and the distances across the outline [R, S]."""
    weights = _weights(parameters)
    ends = points[:, [0, -1]]
    rest = points - weights[..., [0, 3]] @ ends
    across = torch.stack([-along[..., 1], along[..., 0]], -1)
    rows, values = [], []
    for direction, weight in ((across, 1.0), (along, _ALONG)):
        scale = (weight * length).sqrt()[..., None]
        row = (weights[..., 1:3, None] * direction[..., None, :]).flatten(-2)  # of the two handles' x and y
        rows.append(scale * row)
        values.append(scale * (direction * rest).sum(-1, keepdim=True))
    left, right = torch.cat(rows, 1), torch.cat(values, 1)
    near = torch.cat([ends[:, 0], ends[:, 1]], 1)[..., None]
    ridge = _RIDGE * torch.eye(4, dtype=points.dtype, device=points.device)
    handles = torch.linalg.solve(left.mT @ left + ridge, left.mT @ right + _RIDGE * near).reshape(-1, 2, 2)
    offset = ((weights[..., 1:3] @ handles - rest) * across).sum(-1)
    return handles, offset


def _weights(t: Tensor) -> Tensor:
    """Return the weights [..., 4] of the control points of cubics at ``t`` [...]."""
    s = 1.0 - t
    return torch.stack([s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t], -1)


def _slope_weights(t: Tensor) -> Tensor:
    """Return the weights [..., 4] of the control points in the derivatives of cubics at ``t`` [...]."""
    s = 1.0 - t
    return 3.0 * torch.stack([-s * s, s * (s - 2.0 * t), t * (2.0 * s - t), t * t], -1)
