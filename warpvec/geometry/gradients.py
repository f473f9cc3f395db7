"""Gradient paints of the paths of a scene."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import torch
from torch import Tensor

from warpvec.errors import InputError
from warpvec.geometry.paints.kind import GradientKind
from warpvec.geometry.paints.registry import FLAT, KINDS, unknown_kind
from warpvec.geometry.stops import Stops


def check_shape(name: str, tensor: Tensor, shape: tuple[int, ...], count: int) -> None:
    """Raise InputError unless a ``tensor`` of ``count`` paths has this ``shape``."""
    if tuple(tensor.shape) != shape:
        rule = f"must have shape {list(shape)} for {count} paths"
        raise InputError(name, rule, str(list(tensor.shape)), "reshape it")


@dataclass(frozen=True)
class Gradients:
    """What N paths have beside the colour of the scene, which is that of their first stop.

    A gradient lies in user space, and has two opaque stops at its ends, or those of ``stops``. Colours are interpolated
    as they are encoded, and continue beyond the ends ("pad").

    Attributes:
        kind: paint of each path [N] (int32): ``FLAT`` or a key of ``KINDS`` of `warpvec.geometry.paints.registry`.
        geometry: in pixels [N, 4]: the numbers that the kind has; those of flat paths are unused.
        end_color: sRGB-encoded colour of the last stop [N, 3] in [0, 1]; unused for flat paths.
        stops: more about the stops; None if every gradient has two opaque stops at its ends.

    Raises:
        InputError: the shapes do not agree.
    """

    kind: Tensor
    geometry: Tensor
    end_color: Tensor
    stops: Stops | None = None

    def __post_init__(self) -> None:
        count = len(self.kind)
        if self.stops is not None and len(self.stops.count) != count:
            raise InputError("gradients.stops", f"must have {count} entries", str(len(self.stops.count)), "add some")
        for name, shape in {"kind": (count,), "geometry": (count, 4), "end_color": (count, 3)}.items():
            check_shape(f"gradients.{name}", getattr(self, name), shape, count)

    def check_kinds(self) -> None:
        """Refuse a kind that is not in the registry. It is not looked for on a GPU: that would wait for its work.

        Raises:
            InputError: there is one.
        """
        if len(self.kind) and self.kind.device.type == "cpu":
            known = [number for number, kind in KINDS.items() if self.stops is not None or not kind.needs_stops]
            unknown = self.kind[~torch.isin(self.kind, torch.tensor([FLAT, *known]))]
            if len(unknown):
                raise unknown_kind(int(unknown[0]))

    @staticmethod
    def none(color: Tensor) -> Gradients:
        """Return the paints of flat paths of ``color`` [N, 3]."""
        kind = torch.full((len(color),), FLAT, dtype=torch.int32, device=color.device)
        return Gradients(kind, color.new_zeros(len(color), 4), color.detach().clone())

    def __len__(self) -> int:
        return len(self.kind)

    @property
    def whole_geometry(self) -> Tensor:
        """All numbers of the geometries: [N, 4], or with stops [N, 5], whose last one is their breadth."""
        return self.geometry if self.stops is None else torch.cat([self.geometry, self.stops.breadth[:, None]], 1)

    def is_degenerate(self) -> Tensor:
        """Return a mask [N] of the gradients that show their end colour alone; False for flat paths.

        These are smaller than ``RAMP_EXTENT_MIN`` of `warpvec.geometry.paints.kind`, or not finite.
        """
        self.check_kinds()
        is_drawn, geometry = self.kind == FLAT, self.whole_geometry
        for number, kind in KINDS.items():
            if self.stops is not None or not kind.needs_stops:
                is_drawn = is_drawn | (self.kind == number) & kind.is_drawn(geometry)
        return ~is_drawn

    def map(self, change: Callable[[Tensor], Tensor]) -> Gradients:
        """Return the paints with each tensor replaced by what ``change`` makes of it."""
        stops = None if self.stops is None else self.stops.map(change)
        return Gradients(change(self.kind), change(self.geometry), change(self.end_color), stops)

    def joined(self, other: Gradients) -> Gradients:
        """Return these paints and those of ``other``."""
        names = ("kind", "geometry", "end_color")
        kind, geometry, end_color = (torch.cat([getattr(self, name), getattr(other, name)]) for name in names)
        stops = None
        if self.stops is not None or other.stops is not None:
            stops = self.all_stops().joined(other.all_stops())
        return Gradients(kind, geometry, end_color, stops)

    def all_stops(self) -> Stops:
        """Return the stops of all paths, also of those that have two opaque ones at the ends."""
        return Stops.two(self.end_color) if self.stops is None else self.stops

    def with_two_stops(self, rows: Tensor) -> Gradients:
        """Return the paints with two opaque stops at the ends for the paths ``rows`` (indices)."""
        own = torch.arange(len(self), device=self.kind.device)
        own[rows] += len(self)
        stops = self.all_stops().joined(Stops.two(self.end_color)).map(lambda values: values[own])
        return replace(self, stops=stops)

    def without_plain_stops(self) -> Gradients:
        """Return the paints without ``stops`` if these say nothing: such a scene is drawn faster."""
        if self.stops is None:
            return self
        needs = torch.tensor([number for number, kind in KINDS.items() if kind.needs_stops])
        is_plain = self.stops.is_plain() & ~torch.isin(self.kind, needs.to(self.kind))
        return replace(self, stops=None) if bool((is_plain | (self.kind == FLAT)).all()) else self

    def is_one_color(self, color: Tensor) -> Tensor:
        """Return which gradients [N], whose first stops have the ``color`` [N, 3], show that alone, opaque."""
        if self.stops is None:
            return (self.end_color == color).all(1)
        is_same = (self.stops.colors(color, self.end_color) == color[:, None]).all(2)
        return (is_same & ((self.stops.opacity == 1.0) | ~self.stops.is_used())).all(1)

    def least_opacity(self) -> Tensor:
        """Return the opacity of the most translucent stop of each path [N]; 1 for flat ones."""
        return torch.where(self.kind == FLAT, 1.0, self.all_stops().least_opacity())

    def last_opacity(self) -> Tensor:
        """Return the opacity of the last stop of each path [N]; 1 without any."""
        if self.stops is None:
            return torch.ones_like(self.end_color[:, 0])
        last = self.stops.opacity.gather(1, (self.stops.count.long() - 1).clamp_min(0)[:, None])[:, 0]
        return torch.where(self.kind == FLAT, 1.0, last)

    def shown_at(self, row: int, first: Tensor, place: float) -> Tensor:
        """Return the colour and opacity [4] of path ``row`` at a ``place``; its ``first`` stop has this colour [3]."""
        stops, count = self.all_stops().map(lambda values: values[row : row + 1]), int(self.all_stops().count[row])
        colors = stops.colors(first[None], self.end_color[row : row + 1])[0, :count]
        values = torch.cat([colors, stops.opacity[0, :count, None]], 1)
        offset = stops.shown_offsets()[0, :count]
        after = int((offset <= place).sum())
        if after in (0, count):
            return values[min(after, count - 1)]
        share = (place - offset[after - 1]) / (offset[after] - offset[after - 1])
        return torch.lerp(values[after - 1], values[after], share)

    def of_one_color(self, color: Tensor) -> Gradients | None:
        """Return the paints of paths that have one ``color`` [N, 3] each and cover what these cover."""
        if self.stops is None:
            return None
        inner = color[:, None].expand_as(self.stops.inner_color).contiguous()
        return replace(self, end_color=color, stops=replace(self.stops, inner_color=inner))

    def opaque(self) -> Gradients:
        """Return the paints with opaque stops."""
        if self.stops is None:
            return self
        stops = replace(self.stops, opacity=torch.ones_like(self.stops.opacity))
        return replace(self, stops=stops).without_plain_stops()

    def scaled(self, x_factor: float, y_factor: float) -> Gradients:
        """Return the paints scaled about the origin."""
        return self._with_geometry(lambda kind, geometry: kind.scaled(geometry, x_factor, y_factor))

    def moved(self, x: float, y: float) -> Gradients:
        """Return the paints moved by ``x`` and ``y`` pixels."""
        return self._with_geometry(lambda kind, geometry: kind.moved(geometry, x, y))

    def to_dict(self) -> dict[str, Any]:
        """Return the paints as tensors by name; `from_dict` takes them back. Whole numbers are int64, as in files."""
        own = {"kind": self.kind.long(), "geometry": self.geometry, "end_color": self.end_color}
        if self.stops is None:
            return own
        return {**own, "stops": {**vars(self.stops), "count": self.stops.count.long()}}

    @staticmethod
    def from_dict(values: dict[str, Any]) -> Gradients:
        """Return the paints whose `to_dict` is ``values``."""
        stops = values.get("stops")
        if stops is not None:
            stops = Stops(**{**stops, "count": stops["count"].int()})
        return Gradients(**{**values, "kind": values["kind"].int(), "stops": stops})

    def _with_geometry(self, changed: Callable[[GradientKind, Tensor], Tensor]) -> Gradients:
        """Return the paints with what ``changed`` makes of all geometries [N, 4 or 5] as those of one kind."""
        self.check_kinds()
        before = geometry = self.whole_geometry
        for number, kind in KINDS.items():
            if self.stops is not None or not kind.needs_stops:
                geometry = torch.where((self.kind == number)[:, None], changed(kind, before), geometry)
        if self.stops is None:
            return replace(self, geometry=geometry)
        stops = replace(self.stops, breadth=geometry[:, 4].contiguous())
        return replace(self, geometry=geometry[:, :4].contiguous(), stops=stops)
