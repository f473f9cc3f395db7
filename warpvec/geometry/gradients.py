"""Gradient paints of the paths of a scene."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import torch
from torch import Tensor

from warpvec.errors import InputError
from warpvec.geometry.paints.kind import GradientKind
from warpvec.geometry.paints.registry import FLAT, KINDS, unknown_kind


def check_shape(name: str, tensor: Tensor, shape: tuple[int, ...], count: int) -> None:
    """Raise InputError unless a ``tensor`` of ``count`` paths has this ``shape``."""
    if tuple(tensor.shape) != shape:
        rule = f"must have shape {list(shape)} for {count} paths"
        raise InputError(name, rule, str(list(tensor.shape)), "reshape it")


@dataclass(frozen=True)
class Gradients:
    """What N paths have beside the colour of the scene, which is that of their first stop.

    A gradient has two stops, at its ends, in user space. Colours are interpolated as they are encoded, and continue
    beyond the ends ("pad").

    Attributes:
        kind: paint of each path [N] (int32): ``FLAT`` or a key of ``KINDS`` of `warpvec.geometry.paints.registry`.
        geometry: in pixels [N, 4]: the numbers that the kind has; those of flat paths are unused.
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
            check_shape(f"gradients.{name}", getattr(self, name), shape, count)

    def check_kinds(self) -> None:
        """Refuse a kind that is not in the registry. It is not looked for on a GPU: that would wait for its work.

        Raises:
            InputError: there is one.
        """
        if len(self.kind) and self.kind.device.type == "cpu":
            unknown = self.kind[~torch.isin(self.kind, torch.tensor([FLAT, *KINDS]))]
            if len(unknown):
                raise unknown_kind(int(unknown[0]))

    @staticmethod
    def none(color: Tensor) -> Gradients:
        """Return the paints of flat paths of ``color`` [N, 3]."""
        kind = torch.full((len(color),), FLAT, dtype=torch.int32, device=color.device)
        return Gradients(kind, color.new_zeros(len(color), 4), color.detach().clone())

    def __len__(self) -> int:
        return len(self.kind)

    def is_degenerate(self) -> Tensor:
        """Return a mask [N] of the gradients that show their end colour alone; False for flat paths.

        These are smaller than ``RAMP_EXTENT_MIN`` of `warpvec.geometry.paints.kind`, or not finite.
        """
        self.check_kinds()
        is_drawn = self.kind == FLAT
        for number, kind in KINDS.items():
            is_drawn = is_drawn | (self.kind == number) & kind.is_drawn(self.geometry)
        return ~is_drawn

    def map(self, change: Callable[[Tensor], Tensor]) -> Gradients:
        """Return the paints with each tensor replaced by what ``change`` makes of it."""
        return Gradients(change(self.kind), change(self.geometry), change(self.end_color))

    def joined(self, other: Gradients) -> Gradients:
        """Return these paints and those of ``other``."""
        pairs = ((getattr(self, name), getattr(other, name)) for name in ("kind", "geometry", "end_color"))
        return Gradients(*(torch.cat(pair) for pair in pairs))

    def scaled(self, x_factor: float, y_factor: float) -> Gradients:
        """Return the paints scaled about the origin."""
        return self._with_geometry(lambda kind: kind.scaled(self.geometry, x_factor, y_factor))

    def moved(self, x: float, y: float) -> Gradients:
        """Return the paints moved by ``x`` and ``y`` pixels."""
        return self._with_geometry(lambda kind: kind.moved(self.geometry, x, y))

    def _with_geometry(self, changed: Callable[[GradientKind], Tensor]) -> Gradients:
        """Return the paints with what ``changed`` makes of all geometries [N, 4] as those of one kind."""
        self.check_kinds()
        geometry = self.geometry
        for number, kind in KINDS.items():
            geometry = torch.where((self.kind == number)[:, None], changed(kind), geometry)
        return replace(self, geometry=geometry)
