"""Gradient paints of the paths of a scene."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import torch
from torch import Tensor

from warpvec.errors import InputError

FLAT, LINEAR, RADIAL = 0, 1, 2
"""Kinds of paint."""

EXTENT_MIN = 1.0e-3
"""Length or radius in pixels below which a gradient counts as degenerate: its colours change within one pixel, so it
shows its end colour, and its derivatives, which grow as 1 / length, would say nothing."""


@dataclass(frozen=True)
class Gradients:
    """What N paths have beside the colour of the scene, which is that of their first stop.

    A gradient has two stops, at its ends, in user space. Colours are interpolated as they are encoded, and continue
    beyond the ends ("pad").

    Attributes:
        kind: paint of each path [N] (int32): ``FLAT``, ``LINEAR`` or ``RADIAL``.
        geometry: in pixels [N, 4]: x1, y1, x2, y2 of a linear gradient; cx, cy, r and an unused value of a radial one.
            Those of flat paths are unused.
        end_color: sRGB-encoded colour of the second stop [N, 3] in [0, 1]; unused for flat paths.

    Raises:
        InputError: the shapes do not agree.
    """

    kind: Tensor
    geometry: Tensor
    end_color: Tensor

    def __post_init__(self) -> None:
        count = len(self.kind)
        for name, shape in {"kind": (count,), "geometry": (count, 4), "end_color": (count, 3)}.items():
            got = tuple(getattr(self, name).shape)
            if got != shape:
                rule = f"must have shape {list(shape)} for {count} paths"
                raise InputError(f"gradients.{name}", rule, str(list(got)), "reshape it")

    @staticmethod
    def flat(color: Tensor) -> Gradients:
        """Return the paints of flat paths of ``color`` [N, 3]."""
        kind = torch.full((len(color),), FLAT, dtype=torch.int32, device=color.device)
        return Gradients(kind, color.new_zeros(len(color), 4), color.detach().clone())

    def __len__(self) -> int:
        return len(self.kind)

    def is_degenerate(self) -> Tensor:
        """Return a mask [N] of the gradients that show their end colour alone; False for flat paths.

        These are shorter than ``EXTENT_MIN`` or not finite.
        """
        start, end = self.geometry[:, :2], self.geometry[:, 2:]
        squared = (end - start).square().sum(1)
        is_line = (squared >= EXTENT_MIN**2) & squared.isfinite()
        is_disk = (end[:, 0] >= EXTENT_MIN) & end[:, 0].isfinite() & start.sum(1).isfinite()
        return (self.kind != FLAT) & ~torch.where(self.kind == RADIAL, is_disk, is_line)

    def map(self, change: Callable[[Tensor], Tensor]) -> Gradients:
        """Return the paints with each tensor replaced by what ``change`` makes of it."""
        return Gradients(change(self.kind), change(self.geometry), change(self.end_color))

    def joined(self, other: Gradients) -> Gradients:
        """Return these paints and those of ``other``."""
        pairs = ((getattr(self, name), getattr(other, name)) for name in ("kind", "geometry", "end_color"))
        return Gradients(*(torch.cat(pair) for pair in pairs))

    def scaled(self, x_factor: float, y_factor: float) -> Gradients:
        """Return the paints scaled about the origin. A radius is scaled by the geometric mean of the two factors."""
        radius = math.sqrt(abs(x_factor * y_factor))
        linear = self.geometry.new_tensor([x_factor, y_factor, x_factor, y_factor])
        radial = self.geometry.new_tensor([x_factor, y_factor, radius, 1.0])
        factors = torch.where((self.kind == RADIAL)[:, None], radial, linear)
        return replace(self, geometry=self.geometry * factors)

    def moved(self, x: float, y: float) -> Gradients:
        """Return the paints moved by ``x`` and ``y`` pixels."""
        linear, radial = (self.geometry.new_tensor(values) for values in ([x, y, x, y], [x, y, 0.0, 0.0]))
        return replace(self, geometry=self.geometry + torch.where((self.kind == RADIAL)[:, None], radial, linear))
