"""The record of a fit: when its history gets an entry, and the best scene that a change of population has replaced."""

from __future__ import annotations

import math
import operator
from itertools import pairwise
from typing import Any

from warpvec.fit.state import State
from warpvec.fit.state_form import fields, integer, list_of, number, require
from warpvec.geometry.scene import Scene
from warpvec.image.metrics import psnr_from_mse

LOSS_MAX = 1.01
"""Largest mean squared error of values in [0, 1], with room for rounding."""

SECONDS_MAX = 1e9
"""Longest time of a fit, in seconds: 32 years."""

# Iterations between entries of the history of most fits, and between two checks of a GPU for steps without room. Each
# reads one number back, which drains the queue of a GPU.
_HISTORY_GAP, _HISTORY_GAP_CUDA = 10, 50

HISTORY_MAX = 50_000
"""Most entries of a history, those of half a million iterations on the CPU. Longer fits have longer gaps: a checkpoint
holds the history, and one whose history is too large for its reader would be written in vain."""


class FitRecord:
    """The record of a fit of so many ``iterations`` on ``device``."""

    def __init__(self, iterations: int, device: str) -> None:
        self._device = device
        self._check_gap = _HISTORY_GAP if device == "cpu" else _HISTORY_GAP_CUDA
        self._history_gap = self._check_gap * math.ceil(iterations / (self._check_gap * HISTORY_MAX))
        self._best: tuple[float, Scene] | None = None

    def is_check_due(self, iteration: int) -> bool:
        """Return whether a GPU is asked after ``iteration`` for steps without room."""
        return iteration % self._check_gap == 0

    def is_entry_due(self, iteration: int, iteration_count: int) -> bool:
        """Return whether the history gets an entry for ``iteration``, the last of which is ``iteration_count``."""
        return iteration == iteration_count or iteration % self._history_gap == 0

    def remember(self, loss: float, scene: Scene) -> None:
        """Keep ``scene`` from before a change of population, for an interrupt before the fit recovers."""
        if self._best is None or loss < self._best[0]:
            self._best = (loss, scene)

    def forget(self) -> None:
        """Keep no scene any more."""
        self._best = None

    def better_than(self, loss: float) -> Scene | None:
        """Return the scene that is kept if its loss is below ``loss``."""
        return self._best[1] if self._best is not None and self._best[0] < loss else None

    def state(self) -> State:
        """Return everything that :meth:`restore` needs to continue."""
        best = None if self._best is None else {"loss": self._best[0], "scene": self._best[1].to_dict()}
        return {"best": best}

    def restore(self, state: State) -> None:
        """Continue from ``state``, which has been accepted."""
        best = state["best"]
        self._best = None if best is None else (best["loss"], Scene.from_dict(best["scene"]).to(self._device))


def check_history(history: list[Any], iteration: int, seconds: float, curves: int) -> None:
    """Refuse a history that a fit of at most ``curves`` paths cannot have after ``iteration`` and ``seconds``.

    Raises:
        InputError: it cannot.
    """
    entry = fields(
        iteration=integer(1, iteration),
        curves=integer(0, curves),
        psnr=number(psnr_from_mse(LOSS_MAX), math.inf),
        seconds=number(0.0, seconds),
    )
    list_of(entry)("history", history)
    for name, is_forward in (("iteration", operator.lt), ("seconds", operator.le)):
        values = [record[name] for record in history]
        require(all(is_forward(a, b) for a, b in pairwise(values)), "history", "does not run forward")
