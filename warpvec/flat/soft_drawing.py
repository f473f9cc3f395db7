"""Draw flat art with each shadow or glow as one soft path, if that is the shorter description of the picture.

The picture without the shadows is drawn like any other, and so is the mask of what casts each. Each soft path takes the
outline of its mask, all are fitted to the picture, and the drawing competes with one of bands and gradients.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import torch

from warpvec.flat.constants.softness import SOFTNESS
from warpvec.flat.cutting.cutout import cut_out
from warpvec.flat.cutting.windows import cut_windows
from warpvec.flat.drawing import FlatDrawing
from warpvec.flat.regions.regions import unexplained
from warpvec.flat.simplification.critic import Critic
from warpvec.flat.softness.shaded_rounding import ShadedRounding
from warpvec.flat.softness.shadows import Shadow, find_shadows
from warpvec.flat.softness.shapes import (
    as_one,
    casting_paths,
    cover_of,
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
class _Placed:
    """A shadow and the path around all that casts it, above so many paths of a drawing.

    It may be the same as the outline of its shapes.
    """

    shadow: Shadow
    outline: Scene
    below: int
    is_same: bool


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

        The first is not drawn if the second explains the picture about as well as its regions do.
        """
        soft = self._soft(detail) if self._may_be_soft else None
        if soft is None:
            return self.hard.draw(detail)
        if self._is_all_soft or self._is_right(soft[0]):
            return soft
        hard = self.hard.draw(detail)
        return soft if self._is_better(soft[0], hard[0]) else hard

    def _soft(self, detail: float) -> tuple[Scene, dict[str, int]] | None:
        """Return the drawing with soft paths; None if there is no shadow, what casts one has no outline, or time is up.

        After Ctrl-C the remaining stages return at once.
        """
        if not self._shadows:
            return None
        sharp, left_out = self.clean.draw(detail)
        for shadow in self._shadows:
            sharp = self._with_gaps(sharp, shadow)
        placed = []
        for shadow in self._shadows:
            below = paths_below(sharp, shadow, self.work.config.threads)
            paths = self._casters(sharp, below, shadow)
            if paths is None:
                outline = None if self._is_time_up else self._outline(shadow)
                if outline is None:
                    return None
                sharp = self._with_cover(sharp, shadow, outline)
                below = paths_below(sharp, shadow, self.work.config.threads)
            else:
                outline = as_one(_above(sharp, below), paths)
            placed.append(_Placed(shadow, outline, below, paths is not None))
        placed.sort(key=lambda each: each.below)
        copies = [soft_copy(each.outline, each.shadow) for each in placed]
        if not all(each.is_same for each in placed):
            free = self._fitted(_inserted(sharp, placed, copies))
            assert free.softness is not None
            rows = free.softness.is_soft.nonzero().flatten()
            if len(rows) < len(placed):
                return free, left_out
            copies = [free.select(row[None]) for row in rows]
        casters = [self._casters(sharp, each.below, each.shadow) if each.is_same else None for each in placed]
        if all(paths is None for paths in casters):
            return _inserted(sharp, placed, copies), left_out
        return self._with_same_outlines(sharp, placed, casters, copies), left_out

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
        work = self.work
        if self.known is not None or work.known is not None:
            return self.known or ()
        return find_shadows(work.image.numpy(), self.hard.rough, lambda: self._is_time_up, work.rounding is not None)

    @cached_property
    def clean(self) -> FlatDrawing:
        """The work on the picture without its shadows."""
        image, work = torch.from_numpy(self._shadows[-1].clean), self.work
        added = 255.0 * (work.image - image).double().numpy()
        rounding = None if work.rounding is None else ShadedRounding(work.rounding, added)
        return replace(work, image=image, unexplained_max=None, known=None, rounding=rounding)

    @cached_property
    def _picture(self) -> torch.Tensor:
        """The picture with its shadows, as it was before it was saved as JPEG."""
        work = self.work
        return work.image if work.rounding is None else (self.clean.picture + work.image - self.clean.image).clip(0, 1)

    @cached_property
    def _critic(self) -> Critic:
        return Critic(self._picture, self.work.config)

    def _outline(self, shadow: Shadow) -> Scene | None:
        """Return one path around all that casts the ``shadow``; None if its mask has no outline."""
        mask = torch.from_numpy(1.0 - shadow.casters).float()[..., None].expand(-1, -1, 3).contiguous()
        config = replace(self.work.config, strokes="off", gradients=0.0)
        work = replace(self.work, image=mask, config=config, unexplained_max=None, known=None, rounding=None)
        drawn, _ = work.draw(SOFTNESS.mask_detail)
        height, width = mask.shape[:2]
        parts = cut_out(replace(drawn.outlined(), strokes=None), width, height).scene
        dark = (parts.color.amax(1) < 0.5).nonzero().flatten()
        return joined_outlines(parts.select(dark)) if len(dark) else None

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

    def _with_same_outlines(
        self, sharp: Scene, placed: list[_Placed], casters: list[list[int] | None], copies: list[Scene]
    ) -> Scene:
        """Return ``sharp`` above shadows with the outlines of its shapes; shadows without ``casters`` stay as they are."""
        for _ in range(SOFTNESS.same_rounds):
            placed, copies = self._measured_again(sharp, placed, casters, copies)
            whole = self._fitted(_inserted(sharp, placed, copies), is_soft_fitted=False)
            assert whole.softness is not None
            sharp = whole.select(~whole.softness.is_soft)
        return _inserted(sharp, *self._measured_again(sharp, placed, casters, copies))

    def _casters(self, sharp: Scene, below: int, shadow: Shadow) -> list[int] | None:
        """Return the paths of ``sharp``, counted above the shadow, that are just what casts it; None if none are."""
        shapes = _above(sharp, below)
        if not shadow.is_cast or not 0 < len(shapes) <= SOFTNESS.casting_max:
            return None
        return casting_paths(shapes, shadow, self.work.config.threads)

    def _measured_again(
        self, sharp: Scene, placed: list[_Placed], casters: list[list[int] | None], copies: list[Scene]
    ) -> tuple[list[_Placed], list[Scene]]:
        """Return the shadows of known ``casters`` as the outlines of ``sharp`` cast them, and all soft paths."""
        image, threads = self._picture.numpy(), self.work.config.threads
        placed, copies = list(placed), list(copies)
        for k, (each, paths) in enumerate(zip(placed, casters, strict=True)):
            if paths is not None:
                shapes = _above(sharp, each.below)
                placed[k] = replace(each, shadow=measured_again(image, shapes, paths, each.shadow, threads))
                copies[k] = soft_copy(as_one(shapes, paths), placed[k].shadow)
        return placed, copies

    def _fitted(self, scene: Scene, *, is_soft_fitted: bool = True) -> Scene:
        """Return ``scene`` with its soft paths fitted, or the others; a fit may undo level lines of these."""
        work = self.work
        assert scene.softness is not None
        count = min(SOFTNESS.iterations, work.config.iterations)
        part = work.watch.part(planned=work.watch.iterations + count)
        locked = scene.softness.is_soft != is_soft_fitted
        return polish(self._critic.target, scene, work.config, part, iterations=count, locked=locked).scene

    def _is_right(self, soft: Scene) -> bool:
        """Return whether the drawing leaves little, or hardly more than the regions of the picture with its shadows do."""
        error = 255.0 * float(self._critic.target.squared_error(soft).mean() / 3.0) ** 0.5
        left = unexplained(self.hard.rough.mixed(), self.work.image.numpy())
        return error <= max(SOFTNESS.error_right, left)

    def _is_better(self, soft: Scene, hard: Scene) -> bool:
        """Return whether ``soft`` is the better description, by its error and its bytes."""
        return self._description(self._critic, soft) < self._description(self.hard.critic, hard)

    def _description(self, critic: Critic, scene: Scene) -> float:
        """Return the error of a drawing times what its bytes weigh."""
        height, width = self.work.image.shape[:2]
        error = float(critic.target.squared_error(scene).sum())
        return error * len(write_svg(scene, width, height)) ** SOFTNESS.byte_exponent


def _above(scene: Scene, below: int) -> Scene:
    """Return ``scene`` without its ``below`` lowest paths."""
    return scene.select(torch.arange(below, len(scene)))


def _inserted(scene: Scene, placed: list[_Placed], copies: list[Scene]) -> Scene:
    """Return ``scene`` with the ``copies``, the soft paths of shadows in ascending order, at their places."""
    for each, path in zip(reversed(placed), reversed(copies), strict=True):
        scene = scene.prefix(each.below).joined(path).joined(_above(scene, each.below))
    return scene
