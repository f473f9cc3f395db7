"""The stops of gradients that have more than two opaque ones at their ends: offsets, opacities, and a second radius."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields

import torch
from torch import Tensor

from warpvec.errors import InputError

STOPS_MAX = 8
"""Most stops of a gradient. The gradients of 21 Noto emoji have five at most."""

GAP_MIN = 1e-6
"""Smallest distance of two offsets that is no jump. The derivative by an offset grows as 1 / distance, and files state
offsets with four decimals."""


@dataclass(frozen=True)
class Stops:
    """The stops of N paths, of which a path has ``count``.

    The colour of the first stop is that of the scene, and the colour of the last one `Gradients.end_color`. Opacities
    multiply that of the path. Colour and opacity are interpolated each by itself, as SVG does. An offset counts as at
    least 0, at most 1, and at least every offset before it. Values of stops that a path does not have are unused.

    Attributes:
        count: stops of each path [N] (int32), from 2 to ``STOPS_MAX``. All values of flat paths are unused.
        offset: place of each stop [N, STOPS_MAX], 0 for the start of the gradient and 1 for its end.
        inner_color: sRGB-encoded colours of the stops between the first and the last [N, STOPS_MAX - 2, 3] in [0, 1].
        opacity: opacity of each stop [N, STOPS_MAX] in [0, 1].
        breadth: radius in pixels [N] of an elliptic gradient across its axis; unused for other kinds.

    Raises:
        InputError: the shapes do not agree.
    """

    count: Tensor
    offset: Tensor
    inner_color: Tensor
    opacity: Tensor
    breadth: Tensor

    def __post_init__(self) -> None:
        n = len(self.count)
        wanted = {"count": (n,), "offset": (n, STOPS_MAX), "inner_color": (n, STOPS_MAX - 2, 3)}
        for name, shape in {**wanted, "opacity": (n, STOPS_MAX), "breadth": (n,)}.items():
            if tuple(getattr(self, name).shape) != shape:
                rule = f"must have shape {list(shape)} for {n} paths"
                raise InputError(f"gradients.stops.{name}", rule, str(list(getattr(self, name).shape)), "reshape it")

    @staticmethod
    def two(like: Tensor) -> Stops:
        """Return two opaque stops at the ends for each of N paths, in the type of ``like`` [N, ...]."""
        count = torch.full((len(like),), 2, dtype=torch.int32, device=like.device)
        offset = like.new_ones(len(like), STOPS_MAX)
        offset[:, 0] = 0.0
        inner = like.new_zeros(len(like), STOPS_MAX - 2, 3)
        return Stops(count, offset, inner, torch.ones_like(offset), like.new_zeros(len(like)))

    def map(self, change: Callable[[Tensor], Tensor]) -> Stops:
        """Return the stops with each tensor replaced by what ``change`` makes of it."""
        return Stops(*(change(getattr(self, field.name)) for field in fields(Stops)))

    def joined(self, other: Stops) -> Stops:
        """Return these stops and those of ``other``."""
        names = [field.name for field in fields(Stops)]
        return Stops(*(torch.cat([getattr(self, name), getattr(other, name)]) for name in names))

    def is_used(self) -> Tensor:
        """Return which stops the paths have [N, STOPS_MAX]."""
        return torch.arange(STOPS_MAX, device=self.count.device) < self.count[:, None]

    def is_plain(self) -> Tensor:
        """Return which paths [N] have two opaque stops, at 0 and 1."""
        opaque = ((self.opacity == 1.0) | ~self.is_used()).all(1)
        return opaque & (self.count == 2) & (self.offset[:, 0] <= 0.0) & (self.offset[:, 1] >= 1.0)

    def least_opacity(self) -> Tensor:
        """Return the opacity of the most translucent stop of each path [N]."""
        return torch.where(self.is_used(), self.opacity, 1.0).amin(1)

    def shown_offsets(self) -> Tensor:
        """Return the offsets that count [N, STOPS_MAX], in order and in [0, 1]; those after the last stop are 1."""
        return torch.where(self.is_used(), self.offset.clamp(0.0, 1.0), 1.0).cummax(1).values

    def colors(self, first: Tensor, last: Tensor) -> Tensor:
        """Return the colours of all stops [N, STOPS_MAX, 3]; those after the last stop are the last one's."""
        between = torch.cat([first[:, None], self.inner_color, last[:, None]], 1)
        is_before = torch.arange(STOPS_MAX, device=self.count.device) < self.count[:, None] - 1
        return torch.where(is_before[..., None], between, last[:, None])
