"""Draw flat art with a shadow that is a copy of paths: the picture without it is drawn once, the copy put below."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import torch
from torch import Tensor

from warpvec.flat.constants.softness import SOFTNESS
from warpvec.flat.drawing import FlatDrawing
from warpvec.flat.simplification.critic import Critic
from warpvec.flat.softness.drawn_casters import DrawnCasters
from warpvec.flat.softness.shaded_rounding import ShadedRounding
from warpvec.flat.softness.shadows import Shadow
from warpvec.flat.softness.shapes import as_one, paths_below, soft_copy
from warpvec.geometry.scene import Scene
from warpvec.polish.polish import polish


@dataclass(frozen=True)
class CopiedShadows:
    """The work on a picture with a shadow that is a copy of its shapes.

    Attributes:
        work: the work on the picture as it is.
        shadow: as a rough tracing shows it.
    """

    work: FlatDrawing
    shadow: Shadow

    @cached_property
    def clean(self) -> FlatDrawing:
        """The work on the picture without its shadow."""
        work, image = self.work, torch.from_numpy(self.shadow.clean)
        added = 255.0 * (work.image - image).double().numpy()
        rounding = None if work.rounding is None else ShadedRounding(work.rounding, added)
        return replace(work, image=image, may_refuse=False, is_doubtful=False, rounding=rounding)

    @cached_property
    def _picture(self) -> Tensor:
        """The picture with its shadow, as it was before it was saved as JPEG [h, w, 3]."""
        work = self.work
        if work.rounding is None:
            return work.image
        return (self.clean.picture + work.image - self.clean.image).clamp(0.0, 1.0)

    @cached_property
    def _critic(self) -> Critic:
        return Critic(self._picture, self.work.config)

    def error(self, scene: Scene) -> float:
        """Return what a drawing leaves of the picture, the root of the mean square in levels."""
        return 255.0 * float(self._critic.target.squared_error(scene).mean() / 3.0) ** 0.5

    def with_shadows(self, sharp: Scene) -> Scene | None:
        """Return ``sharp``, the drawing without the shadow, above a copy of its paths; None if they do not cast it."""
        threads = self.work.config.threads
        below = paths_below(sharp, self.shadow, threads)
        shapes = _above(sharp, below)
        if not 0 < len(shapes) <= SOFTNESS.casting_max:
            return None
        picture, shadow = self._picture.numpy(), self.shadow
        casters = DrawnCasters(picture, shapes, shadow, threads).find()
        if casters is None:
            return None
        for is_last in (*(False,) * SOFTNESS.same_rounds, True):
            shapes = _above(sharp, below)
            shadow = DrawnCasters(picture, shapes, shadow, threads).measured(casters)
            copy = soft_copy(as_one(shapes, casters), shadow)
            whole = sharp.prefix(below).joined(copy).joined(shapes)
            if is_last:
                return whole
            whole = self._fitted(whole)
            assert whole.softness is not None
            sharp = whole.select(~whole.softness.is_soft)
        return None

    def _fitted(self, scene: Scene) -> Scene:
        """Return ``scene`` with its sharp paths fitted."""
        work = self.work
        assert scene.softness is not None
        count = min(SOFTNESS.iterations, work.config.iterations)
        part = work.watch.part(planned=work.watch.iterations + count)
        target, locked = self._critic.target, scene.softness.is_soft
        return polish(target, scene, work.config, part, iterations=count, locked=locked).scene


def _above(scene: Scene, below: int) -> Scene:
    """Return ``scene`` without its ``below`` lowest paths."""
    return scene.select(torch.arange(below, len(scene)))
