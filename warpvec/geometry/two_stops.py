"""Say gradients of any stops by two opaque ones, which fits of photos move."""

from __future__ import annotations

from dataclasses import replace

import torch
from torch import Tensor

from warpvec.geometry.gradients import Gradients
from warpvec.geometry.paints.registry import FLAT, KINDS
from warpvec.geometry.scene import Scene
from warpvec.geometry.stops import Stops

_PLACES = 65
"""Places between the ends of a gradient at which its colours are looked at: eight for each of its stops."""


def with_two_stops(scene: Scene) -> Scene:
    """Return ``scene`` with gradients of two opaque stops, whose colours are the nearest by least squares.

    The opacity of stops becomes that of their path, on average. Kinds that cannot do without more stops, such as
    elliptic ones, become the mean colour.
    """
    paints = scene.gradients
    if paints is None or paints.stops is None:
        return scene
    values = _values(scene.color, paints, paints.stops)
    place = torch.linspace(-0.5, 0.5, _PLACES).to(values)[None, :, None]
    mean = values.mean(1)
    half = (values * place).sum(1) / (place * place).sum() / 2.0
    needs = torch.tensor([number for number, kind in KINDS.items() if kind.needs_stops]).to(paints.kind)
    is_flat = (paints.kind == FLAT) | torch.isin(paints.kind, needs)
    is_plain = (paints.kind == FLAT) | (paints.stops.is_plain() & ~is_flat)
    half = torch.where(is_flat[:, None], 0.0, half)
    first, last = ((mean + sign * half)[:, :3].clamp(0.0, 1.0) for sign in (-1.0, 1.0))
    color = torch.where(is_plain[:, None], scene.color, first)
    end_color = torch.where(is_plain[:, None], paints.end_color, last)
    kind = torch.where(is_flat, FLAT, paints.kind)
    opacity = torch.where(is_plain, scene.opacity, scene.opacity * mean[:, 3])
    gradients = Gradients(kind, paints.geometry, end_color) if bool((kind != FLAT).any()) else None
    return replace(scene, color=color, opacity=opacity, gradients=gradients)


def _values(color: Tensor, paints: Gradients, stops: Stops) -> Tensor:
    """Return the colours and opacities [N, P, 4] at places from the first end of each gradient to the last."""
    known = torch.cat([stops.colors(color, paints.end_color), _kept(stops.opacity, stops)[..., None]], 2)
    offset = stops.shown_offsets().contiguous()
    place = torch.linspace(0.0, 1.0, _PLACES).to(offset).expand(len(offset), -1).contiguous()
    above = torch.searchsorted(offset, place).clamp(1, offset.shape[1] - 1)
    low, high = offset.gather(1, above - 1), offset.gather(1, above)
    share = ((place - low) / (high - low).clamp_min(1e-9)).clamp(0.0, 1.0)[..., None]
    rows = above[..., None].expand(-1, -1, 4)
    return known.gather(1, rows - 1) * (1.0 - share) + known.gather(1, rows) * share


def _kept(opacity: Tensor, stops: Stops) -> Tensor:
    """Return the opacities of stops [N, STOPS_MAX]; after the last one they stay as they are there."""
    last = opacity.gather(1, (stops.count.long() - 1).clamp_min(0)[:, None])
    return torch.where(stops.is_used(), opacity, last)
