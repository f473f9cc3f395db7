"""The gradient paints of a population: their parameters and their optimizer state."""

from __future__ import annotations

from collections.abc import Callable

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.adan import Adan, check_adan_state
from warpvec.fit.state import State
from warpvec.fit.state_form import Part, check_fields
from warpvec.geometry.gradients import FLAT, Gradients


class GradientParameters:
    """The gradients of N paths as free parameters, stepped by Adan. Geometry is in units of half the longer side.

    Attributes:
        live: the present gradients, in memory that each step overwrites.
    """

    def __init__(self, gradients: Gradients, config: FitConfig, half_side: float) -> None:
        self._half_side, self._rates = half_side, (config.lr_color, config.lr_points)
        self._set(gradients.map(torch.Tensor.clone), None)

    def step(self, adj_end_color: Tensor, adj_geometry: Tensor, factor: float, fits: Tensor | None) -> None:
        """Take an optimizer step with learning rates multiplied by ``factor``; if ``fits`` is -1, move nothing."""
        before = None if fits is None else [param.clone() for param in self._params]
        self._params[0].grad, self._params[1].grad = adj_end_color.contiguous(), adj_geometry * self._half_side
        for group, rate in zip(self._optimizer.param_groups, self._rates, strict=True):
            group["lr"] = rate * factor
        self._optimizer.step()
        self._params[0].clamp_(0.0, 1.0)
        if fits is not None and before is not None:
            for param, old in zip(self._params, before, strict=True):
                torch.where(fits > 0.0, param, old, out=param)
        self._show()

    def keep(self, rows: Tensor) -> None:
        """Keep the paths ``rows``: a mask, or indices in the new order."""
        self._set(self.live.map(lambda value: value[rows]), self._map_state(lambda value: value[rows]))

    def append(self, gradients: Gradients) -> None:
        """Add the gradients of new paths, with fresh optimizer state."""

        def extended(value: Tensor) -> Tensor:
            return torch.cat([value, value.new_zeros(len(gradients), *value.shape[1:])])

        self._set(self.live.joined(gradients), self._map_state(extended))

    def replace_rows(self, rows: Tensor, gradients: Gradients) -> None:
        """Take the entries ``rows`` (indices) from ``gradients``, those of all paths, with fresh optimizer state."""

        def cleared(value: Tensor) -> Tensor:
            value = value.clone()
            value[rows] = 0
            return value

        self._set(gradients.map(torch.Tensor.clone), self._map_state(cleared))

    def state(self) -> State:
        """Return everything that :meth:`restore` needs to continue to the same bits."""
        end_color, geometry = (dict(self._optimizer.state[param]) for param in self._params)
        return {"end_color": end_color, "geometry": geometry}

    def check(self, state: State, iteration: int) -> None:
        """Refuse ``state`` unless :meth:`state` can have returned it for the present paths after ``iteration``.

        Raises:
            InputError: it cannot.
        """
        count = len(self.live)
        forms = {"end_color": 3, "geometry": 4}
        check_fields("population.gradients", state, **{name: Part() for name in forms})
        for name, width in forms.items():
            part, label = state[name], f"population.gradients.{name}"
            if not part:
                continue  # they have not been stepped since they were made
            check_adan_state(label, part, (count, width), iteration)

    def restore(self, state: State, device: str) -> None:
        """Continue from ``state``, which :meth:`check` has accepted, with the present paints."""
        parts = (state[name] for name in ("end_color", "geometry"))
        states = [{name: value.to(device, copy=True) for name, value in part.items()} for part in parts]
        self._set(self.live, states)

    def _set(self, gradients: Gradients, states: list[dict[str, Tensor]] | None) -> None:
        self.live = gradients.map(torch.Tensor.contiguous)
        self._params = [gradients.end_color.clone(), gradients.geometry / self._half_side]
        groups = [{"params": [param], "lr": rate} for param, rate in zip(self._params, self._rates, strict=True)]
        self._optimizer = Adan(groups)
        for param, state in zip(self._params, states or [{}, {}], strict=True):
            self._optimizer.state[param].update(state)

    def _map_state(self, change: Callable[[Tensor], Tensor]) -> list[dict[str, Tensor]]:
        states = (self._optimizer.state[param] for param in self._params)
        return [{name: change(value) for name, value in state.items()} for state in states]

    def _show(self) -> None:
        is_painted = (self.live.kind != FLAT)[:, None]
        self.live.end_color.copy_(self._params[0])
        self.live.geometry.copy_(torch.where(is_painted, self._params[1] * self._half_side, self.live.geometry))
