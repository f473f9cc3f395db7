"""Fit a drawing to an image without changing its structure, never to a worse one."""

from __future__ import annotations

import math
import time
from collections.abc import Callable

import torch
from torch import Tensor

from warpvec.config.fit_config import FitConfig
from warpvec.fit.descent import MOMENTUM_SHARE, Descent
from warpvec.fit.drawing import Drawing, Evaluation
from warpvec.fit.interrupt import deferred_interrupts, hold_signals
from warpvec.fit.levenberg_marquardt import LevenbergMarquardt
from warpvec.fit.loop import single_torch_thread
from warpvec.fit.progress import FitResult, OnProgress, Progress, history_entry
from warpvec.fit.target import Target
from warpvec.geometry.crossings import crossings_of_rows, overlapping_pairs
from warpvec.geometry.rounding import round_nodes
from warpvec.geometry.scene import Scene
from warpvec.rendering.launch import resolve_device
from warpvec.rendering.streams import on_warps_stream

VALUES_EXACT_MAX, PATHS_EXACT_MAX = 12_000, 256
"""Most values and paths of a drawing that is fitted by damped Gauss-Newton steps. Their time grows with both: 135
segments in 22 paths take 50 ms a step, 512 paths of a photo more than its whole fit by gradients."""

CHECK_GAP = 5
"""Iterations by gradients between two looks for paths that have folded over. These go back to the look before."""

UNFOLDING_MAX = 8
"""Times that the part that goes back grows by its neighbours before the whole path goes back."""

PAIRS_GUARDED_MAX = 2**18
"""Most pairs of segments of a path, side by side from left to right, that is looked at for folds. A path of 2,000
segments along a circle has 2**14; this many take 0.1 s a look."""

CROSSINGS_GUARDED_MAX = 256
"""A path that starts with more crossings is not looked at for folds: it is a scribble, where one more is not seen."""

RESTART_SHARE, RESTART_ROOM = 0.99, 40
"""Gauss-Newton steps that improve nothing any more start anew, with no memory of what had folded, if the last start has
brought the loss below this share and so many iterations are left. Tracings of emoji_u1f988 and emoji_u1f36f gain 1.7
and 0.1 dB so."""

HISTORY_GAP = 10
"""Iterations between entries of the history."""


def polish(
    target: Tensor,
    start: Scene,
    config: FitConfig,
    on_progress: OnProgress | None = None,
    *,
    iterations: int,
    free: bool = False,
    values_exact_max: int | None = None,
    locked: Tensor | None = None,
) -> FitResult:
    """Fit ``start`` to ``target`` [h, w, 3 or 4] and keep its structure; the loss of the result is at most its own.

    Lines stay lines, smooth nodes smooth, opaque paths opaque, and no path crosses itself more often than before.
    Paths beyond ``PAIRS_GUARDED_MAX`` or ``CROSSINGS_GUARDED_MAX`` may cross themselves. Regularizers, learning rates
    (except ``lr_scale``) and the schedule of ``config`` are not used.

    Args:
        target: the image, sRGB-encoded in [0, 1], with straight alpha if it has four channels.
        start: the cubic drawing, in pixels of the target.
        config: settings of the run.
        on_progress: called after every iteration.
        iterations: most evaluations of the loss; 0 returns ``start``. It ends earlier once nothing improves any more.
        free: let smooth nodes become corners, opaque paths translucent, and paths cross themselves.
        values_exact_max: most values that are fitted by Gauss-Newton steps; None is ``VALUES_EXACT_MAX``.
        locked: paths [N] (bool) that keep their form and paint; None for none.

    Raises:
        InputError: the device does not exist.
    """
    device = resolve_device(config.device)
    with on_warps_stream(device), single_torch_thread(), torch.no_grad(), deferred_interrupts() as is_interrupted:
        locked = None if locked is None else locked.to(device)
        run = _Polish(target.to(device, torch.float32), start.to(device), config, device, free, locked)
        run.values_exact_max = VALUES_EXACT_MAX if values_exact_max is None else values_exact_max
        run.on_progress = on_progress
        try:
            run.take(iterations, is_interrupted)
        except KeyboardInterrupt:
            run.interrupted = True
        except _OutOfTime:
            pass
        return run.result()


class _Polish:
    def __init__(
        self, image: Tensor, start: Scene, config: FitConfig, device: str, free: bool, locked: Tensor | None
    ) -> None:
        self._config, self._device = config, device
        self._begin = time.perf_counter()
        self._start = start
        compared = Target(image, config, device)
        self._drawing = Drawing(start, compared, config, free=free, locked=locked)
        self._start_loss = float(compared.fit_step(start, False).loss)
        self._is_guarded = (overlapping_pairs(start) <= PAIRS_GUARDED_MAX) & (not free)
        # The start of a later part may cross itself only until its file is rounded, which allows no crossing.
        as_written = crossings_of_rows(self._written(start), self._is_guarded)
        self._crossings = torch.minimum(crossings_of_rows(start, self._is_guarded), as_written)
        self._is_guarded &= _sums_of_paths(start, self._crossings) <= 2 * CROSSINGS_GUARDED_MAX
        self._safe = self._drawing.start
        self._best: Evaluation | None = None
        self._iteration = 0
        self.iteration_count = 0
        self.values_exact_max = VALUES_EXACT_MAX
        self.on_progress: OnProgress | None = None
        self.history: list[dict[str, float]] = []
        self.interrupted = False

    def take(self, iterations: int, is_interrupted: Callable[[], bool]) -> None:
        """Take so many iterations; raise KeyboardInterrupt once ``is_interrupted()``."""
        self.iteration_count = iterations
        if iterations == 0:
            return
        if len(self._drawing.start) <= self.values_exact_max and len(self._start) <= PATHS_EXACT_MAX:
            self._take_exactly(iterations, is_interrupted)
        else:
            self._take_by_gradients(iterations, is_interrupted)

    def _take_exactly(self, iterations: int, is_interrupted: Callable[[], bool]) -> None:
        """Take Gauss-Newton steps, which fold nothing, and start anew from the best while that pays."""
        drawing, config, before = self._drawing, self._config, math.inf
        while self._best_loss < RESTART_SHARE * before:
            before = self._best_loss
            solver = LevenbergMarquardt(drawing, self._best_x, self._folds, config.seed, config.lr_scale)
            for found in solver.steps(iterations - self._iteration):
                self._see(found, is_interrupted)
            if self._iteration + RESTART_ROOM > iterations:
                break

    @property
    def _best_loss(self) -> float:
        return self._start_loss if self._best is None else self._best.loss

    def _take_by_gradients(self, iterations: int, is_interrupted: Callable[[], bool]) -> None:
        """Take steps by gradients alone, and take back what folds."""
        descent = Descent(self._drawing, self._drawing.start, self._config.seed, self._config.lr_scale)
        for found in descent.with_momentum(max(1, round(MOMENTUM_SHARE * iterations))):
            self._see(found, is_interrupted)
            if self._iteration % CHECK_GAP == 0:
                self._take_back(descent, found.x)
        while self._iteration < self.iteration_count:
            self._unfold_best(descent)
            before = self._iteration
            for found in descent.by_curvature(self.iteration_count - self._iteration):
                self._see(found, is_interrupted)
                if self._iteration % CHECK_GAP == 0:
                    if self._folds(self._best_x).any():
                        break
                    self._safe = self._best_x
            else:
                break  # nothing improves it any more
            if self._iteration == before:
                break

    def result(self) -> FitResult:
        """Return the best scene so far, which is the start itself if none is better."""
        if self._best is not None:
            self._unfold_best()
        is_better = self._best is not None and self._best.loss < self._start_loss
        scene = self._drawing.scene(self._best_x) if is_better else self._start
        return FitResult(scene.cpu(), self.history, self._iteration, self._seconds(), self.interrupted, self._device)

    @property
    def _best_x(self) -> Tensor:
        return self._drawing.start if self._best is None else self._best.x

    def _see(self, found: Evaluation, is_interrupted: Callable[[], bool]) -> None:
        """Count and report an iteration, and keep it if it is the best."""
        if self._best is None or found.loss < self._best.loss:
            self._best = found
        self._iteration += 1
        hold_signals()
        self._report(found)
        budget = self._config.time_budget
        if is_interrupted():
            raise KeyboardInterrupt
        if budget is not None and self._seconds() > budget:
            raise _OutOfTime

    def _folds(self, x: Tensor) -> Tensor:
        """Return the segments [R] (bool) that cross more often than at the start, once a file has rounded them."""
        found = crossings_of_rows(self._written(self._drawing.scene(x)), self._is_guarded)
        return (found > self._crossings) & (found > 0)

    def _written(self, scene: Scene) -> Scene:
        """Return ``scene`` with its nodes as a file rounds them."""
        return scene if scene.is_uniform else round_nodes(scene, self._config.precision)

    def _take_back(self, descent: Descent | None, x: Tensor) -> Tensor:
        """Return ``x`` with folded parts as they were at the last look, and tell ``descent``.

        These are the segments that cross, and more and more of their neighbours until nothing is folded. At the
        latest whole paths go back, and at the last look no path was folded.
        """
        folds = self._folds(x)
        if folds.any():
            structure = self._start.structure
            following, preceding = structure.segment_next.long(), structure.segment_previous.long()
            back = folds
            for _ in range(UNFOLDING_MAX):
                back = back | back[following] | back[preceding]
                points = self._drawing.points_of(back)
                taken = torch.where(points, self._safe, x)
                folds = self._folds(taken)
                if not folds.any():
                    break
                back = back | folds
            else:
                owner = structure.segment_path.long()
                whole = torch.zeros(len(self._start), dtype=torch.bool, device=x.device)
                whole[owner[back]] = True
                points = self._drawing.points_of(whole[owner])
                taken = torch.where(points, self._safe, x)
            x = taken
            if descent is not None:
                descent.take_back(x, points)
        elif descent is not None:
            descent.take_back(x, torch.zeros_like(self._drawing.is_free))
        self._safe = x
        return x

    def _unfold_best(self, descent: Descent | None = None) -> None:
        """Undo the folds of the best values, and continue from these."""
        before = self._best_x
        x = self._take_back(descent, before)
        if x is not before:
            self._best = self._drawing.evaluate(x)

    def _report(self, found: Evaluation) -> None:
        loss = torch.tensor(found.loss)
        progress = Progress(
            self._iteration,
            self.iteration_count,
            len(self._start),
            self._seconds(),
            loss,
            lambda: self._drawing.scene(found.x),
        )
        if self._iteration % HISTORY_GAP == 0 or self._iteration == self.iteration_count:
            self.history.append(history_entry(progress))
        if self.on_progress is not None:
            self.on_progress(progress)

    def _seconds(self) -> float:
        return time.perf_counter() - self._begin


def _sums_of_paths(scene: Scene, row_count: Tensor) -> Tensor:
    """Return the sum of a number of each segment [R] over each path [N]."""
    total = torch.zeros(len(scene), dtype=row_count.dtype, device=row_count.device)
    return total.index_add_(0, scene.structure.segment_path.long(), row_count)


class _OutOfTime(Exception):
    """The time budget is spent."""
