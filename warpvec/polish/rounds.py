"""The rounds of a polish: several fits that share one number of iterations."""

from __future__ import annotations

from dataclasses import dataclass

from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.target import Target
from warpvec.geometry.scene import Scene
from warpvec.polish.polish import VALUES_EXACT_MAX, polish
from warpvec.watch.watch import Watch


@dataclass(frozen=True, eq=False)
class Rounds:
    """What the fits of a polish have in common.

    Attributes:
        target: the image to compare with, unless a round gives another one.
        config: settings of the run.
        watch: progress, stop, clock and history of the run.
        iterations: most iterations of all rounds together.
        free: as in `warpvec.polish.polish.polish`.
        locked: paths [N] (bool) that keep their form and paint; None for none.
        exact: take damped Gauss-Newton steps if the drawing is small enough; otherwise steps by gradients.
    """

    target: Target
    config: FitConfig
    watch: Watch
    iterations: int
    free: bool = False
    locked: Tensor | None = None
    exact: bool = True

    @property
    def was_interrupted(self) -> bool:
        """Whether the user has ended a round early."""
        return self.watch.facts().interrupted

    @property
    def are_left(self) -> bool:
        """Whether there are iterations and time for another round."""
        has_time = self.watch.seconds_left() > 0.0
        return self.watch.iterations < self.iterations and has_time and not self.was_interrupted

    def polished(self, scene: Scene, iterations: int | None = None, target: Target | None = None) -> Scene:
        """Return ``scene`` after a fit of at most ``iterations``, or as it is if no round is left.

        Args:
            iterations: None for all that are left.
            target: another image to compare with.
        """
        left = self.iterations - self.watch.iterations
        if not self.are_left:
            return scene
        part = self.watch.part(planned=self.iterations)
        count = left if iterations is None else min(iterations, left)
        compared = self.target if target is None else target
        most = VALUES_EXACT_MAX if self.exact else 0
        return polish(
            compared, scene, self.config, part, iterations=count, free=self.free, values_exact_max=most,
            locked=self.locked,
        ).scene  # fmt: skip
