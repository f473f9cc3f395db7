"""The search for a drawing that meets a goal: the detail of its outlines decides its bytes and its PSNR."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace

from warpvec.errors import InputError
from warpvec.vectorization.byte_limit import cut_to_bytes
from warpvec.vectorization.goal import Goal, Trial, make_facts
from warpvec.vectorization.next_trial import best_trial
from warpvec.vectorization.result import Result

DETAIL_MIN, DETAIL_MAX = 0.0125, 6.4
"""Finest and coarsest detail in pixels that a search tries. A drawing finer than the first follows the noise of eight
bits; one coarser than the second has lost its shapes, and paths are left out instead."""

STEP = 2.0
"""Factor between two tries until a miss and a hit of the goal enclose the wanted detail."""

HALVINGS = 2
"""Tries inside such a bracket, each in the middle on a logarithmic scale."""


@dataclass
class DetailSearch:
    """The drawings that are made for a goal.

    Attributes:
        goal: the requirements on the file.
        draw: makes a drawing of a detail in pixels.
        is_over: says whether Ctrl-C or the time budget ends the search.
        can_lose_paths: whether paths may go. In a drawing without overlaps each would leave a hole.
    """

    goal: Goal
    draw: Callable[[float], Result]
    is_over: Callable[[], bool]
    can_lose_paths: bool = True
    _results: list[Result] = field(default_factory=list)
    _trials: list[Trial] = field(default_factory=list)

    def run(self, detail: float) -> Result:
        """Return the drawing that meets the goal or comes nearest, beginning with ``detail``.

        It never has more bytes than the goal allows. Without bytes or a PSNR in the goal, it is that of ``detail``.

        Raises:
            InputError: not even one path fits into the bytes, or no drawing without overlaps.
        """
        self._try(detail)
        if self.goal.target_psnr is not None or not self._fits():
            self._approach(detail)
        best = self._best()
        result, trial = self._cut(self._results[best], self._trials[best])
        last = self._results[-1].fitted  # the time and the history of all drawings
        fitted = replace(last, scene=result.fitted.scene)
        return replace(result, fitted=fitted, goal_facts=make_facts(self.goal, self._trials, trial))

    def _approach(self, detail: float) -> None:
        """Find the coarsest detail that reaches the PSNR, or the finest that fits into the bytes."""
        is_coarse = self._is_coarser_wanted()
        other = detail
        while self._is_coarser_wanted() == is_coarse and not self.is_over():
            detail, other = other, other * (STEP if is_coarse else 1.0 / STEP)
            if not DETAIL_MIN <= other <= DETAIL_MAX:
                return
            self._try(other)
        fine, coarse = sorted((detail, other))
        for _ in range(HALVINGS):
            if self.is_over():
                return
            middle = math.sqrt(fine * coarse)
            self._try(middle)
            fine, coarse = (middle, coarse) if self._is_coarser_wanted() else (fine, middle)

    def _try(self, detail: float) -> None:
        result = self.draw(detail)
        trial = result.trial(self.goal)
        if self._trials and trial.curves == 0 < self._trials[0].curves:
            return  # so coarse that nothing is left
        self._results.append(result)
        self._trials.append(trial)

    def _is_coarser_wanted(self) -> bool:
        """Return whether the last drawing is too large, or better than it need be."""
        last = self._trials[-1]
        return not self._fits() or (self.goal.target_psnr is not None and last.psnr >= self.goal.target_psnr)

    def _best(self) -> int:
        """Return the index of the drawing to keep, or to remove paths from: the smallest if none fits."""
        if self.goal.max_bytes is None or any(trial.bytes <= self.goal.max_bytes for trial in self._trials):
            return best_trial(self.goal, self._trials)
        return min(range(len(self._trials)), key=lambda index: self._trials[index].bytes)

    def _fits(self) -> bool:
        return self.goal.max_bytes is None or self._trials[-1].bytes <= self.goal.max_bytes

    def _cut(self, result: Result, trial: Trial) -> tuple[Result, Trial]:
        """Remove paths from ``result`` until it is within the bytes; return it with its ``trial``."""
        limit = self.goal.max_bytes
        if limit is not None and trial.bytes > limit and not self.can_lose_paths:
            remedy = f"give at least {trial.bytes}, the size of the coarsest drawing, or leave --cutout out"
            raise InputError("max_bytes", "must be enough for all shapes without overlaps", str(limit), remedy)
        return cut_to_bytes(result, self.goal, self._trials, trial)
