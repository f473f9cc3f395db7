"""Adan with an age for every row, so that paths can come and go during a fit."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from typing import Any, overload

import torch
from torch import Tensor
from torch.optim.optimizer import ParamsT

from warpvec.errors import InputError


class Adan(torch.optim.Optimizer):
    """Adaptive Nesterov momentum (Xie et al. 2024, Algorithm 1) with bias correction and without weight decay.

    A row is an index of a parameter's first dimension: a path. Each row has its own step count, so a row appended at
    step 50 moves as it would in a fresh optimizer. A row whose gradient holds a NaN or an infinity takes that step with
    a gradient of zero.

    State of a parameter: ``exp_avg``, ``exp_avg_diff``, ``exp_avg_sq`` and ``previous_grad`` in its shape, ``step``
    [rows] (int64).

    Args:
        params: tensors or groups of them; ``lr``, ``betas`` and ``eps`` may differ by group.
        lr: learning rate, in the units of the parameter.
        betas: (b1, b2, b3), the share of the old average that is kept (1 - beta in the notation of Algorithm 1).
        eps: added to the root of the second moment.

    Raises:
        InputError: a negative ``lr`` or ``eps``, or a beta outside (0, 1).
    """

    def __init__(
        self,
        params: ParamsT,
        lr: float = 1e-3,
        betas: tuple[float, float, float] = (0.98, 0.92, 0.99),
        eps: float = 1e-8,
    ) -> None:
        super().__init__(params, {"lr": lr, "betas": betas, "eps": eps})

    def add_param_group(self, param_group: dict[str, Any]) -> None:
        """Adds a group with its own ``lr``, ``betas`` and ``eps``; raises InputError as the class does."""
        for name in ("lr", "eps"):
            value = param_group.get(name, self.defaults[name])
            if not value >= 0.0:
                raise InputError(f"{name} must be at least 0, got {value!r}")
        betas = param_group.get("betas", self.defaults["betas"])
        if len(betas) != 3 or not all(0.0 < beta < 1.0 for beta in betas):
            raise InputError(f"betas must be three numbers between 0 and 1, both excluded, got {betas!r}")
        super().add_param_group(param_group)

    @overload
    def step(self, closure: None = None) -> None: ...

    @overload
    def step(self, closure: Callable[[], float]) -> float: ...

    @torch.no_grad()
    def step(self, closure: Callable[[], float] | None = None) -> float | None:
        """One update of every parameter that has a gradient; returns what ``closure`` returned, if one was given."""
        loss = None
        if closure is not None:
            with torch.enable_grad():
                loss = closure()
        for group in self.param_groups:
            for param in group["params"]:
                if param.grad is not None:
                    _update(param, param.grad, self._state(param), group["lr"], group["betas"], group["eps"])
        return loss

    @torch.no_grad()
    def keep_rows(self, param: Tensor, rows: Tensor) -> Tensor:
        """Replaces ``param`` by its ``rows`` (indices in the new order, or a mask), each with its state and age.

        Returns:
            The parameter that now stands in the group, without a gradient.

        Raises:
            InputError: ``param`` is not in this optimizer.
        """
        return self._replace(param, param[rows], {name: value[rows] for name, value in self.state[param].items()})

    @torch.no_grad()
    def append_rows(self, param: Tensor, new_rows: Tensor) -> Tensor:
        """Replaces ``param`` by itself with ``new_rows`` [K, ...] below, whose state and age are zero.

        Returns:
            The parameter that now stands in the group, without a gradient.

        Raises:
            InputError: ``param`` is not in this optimizer.
        """
        count = len(new_rows)
        state = {
            name: torch.cat([value, value.new_zeros(count, *value.shape[1:])])
            for name, value in self.state[param].items()
        }
        return self._replace(param, torch.cat([param, new_rows.to(param)]), state)

    def _replace(self, param: Tensor, value: Tensor, state: dict[str, Tensor]) -> Tensor:
        del self.state[param]
        for group in self.param_groups:
            for position, member in enumerate(group["params"]):
                if member is param:
                    group["params"][position] = value.requires_grad_(param.requires_grad)
                    self.state[value] = state
                    return value
        raise InputError(f"param must be a parameter of this optimizer, got a tensor of shape {list(param.shape)}")

    def _state(self, param: Tensor) -> dict[str, Tensor]:
        state: dict[str, Tensor] = self.state[param]
        if not state:
            names = ("exp_avg", "exp_avg_diff", "exp_avg_sq", "previous_grad")
            state.update({name: torch.zeros_like(param, memory_format=torch.contiguous_format) for name in names})
            state["step"] = torch.zeros(param.shape[:1], dtype=torch.int64, device=param.device)
        return state


def _update(
    param: Tensor,
    raw_grad: Tensor,
    state: dict[str, Tensor],
    lr: float,
    betas: tuple[float, float, float],
    eps: float,
) -> None:
    """One step of one parameter. Numbers at the right are lines of Algorithm 1."""
    b1, b2, b3 = betas
    m, v, n, previous = (state[name] for name in ("exp_avg", "exp_avg_diff", "exp_avg_sq", "previous_grad"))
    age = state["step"].add_(1).view((*param.shape[:1], *[1] * (param.ndim - 1))).to(param.dtype)
    grad = _usable_rows(raw_grad)
    # The previous gradient lends its memory: page faults of fresh temporaries cost more than the arithmetic.
    scratch = previous
    difference = torch.sub(grad, previous, out=scratch).mul_((age > 1).to(param.dtype))  # 0 at first, as g_0 = g_1
    m.lerp_(grad, 1 - b1)  # 3
    v.lerp_(difference, 1 - b2)  # 4
    look_ahead = torch.add(grad, difference, alpha=b2, out=scratch)
    n.mul_(b3).addcmul_(look_ahead, look_ahead, value=1 - b3)  # 5
    factor_m, factor_v, floor = _row_factors(age, betas, eps)
    numerator = torch.mul(m, factor_m, out=scratch).addcmul_(v, factor_v, value=b2)
    param.addcdiv_(numerator, n.sqrt().add_(floor), value=lr)  # 6, 7
    previous.copy_(grad)


def _row_factors(age: Tensor, betas: tuple[float, float, float], eps: float) -> list[Tensor]:
    """Factors [f_m, f_v, f_eps] per row such that a step adds lr (f_m m + b2 f_v v) / (sqrt(n) + f_eps).

    They carry the sign and the bias corrections c = 1 - b^age of -lr (m / c1 + b2 v / c2) / (sqrt(n / c3) + eps),
    multiplied through by sqrt(c3) so that the corrections cost nothing per element.
    """
    minus_c1, minus_c2, minus_c3 = _log(tuple(betas), age.dtype, age.device).view(3, *[1] * age.ndim).mul(age).expm1_()
    root_c3 = minus_c3.neg_().sqrt_()
    return [root_c3 / minus_c1, root_c3 / minus_c2, root_c3 * eps]


@cache
def _log(betas: tuple[float, float, float], dtype: torch.dtype, device: torch.device) -> Tensor:
    # Cached because building a tensor on every step costs a transfer to the device.
    return torch.tensor([math.log(beta) for beta in betas], dtype=dtype, device=device)


def _usable_rows(grad: Tensor) -> Tensor:
    """A copy of the gradient with zeros in each row that holds a NaN, an infinity or a value too large to square."""
    # |g + b2 (g - g')| is at most 3 max(|g|, |g'|), and line 5 squares it.
    limit = math.sqrt(torch.finfo(grad.dtype).max) / 4
    rows = grad.reshape(math.prod(grad.shape[:1]), math.prod(grad.shape[1:]))
    usable = torch.linalg.vector_norm(rows, dim=1, keepdim=True) < limit
    return rows.nan_to_num(0.0, 0.0, 0.0).mul_(usable.to(grad.dtype)).view(grad.shape)
