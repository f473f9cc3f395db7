"""The regularizers of the paths (equation 6): their values, and their adjoints for the fit.

The values are written in torch. Their adjoints come from ``kernels/regularization.py`` for cubics, in a tenth of the
time that autograd needs, and from autograd for curves of another degree.

Geometry is stored in planes whose last two dimensions are always [N, S]: S curves of degree M on each of N paths.
``planes`` [M, 2, N, S] are the control points of each curve except its last (A, B, C of a cubic); ``legs``
[M, 2, N, S] are the sides of its control polygon (AB, BC, CD of a cubic).
"""

from __future__ import annotations

import itertools
import math
from functools import cache
from typing import Any

import torch
import warp as wp
from torch import Tensor
from torch.nn.functional import threshold

from warpvec.config.fit_config import FitConfig
from warpvec.geometry.scene import Scene
from warpvec.kernels import regularization as kernels
from warpvec.kernels.constants import (
    EXTENT_MIN,
    LEG_MIN,
    PROJECTION_WEIGHT,
    TILE,
    TIP_COSINE,
    TIP_PARAMETER,
    XING_SCALE,
)
from warpvec.kernels.lanes import Lanes, make_lanes
from warpvec.rendering.launch import Launcher


def regularization(points: Tensor, opacity: Tensor, width: float, height: float, config: FitConfig) -> Tensor:
    """Return the weighted sum of the three regularizers of cubics, equation (6), for autograd.

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


class Regularization:
    """The adjoints of `regularization` for a canvas and the weights of ``config``.

    Attributes:
        can_record: True: its work is launches of kernels alone.
    """

    can_record = True

    def __init__(self, height: int, width: int, config: FitConfig, device: str) -> None:
        self._pixel = (2.0 / width, 2.0 / height)
        self._weights = (config.xing_weight * XING_SCALE, config.bezier_weight, config.opacity_weight)
        self._launch = Launcher(device, threads=1)
        self._buffers = self._launch.make_buffers()
        self._counts, self._path_count = torch.zeros(1, dtype=torch.int32, device=device), 0

    def add_adjoint(
        self, scene: Scene, adj_segments: Tensor, adj_opacity: Tensor, counts: Tensor | None = None
    ) -> None:
        """Add dL/dsegments [R, 3, 2] and dL/dopacity [N] of `regularization`, in place.

        ``counts`` [1] (int32), on the device, is the number of paths that there are, if the scene has room for more.
        """
        lanes = make_lanes(1 if self._launch.device.is_cuda else TILE, wp.dtype_from_torch(scene.segments.dtype))
        structure, view = scene.structure, self._buffers.view
        points = view("segments", scene.segments, lanes.vec2, -1, 2)
        names = ("path_first_segment", "segment_next", "segment_previous")
        rows = [view(name, getattr(structure, name), wp.int32) for name in names]
        if counts is None:
            counts = self._count_of(scene)
        count = view("counts", counts, wp.int32)
        inputs = [points, view("opacity", scene.opacity, lanes.dtype), *rows, count, *self._settings(lanes)]
        outputs = [view("adj_segments", adj_segments, lanes.vec2, -1, 2), view("adj_opacity", adj_opacity, lanes.dtype)]
        self._launch(kernels.make_kernels(lanes).add_regularizers, len(scene), [*inputs, *outputs])

    def _count_of(self, scene: Scene) -> Tensor:
        if self._path_count != len(scene):
            self._path_count = len(scene)
            self._counts.fill_(self._path_count)
        return self._counts

    def _settings(self, lanes: Lanes) -> list[Any]:
        return [lanes.vec2(*self._pixel), *(lanes.dtype(weight) for weight in self._weights)]


# Opacity, equation (5).


def opacity_loss(opacity: Tensor) -> Tensor:
    """Return the mean of |1 - opacity| over the paths [N]: equation (5)."""
    return _mean((opacity - 1.0).abs())


# Xing: Ma et al., Towards Layer-wise Image Vectorization, 2022.


def xing_loss(points: Tensor) -> Tensor:
    """Return how far curves turn back on themselves: LIVE's Xing loss without its factor 1e-3, mean over all cubics.

    The loss of a cubic A, B, C, D is |sine| of the angle from AB to CD if this angle and the one from AB to BC have
    opposite signs, else 0. A leg shorter than ``LEG_MIN`` has no direction, so it has neither loss nor gradient.

    Args:
        points: control points [N, 3 S, 2] in pixels.
    """
    legs = _legs(_planes(points, 3)).transpose(0, 1)
    directions = _directions(legs)
    return _mean((_cross(directions[:, :-2], directions[:, 2:]) * _turn(legs)).neg().relu())


def _directions(legs: Tensor) -> Tensor:
    """Return unit vectors along ``legs`` [2, 3, N, S] in pixels; 0 for legs shorter than ``LEG_MIN``."""
    length_squared = (legs * legs).sum(0)
    inverse_length = threshold(length_squared, LEG_MIN**2, math.inf).rsqrt()
    return legs * inverse_length


def _turn(legs: Tensor) -> Tensor:
    """Return 1 [1, N, S] where a leg's angle to the next is zero or positive (clockwise on screen), else -1."""
    return torch.where(_cross(legs[:, :-2], legs[:, 1:-1]) >= 0.0, 1.0, -1.0).to(legs.dtype)


# The Bezier regularizer: Liu et al., Bezier Splatting, 2025, carried over to closed paths of S cubics.


def bezier_loss(
    points: Tensor,
    width: float,
    height: float,
    degree: int = 3,
    tip_parameter: float = TIP_PARAMETER,
    projection_weight: float = PROJECTION_WEIGHT,
) -> Tensor:
    """Return Bezier Splatting's regularizer: the original for two sides of degree M, or adapted to S cubics.

    It is the sum of three terms, in coordinates in which the canvas is [-1, 1] on both axes:

    **Projection**: inner control points must not lie beyond the chord of their curve. The original has two quintics on
    one chord v = P5 - P0. For each of the eight other points Q, a = (Q - P0).v / |v|^2 should lie in [0, 1]; the term
    is 0.01 / N sum [relu(a - 1)^2 + relu(-a)^2]. Here each cubic has its own chord v and two inner points (if S = 4,
    again eight per path). Both overshoots, (Q - A).v - |v|^2 and -(Q - A).v, are divided not by |v|^2 but by the extent
    of the path: the mean over its cubics of max(|v|^2, |AB|^2 + |BC|^2 + |CD|^2), plus a pixel. No gradient flows
    through the extent. For equal chords and modest overshoots this is the same; but one of several chords may be short,
    and its |v|^2 would make the ratio explode. Two sides of another degree use the original with two changes. The pixel
    is added too. And |v|^2 is at least the mean square of the side's M legs, averaged over both sides. No gradient
    flows through these legs, or points would move apart to lengthen them; it does flow through v.

    **Tips**: the joints must not be needles. Let u and w lead from a joint to the outline a little before and after it.
    The term is the mean of |u + w|^2, counted where u and w enclose less than 60 degrees. The joints of cubics are all
    S anchors, not two. u and w end at a parameter of the curves, not at samples of the outline.

    **Anchors**: joints must not lie off the canvas. The term is the mean of relu(|coordinate| - 1) over the joints: all
    S anchors of cubics, the two ends of sides.

    Args:
        points: control points [N, M S, 2] in pixels; S = 2 unless the curves are cubics.
        width, height: canvas in pixels.
        degree: M.
        tip_parameter: parameter along a curve at which u or w ends.
        projection_weight: weight of the projection.
    """
    planes = _planes(points, degree)
    pixel = _pixel(points, width, height)
    legs = _legs(planes) * pixel
    chord = legs.sum(0)
    projection = (_overshoot(legs, chord).square() * _projection_share(legs, chord, pixel)).sum()
    tips = _tips(legs, tip_parameter)
    return projection_weight * projection + _mean(tips.square()) * 2.0 + _mean(_outside(planes[0] * pixel - 1.0).abs())


def _overshoot(legs: Tensor, chord: Tensor) -> Tensor:
    """Return the inner points' overshoots times the chord's length [2 M - 2, N, S], over both ends."""
    return _combine(_beyond(len(legs), legs.dtype, legs.device), (legs * chord).sum(1)).relu()


def _projection_share(legs: Tensor, chord: Tensor, pixel: Tensor) -> Tensor:
    """Return the weight [N, 1] of a squared overshoot; no gradient flows through it, except by the chord of sides."""
    chord_squared, legs_squared = _dot(chord, chord), (legs * legs).sum((0, 1)).detach()
    if len(legs) == 3:
        extent = torch.maximum(chord_squared.detach(), legs_squared)
    else:
        extent = torch.maximum(chord_squared, legs_squared / len(legs))
    extent = extent.mean(-1, keepdim=True) + (EXTENT_MIN * pixel).square().sum()
    return extent.square().reciprocal() / max(len(extent), 1)


@cache
def _beyond(degree: int, dtype: torch.dtype, device: torch.device) -> Tensor:
    # Rows that combine the dot products of the legs with the chord to overshoots: for each inner point, the one before
    # the start and the one after the end.
    inner, legs = range(1, degree), range(degree)
    rows = [[-(after == (leg >= point)) for leg in legs] for point in inner for after in (False, True)]
    return torch.tensor(rows, dtype=dtype, device=device).reshape(-1, degree)


def _tips(legs: Tensor, t: float) -> Tensor:
    """Return u + w [2, N, S] of each anchor, up to ``t`` along its two curves, where it is a needle tip, else 0."""
    ahead, arriving = _combine(_reach(len(legs), t, legs.dtype, legs.device), legs)
    behind = arriving.roll(1, -1).neg()
    cosine = _dot(ahead, behind)
    needle = cosine.relu().square() > _dot(ahead, ahead) * _dot(behind, behind) * TIP_COSINE**2
    tips: Tensor = (ahead + behind) * needle
    return tips


@cache
def _reach(degree: int, t: float, dtype: torch.dtype, device: torch.device) -> Tensor:
    # The vector from 1 - t to a curve's end is the mirror image of that from its start to t.
    first = tip_reach(degree, t)
    return torch.tensor([first, first[::-1]], dtype=dtype, device=device)


def tip_reach(degree: int, t: float) -> list[float]:
    """Return the weights of the ``degree`` legs of a curve in the vector from its start to the parameter ``t``.

    Each is the sum of the Bernstein weights of the points after the leg.
    """
    weights = [math.comb(degree, j) * (1 - t) ** (degree - j) * t**j for j in range(degree, 0, -1)]
    return list(itertools.accumulate(weights))[::-1]


def _outside(anchors: Tensor) -> Tensor:
    return anchors - anchors.clamp(-1.0, 1.0)


# Planes.


def _planes(points: Tensor, degree: int) -> Tensor:
    """Return all control points of each curve except its last [M, 2, N, S] from control points [N, M S, 2]."""
    path_count, point_count, _ = points.shape
    return points.reshape(path_count, point_count // degree, degree, 2).permute(2, 3, 0, 1).contiguous()


def _legs(planes: Tensor) -> Tensor:
    return torch.cat([planes[1:], planes[:1].roll(-1, -1)]).sub(planes)


def _combine(rows: Tensor, planes: Tensor) -> Tensor:
    """Return linear combinations of the first dimension of ``planes``, one for each of ``rows``."""
    return (rows @ planes.flatten(1)).view(len(rows), *planes.shape[1:])


def _pixel(like: Tensor, width: float, height: float) -> Tensor:
    """Return the size of a pixel [2, 1, 1] in units in which the canvas is [-1, 1]."""
    return like.new_tensor([2.0 / width, 2.0 / height]).view(2, 1, 1)


def _dot(u: Tensor, v: Tensor) -> Tensor:
    return u[0] * v[0] + u[1] * v[1]


def _cross(u: Tensor, v: Tensor) -> Tensor:
    return u[0] * v[1] - u[1] * v[0]


def _mean(values: Tensor) -> Tensor:
    # The loss of a scene without paths is 0; Tensor.mean would give NaN.
    return values.sum() / max(values.numel(), 1)
