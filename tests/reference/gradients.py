"""Colours of gradient paints in each pixel, by complex numbers.

A point is the number x + i y. Division by the vector of a linear gradient turns and scales the plane so that the vector
goes from 0 to 1; the real part is then the share of the end colour. Autograd differentiates all of it.
"""

from __future__ import annotations

import torch
from torch import Tensor

FLAT, LINEAR, RADIAL = 0, 1, 2


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
    rows, columns = (torch.arange(size, dtype=torch.float64) + 0.5 for size in (height, width))
    pixels = torch.complex(*torch.meshgrid(columns, rows, indexing="xy"))
    layers = []
    for first, last, paint, numbers in zip(color, end_color, kind.tolist(), geometry, strict=True):
        share = torch.zeros(height, width, dtype=torch.float64)
        if paint != FLAT:
            found = {LINEAR: _linear, RADIAL: _radial}[paint](numbers, pixels, shortest)
            share = torch.ones_like(share) if found is None else found.clamp(0.0, 1.0)
        layers.append(first + share[..., None] * (last - first))
    return torch.stack(layers) if layers else color.new_zeros(0, height, width, 3)


def _linear(numbers: Tensor, pixels: Tensor, shortest: float) -> Tensor | None:
    start, end = torch.complex(numbers[0], numbers[1]), torch.complex(numbers[2], numbers[3])
    if not shortest <= (end - start).abs().item() < torch.inf:
        return None
    return ((pixels - start) / (end - start)).real


def _radial(numbers: Tensor, pixels: Tensor, shortest: float) -> Tensor | None:
    if not (shortest <= numbers[2].item() < torch.inf and numbers[:2].isfinite().all()):
        return None
    return (pixels - torch.complex(numbers[0], numbers[1])).abs() / numbers[2]
