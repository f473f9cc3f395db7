"""Gradients of several stops as the arrays of ``kernels/stops.py``, and their adjoints from its sums."""

from __future__ import annotations

from typing import NamedTuple

import torch
from torch import Tensor

from warpvec.geometry.gradients import Gradients
from warpvec.geometry.paints.kind import WHOLE_SIZE
from warpvec.geometry.paints.registry import FLAT, KINDS
from warpvec.geometry.stops import GAP_MIN, STOPS_MAX
from warpvec.kernels.stops import LINEAR_PLACE, ROOT_PLACE, SEGMENT_TERMS, WHOLE_TERMS


class StopAdjoints(NamedTuple):
    """dL/d(stops of N paths): of their colours [N, 3], [N, 3] and [N, 6, 3], of `Stops`, and of the geometry [N, 4]."""

    color: Tensor
    end_color: Tensor
    geometry: Tensor
    inner_color: Tensor
    offset: Tensor
    opacity: Tensor
    breadth: Tensor


class StopPaints:
    """The paints of N paths of a scene with `Stops`.

    Attributes:
        count, place_kind: [N] (int32).
        form: [N, 5].
        ramps: [N, STOPS_MAX, 8].
        hiding: opacity of each path [N] at its most translucent stop.
    """

    def __init__(self, color: Tensor, opacity: Tensor, gradients: Gradients) -> None:
        self._gradients = gradients
        self._stops = stops = gradients.all_stops()
        self._is_flat = gradients.kind == FLAT
        self._shows_end = gradients.is_degenerate()
        self.count = torch.where(self._is_flat | self._shows_end, 1, stops.count).to(torch.int32)
        self._last = (stops.count.long() - 1).clamp_min(0)
        self.place_kind, self.form = _forms(gradients)
        self._offset = stops.shown_offsets()
        self.ramps = self._ramps(color)
        self.hiding = opacity * gradients.least_opacity()

    def adjoints(self, adj_color: Tensor, sums: Tensor) -> StopAdjoints:
        """Return the adjoints from dL/d(colour of all stops together) [N, 3] and the sums [N, STOP_TERMS]."""
        parts = sums[:, WHOLE_TERMS:].reshape(-1, STOPS_MAX - 1, SEGMENT_TERMS)
        whole = torch.cat([adj_color, sums[:, :1]], 1)[:, None]
        steps = torch.cat([whole, parts[..., :4], torch.zeros_like(whole)], 1)
        adj = steps[:, :-1] - steps[:, 1:]  # by the colour and opacity of each stop [N, STOPS_MAX, 4]
        is_last = torch.arange(STOPS_MAX, device=adj.device) == self._last[:, None]
        adj = torch.where(self._shows_end[:, None, None], whole * is_last[..., None], adj)
        end = torch.where(is_last[..., None] & ~self._is_flat[:, None, None], adj, 0.0)
        inner = torch.where(is_last[..., None], 0.0, adj)[:, 1:-1, :3]
        geometry = self._geometry_adjoint(sums[:, 1:WHOLE_TERMS])
        opacity = torch.where(self._is_flat[:, None], 0.0, adj[..., 3])
        first = torch.where(self._shows_end[:, None], 0.0, adj[:, 0, :3])
        offset = self._offset_adjoint(parts[..., 4], parts[..., 5])
        return StopAdjoints(first, end[..., :3].sum(1), geometry[:, :4], inner, offset, opacity, geometry[:, 4])

    def _ramps(self, color: Tensor) -> Tensor:
        end_color, stops = self._gradients.end_color, self._stops
        alpha = torch.where(stops.is_used(), stops.opacity, stops.opacity.gather(1, self._last[:, None]))
        alpha = torch.where(self._is_flat[:, None], 1.0, alpha)
        values = torch.cat([stops.colors(color, end_color), alpha[..., None]], 2)
        first = torch.where(self._shows_end[:, None], values[:, -1], values[:, 0])
        gap = self._offset.diff(dim=1)
        inverse = torch.where(gap > GAP_MIN, gap.reciprocal(), 0.0)
        places = torch.stack([self._offset[:, :-1], self._offset[:, 1:], inverse, torch.zeros_like(gap)], 2)
        rows = torch.cat([places, values.diff(dim=1)], 2)
        start = torch.cat([torch.zeros_like(first), first], 1)
        return torch.cat([start[:, None], rows], 1)

    def _offset_adjoint(self, steep: Tensor, steep_share: Tensor) -> Tensor:
        """Return dL/d(offset) [N, STOPS_MAX] from the last two sums of each stop after the first [N, STOPS_MAX - 1]."""
        zero = torch.zeros_like(steep[:, :1])
        shown = torch.cat([steep_share - steep, zero], 1) - torch.cat([zero, steep_share], 1)
        offset, is_used = self._stops.offset, self._stops.is_used()
        source = torch.where(is_used, offset.clamp(0.0, 1.0), 1.0).cummax(1).indices
        comes_from = source[:, :, None] == torch.arange(STOPS_MAX, device=offset.device)
        is_free = is_used & (offset >= 0.0) & (offset <= 1.0)
        return torch.where(is_free, (shown[:, :, None] * comes_from).sum(1), 0.0)

    def _geometry_adjoint(self, moments: Tensor) -> Tensor:
        """Return dL/d(geometry) [N, 5] from the six sums of each gradient [N, 6]."""
        share, (x, y), squares = moments[:, 0], moments[:, 1:3].unbind(1), moments[:, 3:]
        first, second, third = self.form[:, 2:].unbind(1)
        halves = squares * squares.new_tensor([0.5, 1.0, 0.5])
        linear = torch.stack([-share * first, -share * second, x, y, torch.zeros_like(x)], 1)
        root = torch.cat([torch.stack([-first * x - second * y, -second * x - third * y], 1), halves], 1)
        adj_form = torch.where((self.place_kind == LINEAR_PLACE)[:, None], linear, root)
        adj, geometry = torch.zeros_like(adj_form), self._gradients.whole_geometry
        for number, kind in KINDS.items():
            is_own = (self._gradients.kind == number) & ~self._shows_end
            adj = torch.where(is_own[:, None], kind.form_adjoint(geometry, adj_form), adj)
        return adj


def _forms(gradients: Gradients) -> tuple[Tensor, Tensor]:
    """Return the kinds of places [N] and the forms [N, 5]; 0 for paths without a gradient that is drawn."""
    geometry = gradients.whole_geometry
    place_kind, form = torch.zeros_like(gradients.kind), geometry.new_zeros(len(geometry), WHOLE_SIZE)
    for number, kind in KINDS.items():
        is_own = (gradients.kind == number) & kind.is_drawn(geometry)
        place_kind = torch.where(is_own, ROOT_PLACE if kind.is_root else LINEAR_PLACE, place_kind)
        form = torch.where(is_own[:, None], kind.form(geometry), form)
    return place_kind.to(torch.int32), form
