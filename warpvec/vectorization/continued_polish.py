"""Polish a drawing in several parts, which share one number of iterations, one time budget and one history."""

from __future__ import annotations

from dataclasses import dataclass, replace

from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.polish import polish
from warpvec.fit.progress import FitResult, OnProgress, Progress


@dataclass(frozen=True, eq=False)
class ContinuedPolish:
    """The settings of the parts, and how many iterations they may take together."""

    image: Tensor
    config: FitConfig
    on_progress: OnProgress | None
    iterations: int
    free: bool
    locked: Tensor | None

    def continued(self, done: FitResult, iterations: int) -> FitResult:
        """Return ``done`` after at most so many more ``iterations``, if any are left."""
        left, budget = min(iterations, self.iterations - done.iterations), self.config.time_budget
        if left <= 0 or done.interrupted or (budget is not None and done.seconds >= budget):
            return done
        config = self.config if budget is None else replace(self.config, time_budget=budget - done.seconds)

        def report(progress: Progress) -> None:
            if self.on_progress is not None:
                later = replace(progress, iteration=done.iterations + progress.iteration)
                self.on_progress(replace(later, iteration_count=self.iterations, seconds=done.seconds + later.seconds))

        found = polish(self.image, done.scene, config, report, iterations=left, free=self.free, locked=self.locked)
        history = [
            {**entry, "iteration": done.iterations + entry["iteration"], "seconds": done.seconds + entry["seconds"]}
            for entry in found.history
        ]
        count, seconds = done.iterations + found.iterations, done.seconds + found.seconds
        return replace(found, history=[*done.history, *history], iterations=count, seconds=seconds)
