"""Draw flat art with each shadow, glow or soft spot as one soft path.

The picture without them is drawn once. A shadow is a copy of the paths that cast it, moved and blurred; a spot is an
ellipse.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import torch
from torch import Tensor

from warpvec.arrays import Floats
from warpvec.flat.constants.softness import SOFTNESS
from warpvec.flat.drawing import FlatDrawing
from warpvec.flat.regions.regions import unexplained
from warpvec.flat.simplification.critic import Critic
from warpvec.flat.softness.copies import find_shadows
from warpvec.flat.softness.drawn_casters import DrawnCasters
from warpvec.flat.softness.shaded_rounding import ShadedRounding
from warpvec.flat.softness.shadows import Shadow, channels_of
from warpvec.flat.softness.shapes import as_one, paths_below, soft_copy, spot_path
from warpvec.geometry.scene import Scene
from warpvec.polish.polish import polish


@dataclass(frozen=True)
class _Placed:
    """A shadow above so many paths of a drawing, the paths above these that cast it, and its own path.

    Nothing casts a spot, and its path is fitted to the picture.
    """

    shadow: Shadow
    below: int
    casters: list[int]
    levels: Floats
    path: Scene | None = None


@dataclass(frozen=True)
class SoftDrawing:
    """The work on a picture that may have shadows.

    Attributes:
        hard: the same without looking for one.
    """

    hard: FlatDrawing

    @cached_property
    def work(self) -> FlatDrawing:
        """The work on the picture as it is: a shadow makes it look blurred."""
        return replace(self.hard, blur=0.0) if self.hard.blur else self.hard

    def draw(self, detail: float) -> tuple[Scene, dict[str, int]]:
        """Return what `FlatDrawing.draw` does, or the drawing with soft paths if there are any, as near as regions."""
        if not self._may_be_soft:
            return self.hard.draw(detail)
        self.work.watch.tell("looking for shadows")
        return self._soft(detail) or self.hard.draw(detail)

    def _soft(self, detail: float) -> tuple[Scene, dict[str, int]] | None:
        """Return the drawing with soft paths; None if there are none, or it leaves much more than regions do."""
        if not self._shadows or (self.hard.blur > SOFTNESS.blur_max and not self._is_all_soft):
            return None
        sharp, left_out = self.clean.draw(detail)
        scene = self._with_shadows(sharp)
        if scene is None and sharp.strokes is not None:  # several strokes are no one path that casts a shadow
            filled = replace(self.clean.config, strokes="off")
            sharp, left_out = replace(self.clean, config=filled, known=self.clean.outlines).draw(detail)
            scene = self._with_shadows(sharp)
        left = unexplained(self.hard.rough.mixed(), self.work.image.numpy())
        # What the sharp paths leave of the picture without shadows is left by any drawing, as of jagged edges.
        own = _error(Critic(self.clean.picture, self.work.config), sharp)
        if scene is None or _error(self._critic, scene) > math.hypot(max(SOFTNESS.error_right, left), own):
            return None
        return scene, left_out

    @property
    def _is_time_up(self) -> bool:
        return self.work.watch.seconds_left() <= 0.0

    @property
    def _may_be_soft(self) -> bool:
        config = self.work.config
        is_free = config.opacity == "free" and config.gradients != 0.0 and not config.cutout
        is_free = is_free and config.palette is None and not config.colors and config.soft_max != 0
        return is_free and self.work.tracing is None and self.work.known is None

    @property
    def _is_all_soft(self) -> bool:
        """Whether nothing but soft spots lies on the ground of the picture, such as lights."""
        return float(np.ptp(self._shadows[-1].clean, (0, 1)).max()) <= SOFTNESS.clean_max

    @cached_property
    def _shadows(self) -> Sequence[Shadow]:
        work = self.work
        if self._is_time_up or (work.rounding is not None and work.jpeg is None):
            return ()  # the price of a shadow needs the steps of the JPEG, which were enlarged
        saved = None if work.jpeg is None else work.evidence
        return find_shadows(work.image.numpy(), self.hard.rough, lambda: self._is_time_up, saved)

    @cached_property
    def clean(self) -> FlatDrawing:
        """The work on the picture without its shadows."""
        work, image = self.work, torch.from_numpy(self._shadows[-1].clean)
        added = 255.0 * (work.image - image).double().numpy()
        rounding = None if work.rounding is None else ShadedRounding(work.rounding, added)
        return replace(work, image=image, may_refuse=False, is_doubtful=False, rounding=rounding)

    @cached_property
    def _picture(self) -> Tensor:
        """The picture with its shadows, as it was before it was saved as JPEG [h, w, 3 or 4]."""
        work = self.work
        if work.rounding is None:
            return work.image
        return (self.clean.picture + work.image - self.clean.image).clamp(0.0, 1.0)

    @cached_property
    def _critic(self) -> Critic:
        return Critic(self._picture, self.work.config)

    def _with_shadows(self, sharp: Scene) -> Scene | None:
        """Return ``sharp``, the drawing without the shadows, above soft paths; None if its paths do not cast one."""
        sharp = self._unmarked(sharp)
        placed = []
        for shadow, levels in zip(self._shadows, self._seen(), strict=True):
            below = paths_below(sharp, shadow, self.work.config.threads)
            casters = [] if shadow.spot is not None else self._drawn(sharp, shadow, below, levels).find()
            if casters is None:
                return None
            placed.append(_Placed(shadow, below, casters, levels, spot_path(shadow, sharp)))
        placed.sort(key=lambda each: each.below)
        for is_last in (*(False,) * SOFTNESS.same_rounds, True):
            placed = [self._measured_again(sharp, each) for each in placed]
            whole = _inserted(sharp, placed)
            if is_last:
                return whole
            assert whole.softness is not None
            whole = self._fitted(whole, placed)
            assert whole.softness is not None
            soft = whole.softness.is_soft
            rows = soft.nonzero().flatten().tolist()
            paths = [whole.select(torch.tensor([row])) for row in rows]
            placed = [replace(each, path=path) for each, path in zip(placed, paths, strict=True)]
            sharp = whole.select(~soft)
        return None

    def _unmarked(self, sharp: Scene) -> Scene:
        """Return ``sharp`` with the paths of a colour that marks shapes of the colour of their ground in the latter."""
        color = sharp.color
        for shadow in self._shadows:
            if shadow.mark is not None:
                mark, ground = (torch.from_numpy(each / 255.0).float() for each in (shadow.mark, shadow.ground.color))
                is_marked = (color - mark).abs().amax(1, keepdim=True) <= SOFTNESS.jump / 255.0
                color = torch.where(is_marked, ground, color)
        return replace(sharp, color=color)

    def _seen(self) -> list[Floats]:
        """Return the picture with each of the shadows alone [h, w, C], in levels."""
        final = channels_of(self.clean.picture.numpy())
        before = [self.work.image.numpy(), *(each.clean for each in self._shadows[:-1])]
        after = [each.clean for each in self._shadows]
        return [255.0 * (final + channels_of(one) - channels_of(two)) for one, two in zip(before, after, strict=True)]

    def _drawn(self, sharp: Scene, shadow: Shadow, below: int, levels: Floats) -> DrawnCasters:
        return DrawnCasters(levels, _above(sharp, below), shadow, self.work.config.threads)

    def _measured_again(self, sharp: Scene, placed: _Placed) -> _Placed:
        """Return a shadow as the paths of ``sharp`` cast it, or a spot as it is."""
        if not placed.casters:
            return placed
        shadow = self._drawn(sharp, placed.shadow, placed.below, placed.levels).measured(placed.casters)
        path = soft_copy(as_one(_above(sharp, placed.below), placed.casters), shadow)
        return replace(placed, shadow=shadow, path=path)

    def _fitted(self, scene: Scene, placed: list[_Placed]) -> Scene:
        """Return ``scene`` with its sharp paths and its spots fitted."""
        work = self.work
        assert scene.softness is not None
        count = min(SOFTNESS.iterations, work.config.iterations)
        part = work.watch.part(planned=work.watch.iterations + count)
        locked = scene.softness.is_soft.clone()
        locked[locked.clone()] = torch.tensor([bool(each.casters) for each in placed])
        return polish(self._critic.target, scene, work.config, part, iterations=count, locked=locked).scene


def _error(critic: Critic, scene: Scene) -> float:
    """Return what a drawing leaves of the picture of ``critic``, the root of the mean square in levels."""
    return 255.0 * float(critic.target.squared_error(scene).mean() / 3.0) ** 0.5


def _above(scene: Scene, below: int) -> Scene:
    """Return ``scene`` without its ``below`` lowest paths."""
    return scene.select(torch.arange(below, len(scene)))


def _inserted(scene: Scene, placed: list[_Placed]) -> Scene:
    """Return ``scene`` with the soft paths of shadows, in ascending order, at their places."""
    for each in reversed(placed):
        assert each.path is not None
        scene = scene.prefix(each.below).joined(each.path).joined(_above(scene, each.below))
    return scene
