"""Removal costs round as torch does on the CPU, so that fits keep their bytes.

``stages/test_compositing_adjoint.py`` compares them with the error of drawings without a path.
"""

from __future__ import annotations

import pytest
import torch

from warpvec.rendering.exact import ExactRenderer


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
@pytest.mark.parametrize("lane_width", [1, 16])
def test_a_cost_has_the_bits_of_the_formula(dtype: torch.dtype, lane_width: int) -> None:
    renderer = ExactRenderer(37, 41, dtype=dtype, lane_width=lane_width)
    opacity, adjoint = torch.rand(500, dtype=dtype), torch.randn(500, dtype=dtype)
    curvature, scale = 40.0 * torch.rand(500, dtype=dtype), 1.0 / (3 * 37 * 41)
    want = opacity * opacity * curvature * scale - opacity * adjoint
    renderer._cost_removals(opacity, adjoint, scale, curvature)
    assert torch.equal(curvature, want)
