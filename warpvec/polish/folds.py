"""Keep the outlines of a drawing from crossing themselves, and strokes from turning back, while they move."""

from __future__ import annotations

import torch
from torch import Tensor

from warpvec.geometry.crossings import crossings_of_rows, overlapping_pairs, sums_of_paths
from warpvec.geometry.overshoots import overshoots
from warpvec.geometry.rounding import round_nodes
from warpvec.geometry.scene import Scene
from warpvec.polish.fold_look import FoldLook
from warpvec.polish.variables import Variables

UNFOLDING_MAX = 8
"""Number of times that the part of a path to take back grows by its neighbours, before the whole path goes back."""

PAIRS_GUARDED_MAX = 2**18
"""Most pairs of segments of a path, side by side from left to right, that is looked at for folds. A path of 2,000
segments along a circle has 2**14; this many take 0.1 s a look."""

CROSSINGS_GUARDED_MAX = 256
"""A path that starts with more crossings is not looked at for folds: it is a scribble, where one more is not seen."""


class FoldGuard:
    """Finds what crosses itself more often than in the drawing at the start, and takes it back.

    Strokes may cross themselves. Their segments must not overshoot their ends, unless they did at the start. Paths
    beyond ``PAIRS_GUARDED_MAX`` or ``CROSSINGS_GUARDED_MAX`` may fold.

    Args:
        start: the drawing at the start, with R segments.
        variables: its values.
        precision: decimals of the coordinates in the file.
        is_on: whether there is anything to guard.
    """

    def __init__(self, start: Scene, variables: Variables, precision: int, *, is_on: bool) -> None:
        self._start, self._variables, self._precision = start, variables, precision
        self._is_guarded = (overlapping_pairs(start) <= PAIRS_GUARDED_MAX) & is_on
        self._may_overshoot = torch.ones(len(start.segments), dtype=torch.bool, device=start.segments.device)
        if start.strokes is not None and is_on:  # lines may cross
            self._is_guarded &= ~start.strokes.is_stroked
            is_fill = ~start.strokes.is_stroked[start.structure.segment_path.long()]
            self._may_overshoot = is_fill | overshoots(start) | overshoots(self._written(start))
        if variables.locked is not None:
            self._is_guarded &= ~variables.locked
            self._may_overshoot |= variables.locked[start.structure.segment_path.long()]
        # The start of a later part may cross itself only until its file is rounded, which allows no crossing.
        look = FoldLook(start, precision) if is_on and FoldLook.is_possible(start) else None
        if look is None:
            as_written = crossings_of_rows(self._written(start), self._is_guarded)
        else:
            as_written = look.crossings(look.written(start.segments), self._is_guarded)
        self._crossings = torch.minimum(crossings_of_rows(start, self._is_guarded), as_written)
        self._is_guarded &= sums_of_paths(start, self._crossings) <= 2 * CROSSINGS_GUARDED_MAX
        self._has_lines = not bool(self._may_overshoot.all())
        self._is_on = bool(self._is_guarded.any()) or self._has_lines
        self._look = look
        self._safe = variables.start

    def folds(self, x: Tensor) -> Tensor:
        """Return the segments [R] (bool) that are folded and were not at the start, once a file has rounded them.

        Those of fills cross more often than at the start, those of strokes overshoot.
        """
        if not self._is_on:
            return torch.zeros_like(self._crossings, dtype=torch.bool)
        if self._look is not None:
            return self._looked_at(self._variables.shown(x), self._look)
        scene = self._written(self._variables.shown(x))
        folded = crossings_of_rows(scene, self._is_guarded) > self._crossings
        return folded | (overshoots(scene) & ~self._may_overshoot) if self._has_lines else folded

    def _looked_at(self, scene: Scene, look: FoldLook) -> Tensor:
        """Return `folds` of ``scene``."""
        written, folded = look.written(scene.segments), torch.zeros_like(self._may_overshoot)
        if bool(self._is_guarded.any()):
            folded = look.crossings(written, self._is_guarded) > self._crossings
        if self._has_lines and scene.strokes is not None:
            folded |= look.overshoots(written, scene.strokes.width) & ~self._may_overshoot
        return folded

    def trust(self, x: Tensor) -> None:
        """Go back to the values ``x``, which fold nowhere, from now on."""
        self._safe = x

    def unfolded(self, x: Tensor) -> tuple[Tensor, Tensor | None]:
        """Return ``x`` with folded parts as they were in the values trusted last, and a mask [K] of these values.

        The mask is None if nothing is folded. The parts are the segments that cross, and more and more of their
        neighbours until nothing is folded. At the latest whole paths go back. The result is trusted.
        """
        folds, points = self.folds(x), None
        if folds.any():
            x, points = self._taken_back(x, folds)
        self._safe = x
        return x, points

    def _taken_back(self, x: Tensor, folds: Tensor) -> tuple[Tensor, Tensor]:
        structure = self._start.structure
        following, preceding = structure.segment_next.long(), structure.segment_previous.long()
        back = folds
        for _ in range(UNFOLDING_MAX):
            back = back | back[following] | back[preceding]
            points = self._variables.points_of(back)
            taken = torch.where(points, self._safe, x)
            folds = self.folds(taken)
            if not folds.any():
                return taken, points
            back = back | folds
        points = self._variables.points_of(self._variables.whole_paths(back))
        return torch.where(points, self._safe, x), points

    def _written(self, scene: Scene) -> Scene:
        """Return ``scene`` with its nodes as a file rounds them."""
        return scene if scene.is_uniform else round_nodes(scene, self._precision)
