"""`GradientParameters`: what a step does to their values and to the state of their optimizer."""

from __future__ import annotations

from typing import Any

import torch

from warpvec.config.fit_config import FitConfig
from warpvec.fit.gradient_paints import GradientParameters
from warpvec.geometry.gradients import Gradients
from warpvec.geometry.paints.registry import FLAT, LINEAR, RADIAL


def make_parameters(device: str) -> GradientParameters:
    generator = torch.Generator().manual_seed(0)
    kind = torch.tensor([LINEAR, FLAT, RADIAL], dtype=torch.int32)
    geometry, end_color = torch.rand(3, 4, generator=generator), torch.rand(3, 3, generator=generator)
    gradients = Gradients(kind, 9.0 * geometry, end_color).map(lambda value: value.to(device))
    return GradientParameters(gradients, FitConfig(), half_side=8.0)


def take_step(parameters: GradientParameters, seed: int, fits: float, device: str) -> None:
    generator = torch.Generator().manual_seed(seed)
    adjoints = (torch.randn(3, width, generator=generator).to(device) for width in (3, 4))
    parameters.step(*adjoints, factor=1.0, fits=torch.tensor([fits], dtype=torch.float64, device=device))


def tensors(parameters: GradientParameters) -> dict[str, torch.Tensor]:
    found: dict[str, torch.Tensor] = {name: value for name, value in vars(parameters.live).items() if value is not None}
    parts: dict[str, Any] = parameters.state()
    for part, state in parts.items():
        found |= {f"{part}.{name}": value for name, value in {"value": state["value"], **state["steps"]}.items()}
    return found


def test_a_dropped_step_changes_nothing(device: str) -> None:
    parameters = make_parameters(device)
    take_step(parameters, 0, 1.0, device)
    before = {name: value.clone() for name, value in tensors(parameters).items()}
    take_step(parameters, 1, -1.0, device)
    changed = [name for name, value in tensors(parameters).items() if not torch.equal(value, before[name])]
    assert len(before) == 3 + 2 * 6 and not changed


def test_a_dropped_first_step_leaves_the_next_as_the_first(device: str) -> None:
    dropped, fresh = make_parameters(device), make_parameters(device)
    take_step(dropped, 1, -1.0, device)
    for parameters in (dropped, fresh):
        take_step(parameters, 2, 1.0, device)
    expected = tensors(fresh)
    assert all(torch.equal(value, expected[name]) for name, value in tensors(dropped).items())
