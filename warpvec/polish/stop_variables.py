"""The values of the stops of gradients that a fit may change, and their bounds."""

from __future__ import annotations

from collections.abc import Sequence

import torch
from torch import Tensor

from warpvec.geometry.gradients import Gradients
from warpvec.geometry.paints.registry import FLAT, KINDS
from warpvec.geometry.stops import STOPS_MAX

OPAQUE = 1.0 - 1e-3
"""A stop of at least this opacity is opaque and stays so, unless all values are free."""

BREADTH_MIN = 0.1
"""Smallest radius of an elliptic gradient in pixels across its axis: that of a file has one decimal."""

GAP_SHARE, GAP_LEAST = 0.5, 1e-3
"""Share of the gap between two stops that a step may take, and the gap below which they make a jump."""


def stop_parts(gradients: Gradients | None) -> list[Tensor]:
    """Return the values of the stops: inner colours [N, 6, 3], offsets [N, 8], opacities [N, 8], breadth [N]."""
    stops = None if gradients is None else gradients.stops
    return [] if stops is None else [stops.inner_color, stops.offset, stops.opacity, stops.breadth]


def free_stops(gradients: Gradients, *, are_translucent_free: bool, free: bool) -> list[Tensor]:
    """Return which of the values of `stop_parts` may change: masks in their shapes.

    The last offset is fixed, and that of a linear gradient's first stop: the geometry says the same. Opacities below
    ``OPAQUE`` are free if ``are_translucent_free``, and with ``free`` all of these.
    """
    stops, number = gradients.all_stops(), torch.arange(STOPS_MAX, device=gradients.kind.device)
    is_used = stops.is_used() & (gradients.kind != FLAT)[:, None]
    is_before_last = is_used & (number < stops.count[:, None] - 1)
    has_free_start = torch.tensor([key for key, kind in KINDS.items() if kind.has_free_start]).to(gradients.kind)
    is_centre = (~torch.isin(gradients.kind, has_free_start) & (stops.offset[:, 0] > 0.0))[:, None]
    needs_breadth = torch.tensor([key for key, kind in KINDS.items() if kind.needs_stops]).to(gradients.kind)
    inner = is_before_last[:, 1:-1, None].expand_as(stops.inner_color)
    opacity = is_used & ((stops.opacity < OPAQUE) | free) & are_translucent_free
    return [inner, is_before_last & ((number > 0) | is_centre), opacity, torch.isin(gradients.kind, needs_breadth)]


def bounded_offset_step(offset: Tensor, step: Tensor, count: Tensor) -> Tensor:
    """Return a ``step`` of the offsets [N, 8], made smaller where it would bring two stops of a path together.

    Each step may take ``GAP_SHARE`` of a gap, that before the first stop included. Stops that meet would stay together,
    as they say nothing of their places then. Gaps that are none, below ``GAP_LEAST``, do not hold the others.

    Args:
        offset: offsets [N, 8] before the step, in order.
        step: of the offsets [N, 8].
        count: stops of each path [N].
    """
    is_used = torch.arange(STOPS_MAX, device=count.device) < count[:, None]
    gap = torch.where(is_used, offset, 1.0).diff(dim=1, prepend=torch.zeros_like(offset[:, :1]))
    loss = -torch.where(is_used, step, 0.0).diff(dim=1, prepend=torch.zeros_like(step[:, :1]))
    is_held = is_used & (gap > GAP_LEAST) & (loss > 0.0)
    share = torch.where(is_held, GAP_SHARE * gap / loss.clamp_min(1e-12), 1.0)
    return step * share.amin(1, keepdim=True).clamp_max(1.0)


def bound_stops(parts: Sequence[Tensor], is_free: Sequence[Tensor], gradients: Gradients) -> None:
    """Bring the values of `stop_parts` into their bounds, in place: colours, offsets in order, opacities, breadth."""
    if not parts:
        return
    inner, offset, opacity, breadth = parts
    inner.clamp_(0.0, 1.0)
    is_used = gradients.all_stops().is_used()
    ordered = torch.where(is_used, offset.clamp(0.0, 1.0), 1.0).cummax(1).values
    offset.copy_(torch.where(is_free[1].any(1, keepdim=True), ordered, offset))
    opacity.copy_(torch.where(is_free[2], opacity.clamp(0.0, 1.0), opacity))
    breadth.copy_(torch.where(is_free[3], breadth.clamp_min(BREADTH_MIN), breadth))
