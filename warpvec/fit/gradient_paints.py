"""The gradient paints of a population: their parameters and their optimizer state."""

from __future__ import annotations

from collections.abc import Callable

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.adan import Adan, check_adan_state
from warpvec.fit.state import State
from warpvec.fit.state_form import check_fields, field_set, fields, floats, require
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
        self._set(gradients.map(torch.Tensor.clone), [Adan(raw) for raw in self._raw(gradients)])

    def step(self, adj_end_color: Tensor, adj_geometry: Tensor, factor: float, fits: Tensor | None) -> None:
        """Take an optimizer step with learning rates multiplied by ``factor``.

        If ``fits`` [1], on the device, is -1 and not 1, the step changes nothing.
        """
        before = None if fits is None else self._changed(torch.Tensor.clone)
        adjoints = (adj_end_color.contiguous(), adj_geometry * self._half_side)
        for optimizer, adjoint, rate in zip(self._optimizers, adjoints, self._rates, strict=True):
            optimizer.step(adjoint, rate * factor)
        self._optimizers[0].param.clamp_(0.0, 1.0)
        if fits is not None and before is not None:
            self._put_back(before, fits > 0.0)
        self._show()

    def keep(self, rows: Tensor) -> None:
        """Keep the paths ``rows``: a mask, or indices in the new order."""
        self._set(self.live.map(lambda value: value[rows]), self._changed(lambda value: value[rows]))

    def append(self, gradients: Gradients) -> None:
        """Add the gradients of new paths, with fresh optimizer state."""

        def extended(value: Tensor) -> Tensor:
            return torch.cat([value, value.new_zeros(len(gradients), *value.shape[1:])])

        optimizers = self._changed(extended)
        for optimizer, raw in zip(optimizers, self._raw(gradients), strict=True):
            optimizer.param[len(self.live) :] = raw
        self._set(self.live.joined(gradients), optimizers)

    def replace_rows(self, rows: Tensor, gradients: Gradients) -> None:
        """Take the entries ``rows`` (indices) from ``gradients``, those of all paths, with fresh optimizer state."""
        optimizers = self._changed(lambda value: value.index_fill(0, rows, 0))
        for optimizer, own, raw in zip(optimizers, self._optimizers, self._raw(gradients), strict=True):
            optimizer.param.copy_(own.param)[rows] = raw[rows]
        self._set(gradients.map(torch.Tensor.clone), optimizers)

    def state(self) -> State:
        """Return everything that :meth:`restore` needs to continue to the same bits, beside the present paints."""
        parts = zip(_NAMES, self._optimizers, strict=True)
        return {name: {"value": part.param, "steps": dict(part.state)} for name, part in parts}

    def check(self, state: State, iteration: int, rounding: float) -> None:
        """Refuse ``state`` unless :meth:`state` can have returned it for the present paints after ``iteration``.

        Colours of the paints may be ``rounding`` from their parameters.

        Raises:
            InputError: it cannot.
        """
        check_fields("population.gradients", state, **dict.fromkeys(_NAMES, field_set))
        for name, shown, error in zip(_NAMES, self._raw(self.live), (rounding, 1e-4), strict=True):
            label, part = f"population.gradients.{name}", state[name]
            fields(value=floats(*shown.shape), steps=field_set)(label, part)
            is_same = torch.allclose(part["value"], shown.cpu(), rtol=1e-4, atol=error)
            require(is_same, label, "does not go with the paints of the paths")
            if part["steps"]:  # there are none before the first step
                check_adan_state(f"{label}.steps", part["steps"], tuple(shown.shape), iteration)

    def restore(self, state: State, device: str) -> None:
        """Continue from ``state``, which :meth:`check` has accepted, with the present paints."""
        parts = (state[name] for name in _NAMES)
        optimizers = [Adan(part["value"], part["steps"]) for part in parts]
        self._set(self.live, [_mapped(each, lambda value: value.to(device, copy=True)) for each in optimizers])

    def _raw(self, gradients: Gradients) -> list[Tensor]:
        """Return the parameters that stand for ``gradients``."""
        return [gradients.end_color.clone(), gradients.geometry / self._half_side]

    def _set(self, live: Gradients, optimizers: list[Adan]) -> None:
        self.live, self._optimizers = live.map(torch.Tensor.contiguous), optimizers

    def _changed(self, change: Callable[[Tensor], Tensor]) -> list[Adan]:
        """Return what ``change`` makes of the parameters and their states."""
        return [_mapped(each, change) for each in self._optimizers]

    def _put_back(self, before: list[Adan], is_kept: Tensor) -> None:
        """Undo a step unless it ``is_kept`` [1], in the same memory and without a look at the device."""
        for now, old in zip(self._optimizers, before, strict=True):
            torch.where(is_kept, now.param, old.param, out=now.param)
            for name, value in now.state.items():
                # The first step makes the state, from zeros.
                torch.where(is_kept, value, old.state.get(name, torch.zeros_like(value)), out=value)

    def _show(self) -> None:
        is_painted = (self.live.kind != FLAT)[:, None]
        end_color, geometry = (each.param for each in self._optimizers)
        self.live.end_color.copy_(end_color)
        self.live.geometry.copy_(torch.where(is_painted, geometry * self._half_side, self.live.geometry))


def _mapped(optimizer: Adan, change: Callable[[Tensor], Tensor]) -> Adan:
    return Adan(change(optimizer.param), {name: change(value) for name, value in optimizer.state.items()})
