"""The knob of drawings of flat art: the detail of their outlines."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence

from warpvec.drawing.drawing import Drawing
from warpvec.goals.search import Attempt, Trial, fits, reaches
from warpvec.modes.request import Request

SEARCHED_DETAIL_MIN = 0.0125
"""Finest detail in pixels that a search tries. A finer drawing follows the noise of eight bits."""

SEARCHED_DETAIL_MAX = 6.4
"""Coarsest detail in pixels that a search tries. A coarser drawing has lost its shapes, and paths are left out
instead."""

STEP = 2.0
"""Factor between two tries until a miss and a hit of the goal enclose the wanted detail."""

HALVINGS = 2
"""Tries inside such a bracket, each in the middle on a logarithmic scale."""


class Detail:
    """The knob of one drawing.

    Args:
        request: its ``settings.detail`` is tried first.
        draw: makes the drawing of a detail in pixels.
    """

    cuts_smallest = True

    def __init__(self, request: Request, draw: Callable[[float], Drawing]) -> None:
        self._goal, self._watch, self._draw = request.goal, request.watch, draw
        self._detail = request.settings.detail
        self.refusal: tuple[str, str] | None = None
        if request.settings.cutout:  # in a drawing without overlaps each missing path would leave a hole
            remedy = "the size of the coarsest drawing, or leave --cutout out"
            self.refusal = "must be enough for all paths without overlaps", remedy

    def attempts(self, trials: Sequence[Trial]) -> Iterator[Attempt]:
        """Find the coarsest detail that has the quality, or the finest that is within the size."""
        detail = other = self._detail
        yield Attempt(self._draw(detail))
        if self._goal.quality is None and fits(self._goal, trials[-1]):
            return
        is_coarse = self._wants_coarser(trials)
        while self._wants_coarser(trials) == is_coarse and not self._watch.is_over():
            detail, other = other, other * (STEP if is_coarse else 1.0 / STEP)
            if not SEARCHED_DETAIL_MIN <= other <= SEARCHED_DETAIL_MAX:
                return
            yield from self._tried(other, trials)
        fine, coarse = sorted((detail, other))
        for _ in range(HALVINGS):
            if self._watch.is_over():
                return
            middle = math.sqrt(fine * coarse)
            yield from self._tried(middle, trials)
            fine, coarse = (middle, coarse) if self._wants_coarser(trials) else (fine, middle)

    def _tried(self, detail: float, trials: Sequence[Trial]) -> Iterator[Attempt]:
        """Draw with ``detail``, unless nothing is left of the drawing."""
        drawing = self._draw(detail)
        if len(drawing.scene) or not trials[0].curves:
            yield Attempt(drawing)

    def _wants_coarser(self, trials: Sequence[Trial]) -> bool:
        """Return whether the last drawing is too large, or better than it need be."""
        return not fits(self._goal, trials[-1]) or reaches(self._goal, trials[-1])
