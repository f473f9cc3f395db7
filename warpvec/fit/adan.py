"""Adan for a torch tensor whose rows have an age each; the update is a kernel.

The fit's paths are stepped by ``warpvec/fit/population.py`` with the same update; this class steps palettes
and gradients.
"""

from __future__ import annotations

import math
from typing import Any

import torch
import warp as wp
from torch import Tensor

from warpvec.fit.state_form import check_fields, floats, require, wholes
from warpvec.kernels.adan import BETAS, EPS, make_kernels
from warpvec.kernels.lanes import Lanes, make_lanes
from warpvec.rendering.launch import Launcher, as_warp, once_per_thread, start_warp

_AVERAGES = ("exp_avg", "exp_avg_diff", "exp_avg_sq", "previous_grad")

_RATIO_MAX, _GRADIENT_TINY = 20.0, 1e-15
"""Averages and the previous gradient are at most the first number times the root of ``exp_avg_sq``, or the second if
their squares vanish in float32. By Cauchy and Schwarz the largest ratio is 10, that of the first gradient to the root
of a hundredth of its square. Without this bound a step would not be limited by the learning rate."""


class Adan:
    """Adaptive Nesterov momentum (Xie et al. 2024, Algorithm 1) with bias correction and without weight decay.

    A row is an index of a parameter's first dimension, such as a path. Each row has its own age, the number of steps it
    has taken. A row with a state of zero moves as in a fresh optimizer. If a row's gradient holds a NaN or
    an infinity, the row takes that step with a gradient of zero.

    Attributes:
        param: the contiguous tensor that is stepped in its memory.
        state: ``exp_avg``, ``exp_avg_diff``, ``exp_avg_sq`` and ``previous_grad`` in its shape, and the ages ``step``
            [rows] (int64), which steps overwrite too; empty before the first step.
    """

    def __init__(self, param: Tensor, state: dict[str, Tensor] | None = None) -> None:
        assert param.is_contiguous()  # a Warp array of another one would be a copy
        self.param, self.state = param, dict(state or {})
        # Kept, because making Warp arrays at each step would cost more than the step.
        self._arrays: list[Any] = []

    def step(self, grad: Tensor, lr: float) -> None:
        """Take one step with the learning rate ``lr``, in the units of the parameter, by ``kernels/adan.py``."""
        launch, lanes = _launcher(self.param.device, self.param.dtype)
        if not self._arrays:
            self._arrays = self._make_arrays(lanes)
        log_betas = lanes.vec3(*(math.log(beta) for beta in BETAS))
        settings = [lanes.dtype(lr), lanes.vec3(*BETAS), log_betas, lanes.dtype(EPS)]
        arguments = [self._as_rows(grad.to(self.param.dtype), lanes), *settings, *self._arrays]
        launch(make_kernels(lanes).update_rows, math.prod(self.param.shape[:1]), arguments)

    def _make_arrays(self, lanes: Lanes) -> list[Any]:
        """Return the parameter and its state, which is made if there is none, as Warp arrays."""
        if not self.state:
            self.state = {name: torch.zeros_like(self.param) for name in _AVERAGES}
            self.state["step"] = torch.zeros(self.param.shape[:1], dtype=torch.int64, device=self.param.device)
        averages = [self._as_rows(self.state[name], lanes) for name in _AVERAGES]
        return [as_warp(self.state["step"].reshape(-1), wp.int64), *averages, self._as_rows(self.param, lanes)]

    def _as_rows(self, values: Tensor, lanes: Lanes) -> Any:
        return as_warp(values.reshape(-1, math.prod(self.param.shape[1:])), lanes.dtype)


def check_adan_state(name: str, state: Any, shape: tuple[int, ...], step_max: int) -> None:
    """Refuse the state of a float32 parameter of ``shape`` unless `Adan` can have made it in ``step_max`` steps.

    Raises:
        InputError: it cannot.
    """
    averages = {average: floats(*shape) for average in _AVERAGES}
    check_fields(name, state, **averages, step=wholes(shape[0], high=step_max))
    check_averages(name, *(state[average] for average in _AVERAGES))


def check_averages(name: str, exp_avg: Tensor, exp_avg_diff: Tensor, exp_avg_sq: Tensor, previous_grad: Tensor) -> None:
    """Raise InputError unless these finite values are some that the betas `BETAS` can lead to."""
    limit = _RATIO_MAX * exp_avg_sq.sqrt() + _GRADIENT_TINY  # NaN below zero
    for values in (exp_avg, exp_avg_diff, previous_grad):
        require((values.abs() <= limit).all(), name, "has an optimizer state that no gradients lead to")


@once_per_thread
def _launcher(device: torch.device, dtype: torch.dtype) -> tuple[Launcher, Lanes]:
    start_warp()
    return Launcher(str(device), threads=1), make_lanes(1, wp.dtype_from_torch(dtype))
