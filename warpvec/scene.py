"""The scene: closed paths of cubic segments, painted in order over a background."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import torch
from torch import Tensor

from warpvec.errors import InputError


@dataclass(frozen=True)
class Scene:
    """N closed paths of S cubic segments each, row 0 at the bottom.

    Attributes:
        points: control points [N, 3 S, 2] in pixels, x right, y down; segment s of a path is its
            points 3s, 3s+1, 3s+2, 3s+3 (modulo 3 S), so anchors stand at 0, 3, 6, ...
        color: sRGB-encoded fill [N, 3] in [0, 1].
        opacity: fill opacity [N] in [0, 1].
        background: sRGB-encoded canvas colour [3] in [0, 1].
        generation: level of detail [N] (int64), 0 for the first; becomes the layer in the file.

    Raises:
        InputError: the shapes do not agree.
    """

    points: Tensor
    color: Tensor
    opacity: Tensor
    background: Tensor
    generation: Tensor

    def __post_init__(self) -> None:
        count = len(self.points)
        if self.points.ndim != 3 or self.points.shape[1] % 3 or self.points.shape[2] != 2:
            raise InputError(f"points must have shape [N, 3 S, 2], got {list(self.points.shape)}")
        expected = {"color": (count, 3), "opacity": (count,), "background": (3,), "generation": (count,)}
        for name, shape in expected.items():
            got = tuple(getattr(self, name).shape)
            if got != shape:
                raise InputError(f"{name} must have shape {list(shape)} beside {count} paths, got {list(got)}")

    def __len__(self) -> int:
        return len(self.points)

    @property
    def segment_count(self) -> int:
        """Cubic segments per path."""
        return self.points.shape[1] // 3

    def detach(self) -> Scene:
        """The same scene outside autograd."""
        return replace(self, **{name: getattr(self, name).detach() for name in _FLOAT_FIELDS})

    def cpu(self) -> Scene:
        """The same scene in host memory."""
        return replace(self, **{name: getattr(self, name).cpu() for name in (*_FLOAT_FIELDS, "generation")})

    def scaled(self, x_factor: float, y_factor: float | None = None) -> Scene:
        """The scene on a canvas ``x_factor`` times as wide and ``y_factor``, the same if left out, times as high."""
        factors = [x_factor, x_factor if y_factor is None else y_factor]
        return replace(self, points=self.points * self.points.new_tensor(factors))

    def select(self, rows: Tensor) -> Scene:
        """The paths ``rows`` (indices or a mask [N]), in that order, over the same background."""
        names = ("points", "color", "opacity", "generation")
        return replace(self, **{name: getattr(self, name)[rows] for name in names})


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
