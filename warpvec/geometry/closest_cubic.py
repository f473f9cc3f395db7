"""The cubic closest to two that follow each other, and how far apart the two outlines are."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor

from warpvec.geometry.lines import thirds

_SAMPLES = 16
"""Points along each old cubic that the new one is fitted to."""

_ROUNDS, _STEPS = 8, 2
"""Times that the handles are found anew, and after each the steps of the points' parameters to where the new cubic is
closest to them."""

_ALONG = 0.02
"""Weight of a squared distance along the new cubic, where that across it has 1. With 1, hundreds of rounds would be
needed; with 0, the handles could jump."""

_DENSITY = 4
"""Points compared for each one fitted."""

_PAIRS = torch.tensor([[0, 1], [1, 2]])
"""Place of the entries of a symmetric 2 x 2 matrix in a list of three."""

_GAIN_MIN = 1e-10
"""Least gain in squared pixels for which a solution replaces an earlier one. Many cubics are the same straight line;
the first one found is the one that was split."""

_CHUNK = 512
"""Pairs that are fitted at a time. More of them are slower, because they do not fit in the caches."""

_SHARE_MIN = 1e-3
"""Least share of the new cubic's parameters that either old one gets at the start."""

_TINY = 1e-30
"""Added to what is divided by: lengths and squares of pixels, which vanish where points coincide."""

_RIDGE = 1e-9
"""Weight, beside that of all points, of handles at thirds. It decides where the points do not."""


@dataclass(frozen=True)
class MergedCubics:
    """A cubic for each of K pairs.

    Attributes:
        handles: its two handles [K, 2, 2].
        share: the parameter at which it passes the anchor between the two [K], inside (0, 1).
        distance: how far apart the old and the new outline are at most [K], in pixels. Points are compared at
            parameters that rise along both, so the true distance may be smaller.
        area: area between the outlines [K], in square pixels.
    """

    handles: Tensor
    share: Tensor
    distance: Tensor
    area: Tensor

    def to(self, device: torch.device | str) -> MergedCubics:
        """Return the cubics in the memory of ``device``."""
        return MergedCubics(*(getattr(self, name).to(device) for name in MergedCubics.__dataclass_fields__))


def closest_cubic(first: Tensor, second: Tensor, is_line: Tensor) -> MergedCubics:
    """Return the cubic that replaces ``first`` and then ``second`` [K, 4, 2], where a row ``is_line`` [K] a line.

    The sum of squared distances is least, from points on the old cubics to the closest on the new one. Two pieces of
    one cubic give that cubic back.

    Everything is computed in the dtype of the points; float64 is expected.
    """
    parts = zip(*(torch.split(values, _CHUNK) for values in (first, second, is_line)), strict=True)
    found = [_replaced(*part) for part in parts]
    names = MergedCubics.__dataclass_fields__
    return MergedCubics(**{name: torch.cat([getattr(each, name) for each in found]) for name in names})


def _replaced(first: Tensor, second: Tensor, is_line: Tensor) -> MergedCubics:
    points, weights = _sampled(first, second)
    candidates = _handle_share(first, second), _length_share(first, second)
    share = torch.cat(candidates).clamp(_SHARE_MIN, 1.0 - _SHARE_MIN)
    twice = points.repeat(2, 1, 1), weights.repeat(2, 1), is_line.repeat(2)
    handles, parameters, error = _fitted(twice[0], twice[1], twice[2], share)
    count = len(first)
    is_later = (error[count:] < error[:count] - _GAIN_MIN)[:, None]
    handles = torch.where(is_later[..., None], handles[count:], handles[:count])
    parameters = torch.where(is_later, parameters[count:], parameters[:count])
    share = parameters[:, _SAMPLES].clamp(_SHARE_MIN, 1.0 - _SHARE_MIN)
    old, new = _corresponding(first, second, _control(points, handles), parameters)
    return MergedCubics(handles, share, (new - old).norm(dim=-1).amax(1), area_between(old, new))


def area_between(old: Tensor, new: Tensor) -> Tensor:
    """Return the area [K] between two lines through the points ``old`` and ``new`` [K, S, 2], which correspond."""
    step = old[:, 1:] - old[:, :-1]
    before, after = new[:, :-1] - old[:, :-1], new[:, 1:] - old[:, :-1]
    return (_cross(step, after).abs() + _cross(after, before).abs()).sum(1) / 2.0


def compared(old: Tensor, new: Tensor) -> tuple[Tensor, Tensor]:
    """Return the distance and the area [K] between cubics [K, 4, 2] at equal parameters."""
    parameters = torch.linspace(0.0, 1.0, 2 * _SAMPLES + 1, dtype=old.dtype, device=old.device)
    weights = _cubic_weights(parameters)
    return ((weights @ (new - old)).norm(dim=-1).amax(1), area_between(weights @ old, weights @ new))


def _cross(a: Tensor, b: Tensor) -> Tensor:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def _sampled(first: Tensor, second: Tensor) -> tuple[Tensor, Tensor]:
    """Return points along both [K, 2 S + 1, 2], and the length that each stands for, of 1 in all [K, 2 S + 1]."""
    parameters = torch.linspace(0.0, 1.0, _SAMPLES + 1, dtype=first.dtype, device=first.device)
    weights = _cubic_weights(parameters)
    points = torch.cat([weights @ first, (weights @ second)[:, 1:]], 1)
    steps = (points[:, 1:] - points[:, :-1]).norm(dim=-1)
    lengths = torch.nn.functional.pad(steps, (1, 0)) + torch.nn.functional.pad(steps, (0, 1))
    lengths = lengths + _TINY
    return points, lengths / lengths.sum(1, keepdim=True)


def _handle_share(first: Tensor, second: Tensor) -> Tensor:
    """Return the share of ``first`` if both are pieces of one cubic: the handles at the anchor tell it."""
    before, after = (first[:, 3] - first[:, 2]).norm(dim=-1), (second[:, 1] - second[:, 0]).norm(dim=-1)
    return (before + _TINY) / (before + after + 2 * _TINY)


def _length_share(first: Tensor, second: Tensor) -> Tensor:
    before, after = ((cubic[:, 1:] - cubic[:, :-1]).norm(dim=-1).sum(1) for cubic in (first, second))
    return (before + _TINY) / (before + after + 2 * _TINY)


def _fitted(points: Tensor, weights: Tensor, is_line: Tensor, share: Tensor) -> tuple[Tensor, Tensor, Tensor]:
    """Return handles [K, 2, 2], parameters of the points [K, 2 S + 1], and the mean squared distance [K].

    Handles and parameters are improved in turn, and the best are kept.
    """
    ramp = torch.linspace(0.0, 1.0, _SAMPLES + 1, dtype=points.dtype, device=points.device)
    parameters = torch.cat([share[:, None] * ramp, share[:, None] + (1.0 - share[:, None]) * ramp[1:]], 1)
    straight = torch.stack(thirds(points[:, 0], points[:, -1]), 1)
    normals, best = torch.zeros_like(points), (straight, parameters, torch.full_like(share, torch.inf))
    for _ in range(_ROUNDS):
        handles = torch.where(
            is_line[:, None, None], straight, _least_squares(points, weights, parameters, normals, straight)
        )
        control = _control(points, handles)
        offset = _on_cubic(control, parameters) - points
        best = _better(best, (handles, parameters, (weights * offset.square().sum(-1)).sum(1)))
        for _ in range(_STEPS):
            parameters = _closer(control, parameters, points)
        offset = _on_cubic(control, parameters) - points
        best = _better(best, (handles, parameters, (weights * offset.square().sum(-1)).sum(1)))
        slope = _slope(control, parameters)
        normals = torch.stack([-slope[..., 1], slope[..., 0]], -1) / (slope.norm(dim=-1, keepdim=True) + _TINY)
    return best


def _better(a: tuple[Tensor, Tensor, Tensor], b: tuple[Tensor, Tensor, Tensor]) -> tuple[Tensor, Tensor, Tensor]:
    """Return the handles, parameters and errors [K] of ``b`` where it is clearly better, else those of ``a``."""
    is_better = b[2] < a[2] - _GAIN_MIN
    shapes = (is_better[:, None, None], is_better[:, None], is_better)
    handles, parameters, error = (torch.where(mask, y, x) for mask, x, y in zip(shapes, a, b, strict=True))
    return handles, parameters, error


def _least_squares(points: Tensor, weights: Tensor, parameters: Tensor, normals: Tensor, straight: Tensor) -> Tensor:
    """Return the handles [K, 2, 2] of the cubics that are closest to the points at their ``parameters``.

    Distances along the ``normals`` [K, 2 S + 1, 2] count in full, others only a little, because the parameters follow
    in that direction.
    """
    basis = _cubic_weights(parameters)
    rest = points - basis[..., [0, 3]] @ torch.stack([points[:, 0], points[:, -1]], 1)
    inner, across = basis[..., 1:3], normals.square().sum(-1, keepdim=True)  # 0 where there is no normal yet
    along = weights[..., None] * (1.0 - across * (1.0 - _ALONG))
    extra = weights[..., None] * (1.0 - _ALONG) * normals
    # Each point weighs x and y by the matrix [[xx, xy], [xy, yy]].
    xx, xy = along + extra[..., :1] * normals[..., :1], extra[..., :1] * normals[..., 1:]
    yy = along + extra[..., 1:] * normals[..., 1:]
    products = torch.cat([inner * inner[..., :1], inner[..., 1:] * inner[..., 1:]], -1).mT  # of both handles' weights
    sums = products @ torch.cat([xx, xy, yy], -1)  # [K, 3, 3]
    normal = sums[:, _PAIRS][:, :, :, _PAIRS].transpose(2, 3).reshape(-1, 4, 4)
    weighted = torch.cat([xx * rest[..., :1] + xy * rest[..., 1:], xy * rest[..., :1] + yy * rest[..., 1:]], -1)
    ridge = _RIDGE * torch.eye(4, dtype=points.dtype, device=points.device)
    right = (inner.mT @ weighted + _RIDGE * straight).reshape(-1, 4, 1)
    return torch.linalg.solve(normal + ridge, right).reshape(-1, 2, 2)


def _closer(control: Tensor, parameters: Tensor, points: Tensor) -> Tensor:
    """Move ``parameters`` towards where the cubics are closest to the points; they keep rising."""
    offset, slope = _on_cubic(control, parameters) - points, _slope(control, parameters)
    step = (offset * slope).sum(-1) / (slope.square().sum(-1) + _TINY)
    moved = (parameters - step).clamp(0.0, 1.0).cummax(1).values
    return torch.cat([torch.zeros_like(moved[:, :1]), moved[:, 1:-1], torch.ones_like(moved[:, :1])], 1)


def _corresponding(first: Tensor, second: Tensor, control: Tensor, parameters: Tensor) -> tuple[Tensor, Tensor]:
    """Return points on both old cubics and those on the new one that correspond to them [K, 2 S D + 1, 2]."""
    part = torch.arange(_DENSITY, dtype=first.dtype, device=first.device) / _DENSITY
    between = parameters[:, :-1, None] + part * parameters.diff(dim=1)[..., None]
    dense = torch.cat([between.flatten(1), parameters[:, -1:]], 1)
    weights = _cubic_weights(torch.linspace(0.0, 1.0, _SAMPLES * _DENSITY + 1, dtype=first.dtype, device=first.device))
    return torch.cat([weights @ first, (weights @ second)[:, 1:]], 1), _on_cubic(control, dense)


def _control(points: Tensor, handles: Tensor) -> Tensor:
    """Return control points [K, 4, 2] between the first and the last of ``points``."""
    return torch.cat([points[:, :1], handles, points[:, -1:]], 1)


def _cubic_weights(t: Tensor) -> Tensor:
    """Return the weights [..., 4] of the control points of cubics at ``t`` [...]."""
    s = 1.0 - t
    st = 3.0 * s * t
    return torch.stack([s * s * s, st * s, st * t, t * t * t], -1)


def _on_cubic(control: Tensor, parameters: Tensor) -> Tensor:
    return _cubic_weights(parameters) @ control


def _slope(control: Tensor, parameters: Tensor) -> Tensor:
    """Return the derivatives of cubics at their parameters."""
    t, s = parameters, 1.0 - parameters
    return torch.stack([s * s, 2.0 * s * t, t * t], -1) @ (3.0 * (control[:, 1:] - control[:, :-1]))
