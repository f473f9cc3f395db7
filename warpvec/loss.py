"""Regularizers of the paths (equation 5), and PSNR.

The fit takes their gradients from ``kernels/regularization.py``, in a tenth of the time that autograd needs. Here,
geometry lies in planes, the last two dimensions always [N, S]: ``planes`` [3, 2, N, S] are the control
points A, B, C of each cubic, ``legs`` [3, 2, N, S] the sides AB, BC, CD of its control polygon.
"""

from __future__ import annotations

import math
from functools import cache

import torch
from torch import Tensor
from torch.nn.functional import threshold

from warpvec.config import FitConfig
from warpvec.kernels.constants import (
    EXTENT_MIN,
    LEG_MIN,
    PROJECTION_WEIGHT,
    TIP_COSINE,
    TIP_PARAMETER,
    XING_SCALE,
)


def psnr_from_mse(mse: float) -> float:
    """Peak signal-to-noise ratio in dB for values in [0, 1]; infinite when ``mse`` is 0."""
    return math.inf if mse <= 0.0 else -10.0 * math.log10(mse)


def regularization(points: Tensor, opacity: Tensor, width: float, height: float, config: FitConfig) -> Tensor:
    """The weighted sum of the three regularizers, equation (5), for autograd.

    Args:
        points: control points [N, 3 S, 2] in pixels.
        opacity: fill opacity [N] in [0, 1].
        width, height: canvas in pixels.
        config: gives ``opacity_weight``, ``xing_weight`` and ``bezier_weight``.
    """
    return (
        config.opacity_weight * opacity_loss(opacity)
        + config.xing_weight * XING_SCALE * xing_loss(points)
        + config.bezier_weight * bezier_loss(points, width, height)
    )


# Opacity, equation (4).


def opacity_loss(opacity: Tensor) -> Tensor:
    """Mean of |1 - opacity| over the paths [N]: equation (4)."""
    return _mean((opacity - 1.0).abs())


# Xing: Ma et al., Towards Layer-wise Image Vectorization, 2022.


def xing_loss(points: Tensor) -> Tensor:
    """How far cubics turn back on themselves: LIVE's Xing loss without its scale of 1e-3, mean over all cubics.

    The loss of a cubic A, B, C, D is |sine| of the angle from AB to CD if that angle has the other sign than the one
    from AB to BC, else 0. A leg shorter than ``LEG_MIN`` has no direction, hence neither loss nor gradient.

    Args:
        points: control points [N, 3 S, 2] in pixels.
    """
    legs = _legs(_planes(points))
    return _mean((_cross(*_directions(legs[::2])) * _turn(legs)).neg().relu())


def _directions(legs: Tensor) -> Tensor:
    """Unit vectors [L, 2, N, S] of ``legs`` in pixels; 0 for those below ``LEG_MIN``."""
    length_squared = (legs * legs).sum(1)
    inverse_length = threshold(length_squared, LEG_MIN**2, math.inf).rsqrt()
    return legs * inverse_length[:, None]


def _turn(legs: Tensor) -> Tensor:
    """1 [N, S] where the angle from AB to BC is zero or positive (clockwise on screen), else -1."""
    return torch.where(_cross(legs[0], legs[1]) >= 0.0, 1.0, -1.0).to(legs.dtype)


# The Bezier regularizer: Liu et al., Bezier Splatting, 2025, carried over to closed paths of S cubics.


def bezier_loss(points: Tensor, width: float, height: float) -> Tensor:
    """Bezier Splatting's regularizer, carried over from two quintics to closed paths of S cubics.

    A sum of three terms, in coordinates in which the canvas is [-1, 1] on both axes:

    **Projection**, inner control points beyond the chord of their curve. The original has two quintics on one chord
    v = P5 - P0 and asks of the eight other points Q that a = (Q - P0).v / |v|^2 lies in [0, 1]:
    0.01 / N sum [relu(a - 1)^2 + relu(-a)^2]. Here each cubic has its own chord v and two inner points (eight per path
    again if S = 4), and both overshoots, (Q - A).v - |v|^2 and -(Q - A).v, are divided not by |v|^2 but by the extent
    of the path, a constant for the gradient: the mean over its cubics of max(|v|^2, |AB|^2 + |BC|^2 + |CD|^2), plus
    a pixel. That is the same for equal chords and modest overshoots; but one chord of several may well come near zero,
    where a ratio to itself would explode.

    **Tips**, needles at the joints. With u and w from a joint to the outline a little before and after it: mean of
    |u + w|^2, counted where u and w enclose less than 60 degrees. The joints are here all S anchors, not two, and
    u and w end at ``TIP_PARAMETER`` along the two cubics, not at samples of the outline.

    **Anchors**, joints off the canvas: mean of relu(|coordinate| - 1) over all S anchors, not two.

    Args:
        points: control points [N, 3 S, 2] in pixels.
        width, height: canvas in pixels.
    """
    planes = _planes(points)
    pixel = _pixel(points, width, height)
    legs = _legs(planes) * pixel
    chord = legs.sum(0)
    projection = (_overshoot(legs, chord).square() * _projection_weight(legs, chord, pixel)).sum()
    return projection + _mean(_tips(legs).square()) * 2.0 + _mean(_outside(planes[0] * pixel - 1.0).abs())


def _overshoot(legs: Tensor, chord: Tensor) -> Tensor:
    """Overshoots times chord [4, N, S] over both ends for both inner points."""
    return _combine(_beyond(legs.dtype, legs.device), (legs * chord).sum(1)).relu()


def _projection_weight(legs: Tensor, chord: Tensor, pixel: Tensor) -> Tensor:
    """What a squared overshoot times chord counts [N, S]: no gradient flows through the extent of the path."""
    with torch.no_grad():
        extent = torch.maximum(_dot(chord, chord), (legs * legs).sum((0, 1))).mean(-1, keepdim=True)
        extent += (EXTENT_MIN * pixel).square().sum()
        weight = extent.square_().reciprocal_().mul_(PROJECTION_WEIGHT / max(len(extent), 1))
        return weight.repeat(1, chord.shape[2])


@cache
def _beyond(dtype: torch.dtype, device: torch.device) -> Tensor:
    # B before A, B after D, C before A, C after D, from the dot products of the three legs with the chord.
    rows = [[-1, 0, 0], [0, -1, -1], [-1, -1, 0], [0, 0, -1]]
    return torch.tensor(rows, dtype=dtype, device=device)


def _tips(legs: Tensor) -> Tensor:
    """u + w [2, N, S] of each anchor where it is a needle tip, else 0."""
    ahead, arriving = _combine(_reach(legs.dtype, legs.device), legs)
    behind = arriving.roll(1, -1).neg()
    cosine = _dot(ahead, behind)
    needle = cosine.relu().square() > _dot(ahead, ahead) * _dot(behind, behind) * TIP_COSINE**2
    tips: Tensor = (ahead + behind) * needle
    return tips


@cache
def _reach(dtype: torch.dtype, device: torch.device) -> Tensor:
    # B(t) - A in the legs, each with the Bernstein weights of the points after it; D - B(1 - t) is its mirror image.
    t = TIP_PARAMETER
    third = t**3
    second = third + 3 * (1 - t) * t**2
    first = second + 3 * (1 - t) ** 2 * t
    return torch.tensor([[first, second, third], [third, second, first]], dtype=dtype, device=device)


def _outside(anchors: Tensor) -> Tensor:
    return anchors - anchors.clamp(-1.0, 1.0)


# Planes.


def _planes(points: Tensor) -> Tensor:
    """A, B, C of every cubic [3, 2, N, S] from control points [N, 3 S, 2]."""
    path_count, point_count, _ = points.shape
    return points.reshape(path_count, point_count // 3, 3, 2).permute(2, 3, 0, 1).contiguous()


def _legs(planes: Tensor) -> Tensor:
    return torch.cat([planes[1:], planes[:1].roll(-1, -1)]).sub(planes)


def _combine(rows: Tensor, planes: Tensor) -> Tensor:
    """Linear combinations of the first dimension, one for each of ``rows``."""
    return (rows @ planes.flatten(1)).view(len(rows), *planes.shape[1:])


def _pixel(like: Tensor, width: float, height: float) -> Tensor:
    """The size of a pixel [2, 1, 1] in normalised units."""
    return like.new_tensor([2.0 / width, 2.0 / height]).view(2, 1, 1)


def _dot(u: Tensor, v: Tensor) -> Tensor:
    return u[0] * v[0] + u[1] * v[1]


def _cross(u: Tensor, v: Tensor) -> Tensor:
    return u[0] * v[1] - u[1] * v[0]


def _mean(values: Tensor) -> Tensor:
    # Not Tensor.mean: the loss of a scene without paths is 0.
    return values.sum() / max(values.numel(), 1)
