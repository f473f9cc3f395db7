"""The gradient paints of a population: their parameters and their optimizer state."""

from __future__ import annotations

from collections.abc import Callable

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.adan import Adan, check_adan_state
from warpvec.fit.state import State
from warpvec.fit.state_form import Fields, FieldSet, check_fields, floats, require
from warpvec.geometry.gradients import Gradients
from warpvec.geometry.paints.registry import FLAT

_NAMES = ("end_color", "geometry")


class GradientParameters:
    """The gradients of N paths as free parameters, stepped by Adan.

    The parameters of the geometry are in units of half the longer side.

    Attributes:
        live: the present gradients, in pixels, in memory that each step overwrites.
    """

    def __init__(self, gradients: Gradients, config: FitConfig, half_side: float) -> None:
        self._half_side, self._rates = half_side, (config.lr_color, config.lr_points)
        self._set(gradients.map(torch.Tensor.clone), self._raw(gradients), None)

    def step(self, adj_end_color: Tensor, adj_geometry: Tensor, factor: float, fits: Tensor | None) -> None:
        """Take an optimizer step with learning rates multiplied by ``factor``.

        If ``fits`` [1], on the device, is -1 and not 1, the step changes nothing.
        """
        before = None if fits is None else self._copies()
        self._params[0].grad, self._params[1].grad = adj_end_color.contiguous(), adj_geometry * self._half_side
        for group, rate in zip(self._optimizer.param_groups, self._rates, strict=True):
            group["lr"] = rate * factor
        self._optimizer.step()
        self._params[0].clamp_(0.0, 1.0)
        if fits is not None and before is not None:
            self._put_back(before, fits > 0.0)
        self._show()

    def keep(self, rows: Tensor) -> None:
        """Keep the paths ``rows``: a mask, or indices in the new order."""
        params = [param[rows] for param in self._params]
        self._set(self.live.map(lambda value: value[rows]), params, self._map_state(lambda value: value[rows]))

    def append(self, gradients: Gradients) -> None:
        """Add the gradients of new paths, with fresh optimizer state."""

        def extended(value: Tensor) -> Tensor:
            return torch.cat([value, value.new_zeros(len(gradients), *value.shape[1:])])

        params = [torch.cat(pair) for pair in zip(self._params, self._raw(gradients), strict=True)]
        self._set(self.live.joined(gradients), params, self._map_state(extended))

    def replace_rows(self, rows: Tensor, gradients: Gradients) -> None:
        """Take the entries ``rows`` (indices) from ``gradients``, those of all paths, with fresh optimizer state."""

        def cleared(value: Tensor) -> Tensor:
            value = value.clone()
            value[rows] = 0
            return value

        params = [param.clone() for param in self._params]
        for param, values in zip(params, self._raw(gradients), strict=True):
            param[rows] = values[rows]
        self._set(gradients.map(torch.Tensor.clone), params, self._map_state(cleared))

    def state(self) -> State:
        """Return everything that :meth:`restore` needs to continue to the same bits, beside the present paints."""
        parts = zip(_NAMES, self._params, strict=True)
        return {name: {"value": param, "steps": dict(self._optimizer.state[param])} for name, param in parts}

    def check(self, state: State, iteration: int, rounding: float) -> None:
        """Refuse ``state`` unless :meth:`state` can have returned it for the present paints after ``iteration``.

        Colours of the paints may be ``rounding`` from their parameters.

        Raises:
            InputError: it cannot.
        """
        check_fields("population.gradients", state, **{name: FieldSet() for name in _NAMES})
        for name, shown, error in zip(_NAMES, self._raw(self.live), (rounding, 1e-4), strict=True):
            label, part = f"population.gradients.{name}", state[name]
            Fields({"value": floats(*shown.shape), "steps": FieldSet()}).check(label, part)
            is_same = torch.allclose(part["value"], shown.cpu(), rtol=1e-4, atol=error)
            require(is_same, label, "does not go with the paints of the paths")
            if part["steps"]:  # there are none before the first step
                check_adan_state(f"{label}.steps", part["steps"], tuple(shown.shape), iteration)

    def restore(self, state: State, device: str) -> None:
        """Continue from ``state``, which :meth:`check` has accepted, with the present paints."""
        params = [state[name]["value"].to(device, copy=True) for name in _NAMES]
        parts = [state[name]["steps"] for name in _NAMES]
        states = [{name: value.to(device, copy=True) for name, value in part.items()} for part in parts]
        self._set(self.live, params, states)

    def _raw(self, gradients: Gradients) -> list[Tensor]:
        """Return the parameters that stand for ``gradients``."""
        return [gradients.end_color.clone(), gradients.geometry / self._half_side]

    def _set(self, live: Gradients, params: list[Tensor], states: list[dict[str, Tensor]] | None) -> None:
        self.live, self._params = live.map(torch.Tensor.contiguous), params
        groups = [{"params": [param], "lr": rate} for param, rate in zip(params, self._rates, strict=True)]
        self._optimizer = Adan(groups)
        for param, state in zip(params, states or [{}, {}], strict=True):
            self._optimizer.state[param].update(state)

    def _map_state(self, change: Callable[[Tensor], Tensor]) -> list[dict[str, Tensor]]:
        states = (self._optimizer.state[param] for param in self._params)
        return [{name: change(value) for name, value in state.items()} for state in states]

    def _copies(self) -> list[tuple[Tensor, dict[str, Tensor]]]:
        """Return copies of each parameter and of its optimizer state."""
        states = self._map_state(torch.Tensor.clone)
        return [(param.clone(), state) for param, state in zip(self._params, states, strict=True)]

    def _put_back(self, before: list[tuple[Tensor, dict[str, Tensor]]], is_kept: Tensor) -> None:
        """Undo a step unless it ``is_kept`` [1], in the same memory and without a look at the device."""
        for param, (old_param, old_state) in zip(self._params, before, strict=True):
            torch.where(is_kept, param, old_param, out=param)
            for name, value in self._optimizer.state[param].items():
                old = old_state.get(name, torch.zeros_like(value))  # the first step makes the state, from zeros
                torch.where(is_kept, value, old, out=value)

    def _show(self) -> None:
        is_painted = (self.live.kind != FLAT)[:, None]
        self.live.end_color.copy_(self._params[0])
        self.live.geometry.copy_(torch.where(is_painted, self._params[1] * self._half_side, self.live.geometry))
