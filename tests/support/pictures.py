"""Small pictures to fit."""

from __future__ import annotations

import torch

HEIGHT, WIDTH = 40, 56


def picture():
    """Draw discs and stripes over a ramp [40, 56, 3], with smooth areas and straight and round edges."""
    y, x = torch.meshgrid(torch.arange(HEIGHT) + 0.5, torch.arange(WIDTH) + 0.5, indexing="ij")
    image = torch.stack([x / WIDTH, y / HEIGHT, 0.3 + 0.0 * x], -1)
    image[(x - 18).square() + (y - 15).square() < 90] = torch.tensor([0.9, 0.2, 0.1])
    image[(x - 40).square() + (y - 26).square() < 60] = torch.tensor([0.1, 0.3, 0.9])
    image[(y > 33) & (x % 8 < 4)] = torch.tensor([1.0, 1.0, 0.8])
    return image
