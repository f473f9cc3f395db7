"""The blur of a soft path: its coverage on a canvas with a wide margin, convolved with a sampled Gaussian."""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn.functional import conv2d


def blurred(coverage: Tensor, sigma: Tensor, reach: int) -> Tensor:
    """Return ``coverage`` [h, w], zero outside, blurred by ``sigma`` px and cut off ``reach`` px from each pixel."""
    away = torch.arange(-reach, reach + 1, dtype=coverage.dtype)
    weights = torch.softmax(-0.5 * (away / sigma) ** 2, 0)
    return conv2d(coverage[None, None], torch.outer(weights, weights)[None, None], padding=reach)[0, 0]
