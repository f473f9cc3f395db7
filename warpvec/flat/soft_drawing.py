"""Draw flat art with its shadow or glow as one soft path, if that is the shorter description of the picture.

The picture without the shadow is drawn like any other, and so is the mask of what casts it. The soft path takes the
outline of the mask, is fitted to the picture, and competes with the drawing of bands and gradients.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import torch

from warpvec.flat.constants.softness import SOFTNESS
from warpvec.flat.cutting.cutout import cut_out
from warpvec.flat.cutting.windows import cut_windows
from warpvec.flat.drawing import FlatDrawing
from warpvec.flat.softness.shadows import Shadow, find_shadow
from warpvec.flat.softness.shapes import (
    as_one,
    casting_paths,
    find_gaps,
    joined_outlines,
    measured_again,
    paths_below,
    soft_copy,
)
from warpvec.geometry.scene import Scene
from warpvec.polish.polish import polish
from warpvec.svg.write import write_svg


@dataclass(frozen=True)
class SoftDrawing:
    """The work on a picture that may have a shadow.

    Attributes:
        hard: the same without looking for one.
    """

    hard: FlatDrawing

    @cached_property
    def work(self) -> FlatDrawing:
        """The work on the picture as it is: a shadow makes it look blurred."""
        return replace(self.hard, blur=0.0) if self.hard.blur else self.hard

    def draw(self, detail: float) -> tuple[Scene, dict[str, int]]:
        """Return what `FlatDrawing.draw` does, or the better drawing with a soft path.

        The first is not drawn if a shadow makes the drawing short and exact: it would take as long again. It comes
        first if there is a time budget.
        """
        if not self._may_be_soft:
            return self.hard.draw(detail)
        if math.isfinite(self.work.watch.seconds_left()):
            hard = self.hard.draw(detail)
            return hard if self.work.watch.is_over() else self._better(self._soft(detail), hard)
        soft = self._soft(detail)
        is_sure = self._shadow is not None and self._shadow.is_cast
        if soft is not None and is_sure and self._is_right(soft[0]):
            return soft
        return self._better(soft, self.hard.draw(detail))

    def _better(
        self, soft: tuple[Scene, dict[str, int]] | None, hard: tuple[Scene, dict[str, int]]
    ) -> tuple[Scene, dict[str, int]]:
        return soft if soft is not None and self._is_better(soft[0], hard[0]) else hard

    def _soft(self, detail: float) -> tuple[Scene, dict[str, int]] | None:
        """Return the drawing with a soft path; None if there is no shadow, what casts it has no outline, or time is up.

        If the user stops it, what is left to do takes no time.
        """
        if self._shadow is None:
            return None
        sharp, left_out = self._clean.draw(detail)
        if self._is_time_up or self._outline is None or self._is_time_up:
            return None
        below = paths_below(sharp, self._shadow, self.work.config.threads)
        sharp = self._with_gaps(sharp, self._shadow, below)
        free = self._fitted(_inserted(sharp, soft_copy(self._outline, self._shadow), below))
        same = None if self._is_time_up else self._with_same_outline(sharp, self._shadow, below)
        if same is None:
            return free, left_out
        before, after = (self._description(self.work, scene) for scene in (free, same))
        return (same if after <= SOFTNESS.same_worth * before else free), left_out

    @property
    def _is_time_up(self) -> bool:
        return self.work.watch.seconds_left() <= 0.0

    @property
    def _may_be_soft(self) -> bool:
        config = self.work.config
        is_free = config.opacity == "free" and config.gradients != 0.0 and not config.cutout
        is_free = is_free and config.palette is None and not config.colors and config.soft_max != 0
        return is_free and self.work.tracing is None and self.hard.blur <= SOFTNESS.blur_max

    @cached_property
    def _shadow(self) -> Shadow | None:
        return find_shadow(self.work.image.numpy(), lambda: self._is_time_up)

    @cached_property
    def _clean(self) -> FlatDrawing:
        assert self._shadow is not None
        image = torch.from_numpy(self._shadow.clean)
        return replace(self.work, image=image, unexplained_max=None, known=None, jpeg=None)

    @cached_property
    def _outline(self) -> Scene | None:
        """One path around all that casts the shadow; None if its mask has no outline."""
        assert self._shadow is not None
        mask = torch.from_numpy(1.0 - self._shadow.casters).float()[..., None].expand(-1, -1, 3).contiguous()
        config = replace(self.work.config, strokes="off", gradients=0.0)
        work = replace(self.work, image=mask, config=config, unexplained_max=None, known=None, jpeg=None)
        drawn, _ = work.draw(SOFTNESS.mask_detail)
        height, width = mask.shape[:2]
        parts = cut_out(replace(drawn.outlined(), strokes=None), width, height).scene
        dark = (parts.color.amax(1) < 0.5).nonzero().flatten()
        return joined_outlines(parts.select(dark)) if len(dark) else None

    def _with_gaps(self, sharp: Scene, shadow: Shadow, below: int) -> Scene:
        """Return ``sharp`` with holes in its shapes where the ground, and so the shadow, is seen through them.

        The shapes are above its ``below`` lowest paths.
        """
        (height, width), threads = self.work.image.shape[:2], self.work.config.threads
        shapes = sharp.select(torch.arange(below, len(sharp)))
        is_gap = find_gaps(shapes, shadow, threads)
        if not is_gap.any():
            return sharp
        return sharp.prefix(below).joined(cut_windows(shapes, is_gap, width, height))

    def _with_same_outline(self, sharp: Scene, shadow: Shadow, below: int) -> Scene | None:
        """Return ``sharp`` above a shadow with the outlines of its shapes; None if no paths are what casts it."""
        threads, image = self.work.config.threads, self.work.image.numpy()
        shapes = sharp.select(torch.arange(below, len(sharp)))
        casters = casting_paths(shapes, shadow, threads) if 0 < len(shapes) <= SOFTNESS.paths_right else None
        if casters is None:
            return None
        for _ in range(SOFTNESS.same_rounds):
            shadow = measured_again(image, shapes, casters, shadow, threads)
            whole = self._fitted(
                _inserted(sharp, soft_copy(as_one(shapes, casters), shadow), below), is_soft_fitted=False
            )
            assert whole.softness is not None
            sharp = whole.select(~whole.softness.is_soft)
            shapes = sharp.select(torch.arange(below, len(sharp)))
        shadow = measured_again(image, shapes, casters, shadow, threads)
        return _inserted(sharp, soft_copy(as_one(shapes, casters), shadow), below)

    def _fitted(self, scene: Scene, *, is_soft_fitted: bool = True) -> Scene:
        """Return ``scene`` with its soft paths fitted, or the others; a fit may undo level lines of these."""
        work = self.work
        assert scene.softness is not None
        count = min(SOFTNESS.iterations, work.config.iterations)
        part = work.watch.part(planned=work.watch.iterations + count)
        locked = scene.softness.is_soft != is_soft_fitted
        return polish(work.critic.target, scene, work.config, part, iterations=count, locked=locked).scene

    def _is_right(self, soft: Scene) -> bool:
        """Return whether no drawing of bands can be better."""
        error = float(self.work.critic.target.squared_error(soft).mean() / 3.0) ** 0.5
        return len(soft) <= SOFTNESS.paths_right and 255.0 * error <= SOFTNESS.error_right

    def _is_better(self, soft: Scene, hard: Scene) -> bool:
        """Return whether ``soft`` is the better description, by its error and its bytes."""
        return self._description(self.work, soft) < self._description(self.hard, hard)

    def _description(self, work: FlatDrawing, scene: Scene) -> float:
        """Return the error of a drawing times what its bytes weigh."""
        height, width = self.work.image.shape[:2]
        error = float(work.critic.target.squared_error(scene).sum())
        return error * len(write_svg(scene, width, height)) ** SOFTNESS.byte_exponent


def _inserted(scene: Scene, path: Scene, below: int) -> Scene:
    """Return ``scene`` with ``path`` above its ``below`` lowest paths."""
    lower, upper = scene.prefix(below), scene.select(torch.arange(below, len(scene)))
    return lower.joined(path).joined(upper)
