"""Colours and opacities of gradient paints in each pixel, by complex numbers.

A point is the number x + i y. Division by the vector of a gradient turns and scales the plane so that the vector goes
from 0 to 1. The real part is then the place of a linear gradient, and the absolute value that of a radial one; for an
ellipse the imaginary part is stretched first. A pixel looks its two stops up by their offsets and mixes them. Autograd
differentiates all of it.
"""

from __future__ import annotations

import torch
from torch import Tensor

FLAT, LINEAR, RADIAL, ELLIPTIC = 0, 1, 2, 3


def pixel_colors(
    color: Tensor, kind: Tensor, geometry: Tensor, end_color: Tensor, height: int, width: int, shortest: float = 1e-3
) -> Tensor:
    """Return the colour [N, h, w, 3] of each path at the centres of the pixels.

    Args:
        color: colour of the first stop [N, 3], or of a flat path.
        kind: 0 for flat, 1 for linear, 2 for radial [N].
        geometry: x1, y1, x2, y2 of a linear gradient; cx, cy, r of a radial one [N, 4].
        end_color: colour of the second stop [N, 3].
        height: rows of the canvas.
        width: columns of the canvas.
        shortest: a gradient that is shorter, or not finite, shows its end colour everywhere.
    """
    pixels = _pixels(height, width)
    layers = []
    for first, last, paint, numbers in zip(color, end_color, kind.tolist(), geometry, strict=True):
        share = torch.zeros(height, width, dtype=torch.float64)
        if paint != FLAT:
            found = _PLACES[paint](numbers, pixels, shortest)
            share = torch.ones_like(share) if found is None else found.clamp(0.0, 1.0)
        layers.append(first + share[..., None] * (last - first))
    return torch.stack(layers) if layers else color.new_zeros(0, height, width, 3)


def pixel_stops(
    kind: Tensor, geometry: Tensor, offsets: list[Tensor], paints: list[Tensor], height: int, width: int
) -> Tensor:
    """Return the colour and opacity [N, h, w, 4] of each path at the centres of the pixels.

    Args:
        kind: 0 for flat, 1 for linear, 2 for radial, 3 for elliptic [N].
        geometry: as in `pixel_colors`; cx, cy, the axis and the radius across it of an elliptic gradient [N, 5].
        offsets: place of each stop of a path [S], in any order.
        paints: colour and opacity of each stop of a path [S, 4]; the first is that of a flat path.
        height: rows of the canvas.
        width: columns of the canvas.
    """
    pixels, layers = _pixels(height, width), []
    for number, numbers, places, values in zip(kind.tolist(), geometry, offsets, paints, strict=True):
        if number == FLAT:
            layers.append(values[0].expand(height, width, 4))
            continue
        found = _PLACES[number](numbers, pixels, 1e-3)
        layers.append(values[-1].expand(height, width, 4) if found is None else _mixed(found, places, values))
    return torch.stack(layers)


def _mixed(place: Tensor, offsets: Tensor, values: Tensor) -> Tensor:
    """Return the values [h, w, 4] at the places [h, w] between stops of these ``offsets``."""
    ordered = offsets.clamp(0.0, 1.0).cummax(0).values
    after = torch.searchsorted(ordered.detach(), place.detach().contiguous(), right=True)
    before, after = (after - 1).clamp_min(0), after.clamp_max(len(values) - 1)
    low, gap = ordered[before], ordered[after] - ordered[before]
    is_between = gap.detach() > 0
    share = torch.where(is_between, (place - low) / torch.where(is_between, gap, 1.0), 0.0)
    return values[before] + share[..., None] * (values[after] - values[before])


def _pixels(height: int, width: int) -> Tensor:
    rows, columns = (torch.arange(size, dtype=torch.float64) + 0.5 for size in (height, width))
    return torch.complex(*torch.meshgrid(columns, rows, indexing="xy"))


def _linear(numbers: Tensor, pixels: Tensor, shortest: float) -> Tensor | None:
    start, end = torch.complex(numbers[0], numbers[1]), torch.complex(numbers[2], numbers[3])
    if not shortest <= (end - start).abs().item() < torch.inf:
        return None
    return ((pixels - start) / (end - start)).real


def _radial(numbers: Tensor, pixels: Tensor, shortest: float) -> Tensor | None:
    if not (shortest <= numbers[2].item() < torch.inf and numbers[:2].isfinite().all()):
        return None
    return (pixels - torch.complex(numbers[0], numbers[1])).abs() / numbers[2]


def _elliptic(numbers: Tensor, pixels: Tensor, shortest: float) -> Tensor | None:
    center, axis = torch.complex(numbers[0], numbers[1]), torch.complex(numbers[2], numbers[3])
    shorter = min(axis.abs().item(), numbers[4].item())
    if not (shortest <= shorter and numbers.isfinite().all()):
        return None
    turned = (pixels - center) / axis
    return torch.complex(turned.real, turned.imag * axis.abs() / numbers[4]).abs()


_PLACES = {LINEAR: _linear, RADIAL: _radial, ELLIPTIC: _elliptic}
