"""Black and white art as a drawing: one black path, with its time and its place among the modes."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field

from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.progress import FitResult, OnProgress
from warpvec.flat.curves.curve_fitting import TOLERANCE
from warpvec.flat.mono import MIN_AREA, mono_tracing
from warpvec.flat.simplification.simplify import DETAIL


@dataclass
class MonoDrawing:
    """The work on one black and white picture.

    Attributes:
        image: the picture [h, w, 3 or 4], sRGB-encoded in [0, 1], with straight alpha if it has four channels.
        config: settings of the run.
        on_progress: not called, because there is no fit.
        is_interrupted: says whether Ctrl-C asks for the best result so far.
        left_out: how many specks the last drawing left out.
    """

    image: Tensor
    config: FitConfig
    on_progress: OnProgress | None = None
    is_interrupted: Callable[[], bool] = bool
    left_out: dict[str, int] = field(default_factory=dict)
    _begin: float = field(default_factory=time.perf_counter)

    def draw(self, detail: float) -> FitResult:
        """Return the outlines of what is dark, with the nodes that show at ``detail`` pixels.

        With the default detail the tolerance follows the noise of the picture; else it is proportional to the detail.
        """
        threshold = self.config.threshold
        tracing = mono_tracing(
            self.image.numpy(),
            "auto" if threshold == "auto" else float(threshold),
            tolerance=None if detail == DETAIL else TOLERANCE * detail / DETAIL,
            min_area=max(MIN_AREA, self.config.min_area),
            is_over=self.is_over,
        )
        self.left_out = {"speck": tracing.speck_count}
        return FitResult(tracing.scene, [], 0, self.seconds(), self.is_interrupted(), "cpu")

    def is_over(self) -> bool:
        """Return whether Ctrl-C or the time budget asks for the best result so far."""
        budget = self.config.time_budget
        return self.is_interrupted() or (budget is not None and self.seconds() >= budget)

    def seconds(self) -> float:
        """Return the seconds since the work began."""
        return time.perf_counter() - self._begin
