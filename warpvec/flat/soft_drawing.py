"""Draw flat art with each shadow or glow as one soft path, if that is the shorter description of the picture.

The picture without the shadows is drawn like any other, and so is the mask of what casts each. Each soft path takes the
outline of its mask, all are fitted to the picture, and the drawing competes with one of bands and gradients.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
import torch

from warpvec.flat.constants.softness import SOFTNESS
from warpvec.flat.copied_shadows import CopiedShadows
from warpvec.flat.cutting.cutout import cut_out
from warpvec.flat.cutting.windows import cut_windows
from warpvec.flat.drawing import FlatDrawing
from warpvec.flat.regions.regions import unexplained
from warpvec.flat.softness.copies import find_copies
from warpvec.flat.softness.drawn_casters import DrawnCasters
from warpvec.flat.softness.shadows import Shadow, find_shadows
from warpvec.flat.softness.shapes import (
    as_one,
    cover_of,
    find_gaps,
    joined_outlines,
    paths_below,
    soft_copy,
)
from warpvec.geometry.scene import Scene
from warpvec.polish.polish import polish
from warpvec.svg.write import write_svg


@dataclass(frozen=True)
class _Placed:
    """A shadow and the path around all that casts it, above so many paths of a drawing."""

    shadow: Shadow
    outline: Scene
    below: int


@dataclass(frozen=True)
class SoftDrawing:
    """The work on a picture that may have shadows.

    Attributes:
        hard: the same without looking for one.
        known: the shadows to draw; None to look for them.
    """

    hard: FlatDrawing
    known: tuple[Shadow, ...] | None = None

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
        self.work.watch.tell("looking for shadows")
        if not self._shadows:
            return self._with_copies(detail) or self.hard.draw(detail)
        if math.isfinite(self.work.watch.seconds_left()) and not self._is_all_soft:
            hard = self.hard.draw(detail)
            return hard if self.work.watch.is_over() else self._better(self._soft(detail), hard)
        soft = self._soft(detail)
        sure = [shadow.is_cast and shadow.look.unexplained <= SOFTNESS.explained for shadow in self._shadows]
        is_sure = bool(sure) and all(sure)
        if soft is not None and (self._is_all_soft or (is_sure and self._is_right(soft[0]))):
            return soft
        hard = self.hard.draw(detail)
        best = self._better(soft, hard)
        best = best if best is soft else self._with_fewer_shadows(detail, hard)
        return best if best is not hard else self._with_copies(detail) or hard

    def _with_copies(self, detail: float) -> tuple[Scene, dict[str, int]] | None:
        """Return the drawing with shadows that are copies of paths; None if there are none, or it leaves much more."""
        if self._copies is None:
            return None
        work, (sharp, left_out) = self._copies, self._copies.clean.draw(detail)
        scene = work.with_shadows(sharp)
        left = unexplained(self.hard.rough.mixed(), self.work.image.numpy())
        if scene is None or work.error(scene) > max(SOFTNESS.error_right, left):
            return None
        return scene, left_out

    def _with_fewer_shadows(self, detail: float, hard: tuple[Scene, dict[str, int]]) -> tuple[Scene, dict[str, int]]:
        """Return the drawing with the first shadows that are explained well, if it is better than ``hard``.

        Two shadows of one card are taken for one, which is poor enough to spoil the outlines of the card.
        """
        is_poor = [shadow.look.unexplained > SOFTNESS.well_explained for shadow in self._shadows]
        count = is_poor.index(True) if any(is_poor) else 0
        return self._better(replace(self, known=tuple(self._shadows[:count]))._soft(detail), hard) if count else hard

    def _better(
        self, soft: tuple[Scene, dict[str, int]] | None, hard: tuple[Scene, dict[str, int]]
    ) -> tuple[Scene, dict[str, int]]:
        return soft if soft is not None and self._is_better(soft[0], hard[0]) else hard

    def _soft(self, detail: float) -> tuple[Scene, dict[str, int]] | None:
        """Return the drawing with soft paths; None if there is no shadow, what casts one has no outline, or time is up.

        After Ctrl-C the remaining stages return at once.
        """
        if not self._shadows:
            return None
        sharp, left_out = self._clean.draw(detail)
        outlines = [None if self._is_time_up else self._outline(shadow) for shadow in self._shadows]
        found = [outline for outline in outlines if outline is not None]
        if self._is_time_up or len(found) < len(outlines):
            return None
        for shadow, outline in zip(self._shadows, found, strict=True):
            sharp = self._with_cover(self._with_gaps(sharp, shadow), shadow, outline)
        placed = sorted(map(partial(self._placed, sharp), self._shadows, found), key=lambda each: each.below)
        free = self._fitted(_inserted(sharp, placed, [soft_copy(each.outline, each.shadow) for each in placed]))
        same = None if self._is_time_up else self._with_same_outlines(sharp, placed, free)
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
        is_free = is_free and self.work.tracing is None
        return is_free and (self.hard.blur <= SOFTNESS.blur_max or self._is_all_soft)

    @cached_property
    def _is_all_soft(self) -> bool:
        """Whether the picture looks blurred because nothing but soft spots lies on its ground, such as lights."""
        if self.hard.blur < SOFTNESS.lights_blur_min or not self._shadows:
            return False
        return float(np.ptp(self._shadows[-1].clean, (0, 1)).max()) <= SOFTNESS.clean_max

    @cached_property
    def _shadows(self) -> Sequence[Shadow]:
        return find_shadows(self.work.image.numpy(), lambda: self._is_time_up) if self.known is None else self.known

    @cached_property
    def _copies(self) -> CopiedShadows | None:
        """The work on shadows that are copies of traced pieces; None without one. Known outlines have none."""
        work = self.work
        if work.known is not None or self._is_time_up:
            return None
        if work.rounding is not None and work.jpeg is None:
            return None  # the price of a shadow needs the steps of the JPEG, which were enlarged
        saved = None if work.jpeg is None else work.evidence
        found = find_copies(work.image.numpy(), self.hard.rough, lambda: self._is_time_up, saved)
        return CopiedShadows(self.work, found[0]) if found else None

    @property
    def drawn_work(self) -> FlatDrawing:
        """The work whose paths the last drawing with copies of them has, or else that without soft paths."""
        return self._copies.clean if not self._shadows and self._copies is not None else self.hard

    @cached_property
    def _clean(self) -> FlatDrawing:
        image = torch.from_numpy(self._shadows[-1].clean)
        return replace(self.work, image=image, may_refuse=False, is_doubtful=False, known=None, rounding=None)

    def _outline(self, shadow: Shadow) -> Scene | None:
        """Return one path around all that casts the ``shadow``; None if its mask has no outline."""
        mask = torch.from_numpy(1.0 - shadow.casters).float()[..., None].expand(-1, -1, 3).contiguous()
        config = replace(self.work.config, strokes="off", gradients=0.0)
        work = replace(self.work, image=mask, config=config, known=None, rounding=None)
        work = replace(work, may_refuse=False, is_doubtful=False)
        drawn, _ = work.draw(SOFTNESS.mask_detail)
        height, width = mask.shape[:2]
        parts = cut_out(replace(drawn.outlined(), strokes=None), width, height).scene
        dark = (parts.color.amax(1) < 0.5).nonzero().flatten()
        return joined_outlines(parts.select(dark)) if len(dark) else None

    def _placed(self, sharp: Scene, shadow: Shadow, outline: Scene) -> _Placed:
        return _Placed(shadow, outline, paths_below(sharp, shadow, self.work.config.threads))

    def _with_gaps(self, sharp: Scene, shadow: Shadow) -> Scene:
        """Return ``sharp`` with holes in its shapes where the ground, and so the shadow, is seen through them."""
        (height, width), threads = self.work.image.shape[:2], self.work.config.threads
        below = paths_below(sharp, shadow, threads)
        shapes = _above(sharp, below)
        is_gap = find_gaps(shapes, shadow, threads)
        if not is_gap.any():
            return sharp
        return sharp.prefix(below).joined(cut_windows(shapes, is_gap, width, height))

    def _with_cover(self, sharp: Scene, shadow: Shadow, outline: Scene) -> Scene:
        """Return ``sharp`` with a path that hides the ``shadow`` where shapes of the colour of the ground cast it."""
        cover = cover_of(outline, shadow) if shadow.is_cast else None
        if cover is None:
            return sharp
        below = paths_below(sharp, shadow, self.work.config.threads)
        return sharp.prefix(below).joined(cover).joined(_above(sharp, below))

    def _with_same_outlines(self, sharp: Scene, placed: list[_Placed], free: Scene) -> Scene | None:
        """Return ``sharp`` above shadows with the outlines of its shapes; None if no paths are what casts one.

        The other shadows stay as they are in ``free``, the drawing in which all outlines are free.
        """
        assert free.softness is not None
        rows = free.softness.is_soft.nonzero().flatten()
        copies, casters = [free.select(row[None]) for row in rows], [self._casters(sharp, each) for each in placed]
        if len(copies) < len(placed) or all(paths is None for paths in casters):
            return None
        for _ in range(SOFTNESS.same_rounds):
            placed, copies = self._measured_again(sharp, placed, casters, copies)
            whole = self._fitted(_inserted(sharp, placed, copies), is_soft_fitted=False)
            assert whole.softness is not None
            sharp = whole.select(~whole.softness.is_soft)
        return _inserted(sharp, *self._measured_again(sharp, placed, casters, copies))

    def _casters(self, sharp: Scene, placed: _Placed) -> list[int] | None:
        """Return the paths of ``sharp``, counted above the shadow, that are just what casts it; None if none are."""
        shapes = _above(sharp, placed.below)
        if not 0 < len(shapes) <= SOFTNESS.casting_max:
            return None
        return self._drawn(shapes, placed.shadow).find()

    def _drawn(self, shapes: Scene, shadow: Shadow) -> DrawnCasters:
        return DrawnCasters(self.work.image.numpy(), shapes, shadow, self.work.config.threads)

    def _measured_again(
        self, sharp: Scene, placed: list[_Placed], casters: list[list[int] | None], copies: list[Scene]
    ) -> tuple[list[_Placed], list[Scene]]:
        """Return the shadows of known ``casters`` as the outlines of ``sharp`` cast them, and all soft paths."""
        placed, copies = list(placed), list(copies)
        for k, (each, paths) in enumerate(zip(placed, casters, strict=True)):
            if paths is not None:
                shapes = _above(sharp, each.below)
                placed[k] = replace(each, shadow=self._drawn(shapes, each.shadow).measured(paths))
                copies[k] = soft_copy(as_one(shapes, paths), placed[k].shadow)
        return placed, copies

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


def _above(scene: Scene, below: int) -> Scene:
    """Return ``scene`` without its ``below`` lowest paths."""
    return scene.select(torch.arange(below, len(scene)))


def _inserted(scene: Scene, placed: list[_Placed], copies: list[Scene]) -> Scene:
    """Return ``scene`` with the ``copies``, the soft paths of shadows in ascending order, at their places."""
    for each, path in zip(reversed(placed), reversed(copies), strict=True):
        scene = scene.prefix(each.below).joined(path).joined(_above(scene, each.below))
    return scene
