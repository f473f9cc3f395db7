"""Adan for torch parameters whose rows have an age each; the update is a kernel.

The fit's paths are stepped by ``warpvec/fit/population.py`` with the same update; this class steps palettes
and gradients.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from inspect import unwrap
from typing import Any, overload

import torch
import warp as wp
from torch import Tensor
from torch.optim.optimizer import ParamsT

from warpvec.errors import InputError
from warpvec.fit.state_form import check_fields, floats, require, wholes
from warpvec.kernels.adan import BETAS, EPS, make_kernels
from warpvec.kernels.lanes import Lanes, make_lanes
from warpvec.rendering.launch import Launcher, as_warp, start_warp

# Torch wraps the method to keep torch.compile out, and imports the compiler for that: half a second of every run.
_add_param_group = unwrap(torch.optim.Optimizer.add_param_group)

_AVERAGES = ("exp_avg", "exp_avg_diff", "exp_avg_sq", "previous_grad")

_RATIO_MAX, _GRADIENT_TINY = 20.0, 1e-15
"""Averages and the previous gradient are at most the first number times the root of ``exp_avg_sq``, or the second if
their squares vanish in float32. By Cauchy and Schwarz the largest ratio is 10, that of the first gradient to the root
of a hundredth of its square. Without this bound a step would not be limited by the learning rate."""


class Adan(torch.optim.Optimizer):
    """Adaptive Nesterov momentum (Xie et al. 2024, Algorithm 1) with bias correction and without weight decay.

    A row is an index of a parameter's first dimension, such as a path. Each row has its own age, the number of steps it
    has taken. A row with a state of zero moves as in a fresh optimizer. If a row's gradient holds a NaN or
    an infinity, the row takes that step with a gradient of zero.

    State of a parameter: ``exp_avg``, ``exp_avg_diff``, ``exp_avg_sq`` and ``previous_grad`` in its shape, and the ages
    ``step`` [rows] (int64).

    Args:
        params: tensors or groups of them; ``lr``, ``betas`` and ``eps`` may differ between groups.
        lr: learning rate, in the units of the parameter.
        betas: (b1, b2, b3), the share of the old average that is kept (1 - beta in the notation of Algorithm 1).
        eps: added to the root of the second moment.

    Raises:
        InputError: a negative ``lr`` or ``eps``, a beta outside (0, 1), or a parameter that is not contiguous.
    """

    def __init__(
        self,
        params: ParamsT,
        lr: float = 1e-3,
        betas: tuple[float, float, float] = BETAS,
        eps: float = EPS,
    ) -> None:
        self._rows: dict[Tensor, _Rows] = {}
        super().__init__(params, {"lr": lr, "betas": betas, "eps": eps})

    def add_param_group(self, param_group: dict[str, Any]) -> None:
        """Add a group with its own ``lr``, ``betas`` and ``eps``; raise InputError as the class does."""
        for name in ("lr", "eps"):
            value = param_group.get(name, self.defaults[name])
            if not value >= 0.0:
                raise InputError(name, "must be at least 0", repr(value), "give 0 or more")
        betas = param_group.get("betas", self.defaults["betas"])
        if len(betas) != 3 or not all(0.0 < beta < 1.0 for beta in betas):
            rule = "must be three numbers between 0 and 1, both excluded"
            raise InputError("betas", rule, repr(betas), f"give for example {BETAS}")
        _add_param_group(self, param_group)
        for param in self.param_groups[-1]["params"]:
            if not param.is_contiguous():
                raise InputError(
                    "params", "must be contiguous", f"strides {param.stride()}", "call contiguous() on them"
                )

    def __setstate__(self, state: dict[str, Any]) -> None:
        super().__setstate__(state)
        self._rows = {}

    @overload
    def step(self, closure: None = None) -> None: ...

    @overload
    def step(self, closure: Callable[[], float]) -> float: ...

    @torch.no_grad()
    def step(self, closure: Callable[[], float] | None = None) -> float | None:
        """Update every parameter that has a gradient once; return the value of ``closure`` if there is one."""
        loss = None
        if closure is not None:
            with torch.enable_grad():
                loss = closure()
        for group in self.param_groups:
            for param in group["params"]:
                if param.grad is not None:
                    self._update(param, param.grad, group["lr"], group["betas"], group["eps"])
        return loss

    def _update(self, param: Tensor, grad: Tensor, lr: float, betas: tuple[float, float, float], eps: float) -> None:
        state = self._state(param)
        rows = self._rows.get(param)
        if rows is None or not rows.is_of(param, state):
            rows = self._rows[param] = _Rows(param, state)
        rows.update(grad.to(param.dtype), lr, betas, eps)

    def _state(self, param: Tensor) -> dict[str, Tensor]:
        state: dict[str, Tensor] = self.state[param]
        if not state:
            zeros = {name: torch.zeros_like(param, memory_format=torch.contiguous_format) for name in _AVERAGES}
            state.update(zeros)
            state["step"] = torch.zeros(param.shape[:1], dtype=torch.int64, device=param.device)
        return state


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


class _Rows:
    """A parameter and its state as Warp arrays, kept because making them at each step would cost more than the step."""

    def __init__(self, param: Tensor, state: dict[str, Tensor]) -> None:
        self._launch, self._lanes = _launcher(param.device, param.dtype)
        self._width = math.prod(param.shape[1:])
        self._row_count = math.prod(param.shape[:1])
        self._pointers = _pointers(param, state)
        averages = [self._array(state[name]) for name in _AVERAGES]
        self._arrays = [as_warp(state["step"].reshape(-1), wp.int64), *averages, self._array(param)]

    def is_of(self, param: Tensor, state: dict[str, Tensor]) -> bool:
        """Return whether the parameter and its state still use the memory of these arrays."""
        return self._pointers == _pointers(param, state)

    def update(self, grad: Tensor, lr: float, betas: tuple[float, float, float], eps: float) -> None:
        """Take one step, by the kernel in ``kernels/adan.py``."""
        lanes = self._lanes
        log_betas = lanes.vec3(*(math.log(beta) for beta in betas))
        settings = [lanes.dtype(lr), lanes.vec3(*betas), log_betas, lanes.dtype(eps)]
        kernel = make_kernels(lanes).update_rows
        self._launch(kernel, self._row_count, [self._array(grad), *settings, *self._arrays])

    def _array(self, values: Tensor) -> Any:
        return as_warp(values.reshape(-1, self._width), self._lanes.dtype)


def _pointers(param: Tensor, state: dict[str, Tensor]) -> list[int]:
    return [param.data_ptr(), *(value.data_ptr() for value in state.values())]


@cache
def _launcher(device: torch.device, dtype: torch.dtype) -> tuple[Launcher, Lanes]:
    start_warp()
    return Launcher(str(device), threads=1), make_lanes(1, wp.dtype_from_torch(dtype))
