"""Fit a drawing to an image without changing its structure, never to a worse one."""

from __future__ import annotations

import math

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.loop import single_torch_thread
from warpvec.fit.target import Target
from warpvec.geometry.scene import Scene
from warpvec.polish.descent import MOMENTUM_SHARE, Descent
from warpvec.polish.folds import FoldGuard
from warpvec.polish.levenberg_marquardt import GAIN_MIN, LevenbergMarquardt
from warpvec.polish.variables import Evaluation, Variables
from warpvec.rendering.launch import resolve_device
from warpvec.rendering.streams import on_warps_stream
from warpvec.watch.progress import Progress
from warpvec.watch.watch import FitResult, Part, Watch

VALUES_EXACT_MAX = 12_000
"""Most values of a drawing that is fitted by damped Gauss-Newton steps. Their time grows with the number of values: 135
segments in 22 paths take 50 ms a step."""

PATHS_EXACT_MAX = 256
"""Most paths of such a drawing: a step of 512 paths of a photo takes longer than the whole fit by gradients."""

CHECK_GAP = 5
"""Iterations by gradients between two looks for paths that have folded over. These go back to the look before."""

RESTART_SHARE = 0.99
"""Gauss-Newton steps that improve nothing any more start anew, with no memory of what had folded, if the last start has
brought the loss below this share. Tracings of emoji_u1f988 and emoji_u1f36f gain 1.7 and 0.1 dB by new starts."""

RESTART_ROOM = 40
"""Fewest iterations that must be left for a new start."""

TURNS_SOFT = 3
"""Most turns of a drawing with soft paths: first all others by damped Gauss-Newton steps, whose matrix knows no blur,
then the soft ones by gradients."""

ITERATIONS_SOFT = 60
"""Most iterations of the soft paths in a turn. A shadow of ten nodes needs some thirty."""

GAIN_SOFT_MIN = 0.01
"""Share of the loss below which the gain of a turn is that of the last one."""

ROUNDING = 1e-4
"""Change of the start, in pixels and shares of colours, by its bounds, below which it counts as drawn already."""

HISTORY_GAP = 10
"""Iterations between entries of the history."""


def polish(
    target: Target,
    start: Scene,
    config: FitConfig,
    part: Part | None = None,
    *,
    iterations: int,
    free: bool = False,
    values_exact_max: int = VALUES_EXACT_MAX,
    locked: Tensor | None = None,
    gain_min: float = GAIN_MIN,
    unseen: float = 0.0,
    keeps_stops: bool = False,
    tension: Tensor | None = None,
) -> FitResult:
    """Fit ``start`` to ``target`` and keep its structure; the loss of the result is at most its own.

    Lines stay lines, smooth nodes smooth, opaque paths opaque, and no path crosses itself more often than before; see
    `FoldGuard` for the exceptions. Regularizers, learning rates (except ``lr_scale``) and the schedule of ``config``
    are not used.

    Args:
        target: the image to compare with.
        start: the cubic drawing, in pixels of the target.
        config: settings of the run.
        part: the part of a run that this fit is; None for a run of its own.
        iterations: most evaluations of the loss; 0 returns ``start``. It ends earlier once nothing improves any more.
        free: let smooth nodes become corners, opaque paths translucent, and paths cross themselves.
        values_exact_max: most values that are fitted by Gauss-Newton steps.
        locked: paths [N] (bool) that keep their form and paint; None for none.
        gain_min: Gauss-Newton steps end once the last ones have gained a smaller share of the loss and ``unseen``.
        unseen: mean squared error that viewers of the file add anyway.
        keeps_stops: keep the colours and opacities of the stops of gradients.
        tension: rise of the loss with each pixel of length of each segment [R], see `warpvec.polish.tension`; None for
            none. The loss of the result, with the tension, is at most that of ``start``.

    Raises:
        InputError: the device does not exist.
    """
    device = resolve_device(config.device)
    part = Watch(time_budget=config.time_budget).part() if part is None else part
    with on_warps_stream(device), single_torch_thread(), torch.no_grad(), part:
        locked, tension = (None if each is None else each.to(device) for each in (locked, tension))
        run = _Polish(target, start.to(device), config, part, iterations, free, locked, keeps_stops, unseen, tension)
        try:
            run.take(values_exact_max, gain_min)
        except KeyboardInterrupt:
            part.interrupted = True
        except _OutOfTime:
            pass
        return part.result(run.scene(), device)


class _Polish:
    def __init__(
        self,
        target: Target,
        start: Scene,
        config: FitConfig,
        part: Part,
        iterations: int,
        free: bool,
        locked: Tensor | None,
        keeps_stops: bool,
        unseen: float,
        tension: Tensor | None,
    ) -> None:
        self._unseen, self._tension = unseen, tension
        self._target, self._config, self._part, self._iteration_count = target, config, part, iterations
        self._free, self._locked, self._keeps_stops = free, locked, keeps_stops
        self._iteration = 0
        self._begin(start, locked)

    def _begin(self, start: Scene, locked: Tensor | None) -> None:
        """Go on from ``start``, with the paths ``locked`` [N] as they are."""
        self._start = start
        self._variables = Variables(
            start, self._target, self._config, free=self._free, locked=locked, keeps_stops=self._keeps_stops,
            tension=self._tension,
        )  # fmt: skip
        self._first = self._variables.evaluate(self._variables.start)
        is_same = self._variables.start_change() < ROUNDING
        self._start_loss = self._first.loss if is_same else self._variables.loss_of(start)
        self._guard = FoldGuard(start, self._variables, self._config.precision, is_on=not self._free)
        self._best: Evaluation | None = None

    def take(self, values_exact_max: int, gain_min: float) -> None:
        """Take the iterations; raise KeyboardInterrupt once the user asks for the best result so far."""
        if self._iteration_count == 0:
            return
        if self._start.softness is not None and bool(self._start.softness.is_soft.any()):
            self._take_by_turns(self._start.softness.is_soft, values_exact_max, gain_min)
        else:
            self._take_whole(values_exact_max, gain_min)

    def _take_whole(self, values_exact_max: int, gain_min: float) -> None:
        if self._variables.value_count <= values_exact_max and len(self._start) <= PATHS_EXACT_MAX:
            self._take_exactly(gain_min)
        else:
            self._take_by_gradients()

    def _take_by_turns(self, is_soft: Tensor, values_exact_max: int, gain_min: float) -> None:
        """Fit the sharp and the ``is_soft`` paths [N] in turns."""
        for _ in range(TURNS_SOFT):
            before = self._best_loss
            if not bool(is_soft.all()):
                self._begin(self.scene(), is_soft if self._locked is None else is_soft | self._locked)
                self._take_whole(values_exact_max, gain_min)
            self._begin(self.scene(), ~is_soft if self._locked is None else ~is_soft | self._locked)
            left = min(ITERATIONS_SOFT, self._iteration_count - self._iteration)
            if left > 1:
                descent = Descent(self._variables, self._best_x, self._config.seed, self._config.lr_scale)
                for found in descent.by_curvature(left):
                    self._see(found)
            if self._best_loss > (1.0 - GAIN_SOFT_MIN) * before:
                return

    def _take_exactly(self, gain_min: float) -> None:
        """Take Gauss-Newton steps, which fold nothing, and start anew from the best while that pays."""
        config, before = self._config, math.inf
        while self._best_loss < RESTART_SHARE * before:
            before = self._best_loss
            folds = self._guard.folds
            here = self._first if self._best is None else self._best
            solver = LevenbergMarquardt(self._variables, here, folds, config.seed, config.lr_scale)
            for found in solver.steps(self._iteration_count - self._iteration, gain_min, self._unseen):
                self._see(found)
            if self._iteration + RESTART_ROOM > self._iteration_count:
                break

    def _take_by_gradients(self) -> None:
        """Take steps by gradients alone, and take back what folds."""
        descent = Descent(self._variables, self._variables.start, self._config.seed, self._config.lr_scale)
        for found in descent.with_momentum(max(1, round(MOMENTUM_SHARE * self._iteration_count))):
            self._see(found)
            if self._iteration % CHECK_GAP == 0:
                self._take_back(descent, found.x)
        while self._iteration < self._iteration_count:
            self._unfold_best(descent)
            before = self._iteration
            for found in descent.by_curvature(self._iteration_count - self._iteration):
                self._see(found)
                if self._iteration % CHECK_GAP == 0:
                    if self._guard.folds(self._best_x).any():
                        break
                    self._guard.trust(self._best_x)
            else:
                break  # nothing improves it any more
            if self._iteration == before:
                break

    def scene(self) -> Scene:
        """Return the best scene so far, which is the start itself if none is better."""
        if self._best is not None:
            self._unfold_best()
        is_better = self._best is not None and self._best.loss < self._start_loss
        return self._variables.scene(self._best_x) if is_better else self._start

    @property
    def _best_loss(self) -> float:
        return self._start_loss if self._best is None else self._best.loss

    @property
    def _best_x(self) -> Tensor:
        return self._variables.start if self._best is None else self._best.x

    def _see(self, found: Evaluation) -> None:
        """Count and report an iteration, and keep it if it is the best."""
        if self._best is None or found.loss < self._best.loss:
            self._best = found
        self._iteration += 1
        self._report(found)
        if self._part.is_stopped():
            raise KeyboardInterrupt
        if self._part.is_late():
            raise _OutOfTime

    def _take_back(self, descent: Descent, x: Tensor) -> Tensor:
        """Return ``x`` without folds, and let ``descent`` go on from there."""
        x, points = self._guard.unfolded(x)
        descent.take_back(x, torch.zeros_like(self._variables.is_free) if points is None else points)
        return x

    def _unfold_best(self, descent: Descent | None = None) -> None:
        """Undo the folds of the best values, and let ``descent``, if there is one, go on from these."""
        before = self._best_x
        x = self._guard.unfolded(before)[0] if descent is None else self._take_back(descent, before)
        if x is not before:
            self._best = self._variables.evaluate(x)

    def _report(self, found: Evaluation) -> None:
        iteration, count, loss = self._iteration, self._iteration_count, torch.tensor(found.loss)
        progress = Progress(
            iteration, count, len(self._start), self._part.seconds(), loss, lambda: self._variables.scene(found.x)
        )
        self._part.report(progress, is_entry=iteration % HISTORY_GAP == 0 or iteration == count)


class _OutOfTime(Exception):
    """The time budget is spent."""
