"""Round the nodes of a drawing to the ticks of a file so that smooth nodes stay smooth."""

from __future__ import annotations

import math
from dataclasses import replace

import torch
from torch import Tensor

from warpvec.geometry.joints import Joints
from warpvec.geometry.scene import Scene

TURN_MAX = math.radians(0.4)
"""Largest change of direction of a handle of a smooth node: with two of these it bends by less than a degree."""

REACH = 8
"""Ticks in x and in y by which a handle may move to keep its direction. Only handles of less than a pixel need more
than one, and with 8 all that are 40 ticks long keep theirs."""


def round_nodes(scene: Scene, precision: int) -> Scene:
    """Return the cubic ``scene`` with its anchors and the handles of curves at whole ticks of ``10**-precision``.

    The handles of a smooth node point along its direction before, or along the rounded line beside it, within
    ``TURN_MAX`` where ``REACH`` allows it. The rows of forms stay.
    """
    joints = Joints.of(scene)
    ticks = scene.segments.double() * 10**precision
    anchor, leaving, arriving = joints.values(replace(scene, segments=ticks))
    anchor = anchor.round()
    along = joints.directions(anchor, leaving, arriving)
    smooth = joints.is_smooth
    exact, (leaving, arriving) = (leaving[smooth], arriving[smooth]), (leaving.round(), arriving.round())
    leaving[smooth], arriving[smooth] = _turned(exact[0], along[smooth]), -_turned(-exact[1], along[smooth])
    following = joints.following
    segments = torch.stack([anchor, anchor + leaving, anchor[following] + arriving[following]], 1)
    return replace(scene, segments=(segments / 10**precision).to(scene.segments.dtype)).with_forms(scene.forms)


def _turned(handle: Tensor, direction: Tensor) -> Tensor:
    """Return `_along`, which is the nearest whole numbers where these turn little, as those of long handles do."""
    nearest = handle.round()
    turns = _turn(nearest, direction) > TURN_MAX
    nearest[turns] = _along(handle[turns], direction[turns])
    return nearest


def _turn(handle: Tensor, direction: Tensor) -> Tensor:
    """Return the angle [...] between each ``handle`` [..., 2] and its ``direction`` [..., 2]; infinity for none."""
    along = (handle * direction).sum(-1)
    across = handle[..., 0] * direction[..., 1] - handle[..., 1] * direction[..., 0]
    return torch.where((handle == 0).all(-1), math.inf, torch.atan2(across.abs(), along))


def _along(handle: Tensor, direction: Tensor) -> Tensor:
    """Return whole numbers near each ``handle`` [R, 2] that lie along its ``direction`` [R, 2] of length 1.

    These are the nearest ones within ``TURN_MAX``, or those that turn least.
    """
    steps = torch.arange(-REACH, REACH + 1, dtype=handle.dtype, device=handle.device)
    offsets = torch.cartesian_prod(steps, steps)
    tried = handle.round()[:, None] + offsets
    turn = _turn(tried, direction[:, None])
    off = (tried - handle[:, None]).norm(dim=2)
    cost = off + 4 * REACH * (turn - TURN_MAX).clamp_min(0.0) / TURN_MAX
    best = cost.argmin(1)
    return tried[torch.arange(len(tried), device=tried.device), best]
