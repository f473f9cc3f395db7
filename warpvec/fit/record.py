"""The record of a fit: its history, and the best scene that a change of population has replaced."""

from __future__ import annotations

import math
from typing import Any

from warpvec.fit.progress import Progress, check_history, history_entry
from warpvec.fit.state import State
from warpvec.geometry.scene import Scene

# Iterations between entries of the history of most fits, and between two checks of a GPU for steps without room. Each
# reads one number back, which drains the queue of a GPU.
_HISTORY_GAP, _HISTORY_GAP_CUDA = 10, 50

HISTORY_MAX = 50_000
"""Most entries of a history, those of half a million iterations on the CPU. Longer fits have longer gaps: a checkpoint
holds the history, and one whose history is too large for its reader would be written in vain."""


class Record:
    """The record of a fit of so many ``iterations`` on ``device``."""

    def __init__(self, iterations: int, device: str) -> None:
        self._device = device
        self._check_gap = _HISTORY_GAP if device == "cpu" else _HISTORY_GAP_CUDA
        self._history_gap = self._check_gap * math.ceil(iterations / (self._check_gap * HISTORY_MAX))
        self._best: tuple[float, Scene] | None = None
        self.history: list[dict[str, Any]] = []

    def is_check_due(self, iteration: int) -> bool:
        """Return whether a GPU is asked after ``iteration`` for steps without room."""
        return iteration % self._check_gap == 0

    def add(self, progress: Progress) -> None:
        """Add an entry to the history if one is due."""
        if progress.iteration == progress.iteration_count or progress.iteration % self._history_gap == 0:
            self.history.append(history_entry(progress))

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
        return {"best": best, "history": self.history}

    def check(self, state: State, curves: int) -> None:
        """Refuse the history of ``state`` unless a fit of at most ``curves`` paths can have it then.

        Raises:
            InputError: it cannot.
        """
        check_history(state["history"], state["iteration"], state["seconds"], curves)

    def restore(self, state: State) -> None:
        """Continue from ``state``, which has been accepted."""
        best = state["best"]
        self._best = None if best is None else (best["loss"], Scene.from_dict(best["scene"]).to(self._device))
        self.history = list(state["history"])
