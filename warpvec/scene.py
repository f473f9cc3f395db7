"""The scene: closed paths of Bezier curves, painted in order over a background."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from functools import cache
from typing import Any

import torch
from torch import Tensor

from warpvec.errors import InputError


@dataclass(frozen=True)
class Scene:
    """N closed paths of S Bezier curves of degree M each, row 0 at the bottom.

    Two shapes are in use: S cubics ("segments", what a file holds), and the paper's two curves of degree 5 ("sides").

    Attributes:
        points: control points [N, M S, 2] in pixels, x right, y down; curve s of a path has its
            points M s, M s + 1, ..., M s + M (modulo M S), so anchors stand at 0, M, 2 M, ...
        color: sRGB-encoded fill [N, 3] in [0, 1].
        opacity: fill opacity [N] in [0, 1].
        background: sRGB-encoded canvas colour [3] in [0, 1].
        generation: level of detail [N] (int64), 0 for the first; becomes the layer in the file.
        degree: M of every curve, 3 for cubics.
        transparent: whether no canvas is painted. The background is black then: an image over it is premultiplied.

    Raises:
        InputError: the degree is not positive or the shapes do not agree.
    """

    points: Tensor
    color: Tensor
    opacity: Tensor
    background: Tensor
    generation: Tensor
    degree: int = 3
    transparent: bool = False

    def __post_init__(self) -> None:
        if self.degree < 1:
            raise InputError(f"degree must be at least 1, got {self.degree}; 3 is that of cubics")
        _check_points(self.points, self.degree)
        count = len(self.points)
        expected = {"color": (count, 3), "opacity": (count,), "background": (3,), "generation": (count,)}
        for name, shape in expected.items():
            got = tuple(getattr(self, name).shape)
            if got != shape:
                raise InputError(f"{name} must have shape {list(shape)} beside {count} paths, got {list(got)}")

    def __len__(self) -> int:
        return len(self.points)

    @property
    def piece_count(self) -> int:
        """Curves per path, S: its segments if they are cubics."""
        return self.points.shape[1] // self.degree

    def detach(self) -> Scene:
        """The same scene outside autograd."""
        return replace(self, **{name: getattr(self, name).detach() for name in _FLOAT_FIELDS})

    def cpu(self) -> Scene:
        """The same scene in host memory."""
        return self.to("cpu")

    def to(self, device: str) -> Scene:
        """The same scene in the memory of ``device``."""
        return replace(self, **{name: getattr(self, name).to(device) for name in (*_FLOAT_FIELDS, "generation")})

    def to_dict(self) -> dict[str, Any]:
        """The fields by name, without copies."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    def scaled(self, x_factor: float, y_factor: float | None = None) -> Scene:
        """The scene on a canvas ``x_factor`` times as wide and ``y_factor``, the same if left out, times as high."""
        factors = [x_factor, x_factor if y_factor is None else y_factor]
        return replace(self, points=self.points * self.points.new_tensor(factors))

    def select(self, rows: Tensor) -> Scene:
        """The paths ``rows`` (indices or a mask [N]), in that order, over the same background."""
        names = ("points", "color", "opacity", "generation")
        return replace(self, **{name: getattr(self, name)[rows] for name in names})


def _check_points(points: Tensor, degree: int) -> None:
    shape = list(points.shape)
    if len(shape) != 3 or shape[1] == 0 or shape[1] % degree or shape[2] != 2:
        raise InputError(f"points must have shape [N, {degree} S, 2], S at least 1, for degree {degree}, got {shape}")


_FLOAT_FIELDS = ("points", "color", "opacity", "background")

# Distance of the inner control points from their anchor for a circle of radius 1, in units of the tangent of a
# quarter of the segment's angle: the classical 4/3 tan(angle / 4).
_CIRCLE_HANDLE = 4.0 / 3.0


def circle_points(center: Tensor, radius: Tensor, segment_count: int) -> Tensor:
    """Control points [N, 3 S, 2] of circles at ``center`` [N, 2] with ``radius`` [N], clockwise on screen."""
    step = 2.0 * math.pi / segment_count
    angle = torch.arange(segment_count, dtype=center.dtype, device=center.device) * step
    anchor = torch.stack([angle.cos(), angle.sin()], -1)
    tangent = torch.stack([-angle.sin(), angle.cos()], -1) * (_CIRCLE_HANDLE * math.tan(step / 4))
    following, following_tangent = anchor.roll(-1, 0), tangent.roll(-1, 0)
    unit = torch.stack([anchor, anchor + tangent, following - following_tangent], 1).reshape(-1, 2)
    return center[:, None, :] + radius[:, None, None] * unit


def circle_sides(center: Tensor, radius: Tensor, degree: int) -> Tensor:
    """Control points [N, 2 M, 2] of two-sided circles at ``center`` [N, 2] with ``radius`` [N], clockwise on screen.

    Each side is the curve of degree M closest to its half of the circle by the sum of squared distances at equal shares
    of the angle, so that it is also run through almost evenly. It starts and ends on the circle, to the right and to
    the left of its centre. The outline is off the circle by at most 0.06 % of the radius for M = 5, 0.7 % for 4, 3.3 %
    for 3 and 15 % for 2; M = 1 leaves a diameter.
    """
    side = _unit_side(degree).to(center)
    return center[:, None, :] + radius[:, None, None] * torch.cat([side, -side])


def bernstein(degree: int, t: Tensor) -> Tensor:
    """What each control point of a curve of degree M counts at the parameters ``t`` [...]: [..., M + 1]."""
    weights = [math.comb(degree, j) * (1.0 - t) ** (degree - j) * t**j for j in range(degree + 1)]
    return torch.stack(weights, -1)


# Points along a half circle that a side is fitted to: far more than a side of any sensible degree has control points.
_FITTED_ANGLES = 1000


@cache
def _unit_side(degree: int) -> Tensor:
    """The lower half of the circle of radius 1 without its end [M, 2] (float64)."""
    share = torch.linspace(0.0, 1.0, _FITTED_ANGLES, dtype=torch.float64)
    circle = torch.stack([(math.pi * share).cos(), (math.pi * share).sin()], -1)
    start = torch.tensor([[1.0, 0.0]], dtype=torch.float64)
    weights = bernstein(degree, share)
    remainder = circle - (weights[:, :1] - weights[:, -1:]) * start
    return torch.cat([start, torch.linalg.lstsq(weights[:, 1:-1], remainder).solution])
