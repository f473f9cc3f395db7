"""Find which paths of a drawing cast a shadow: those whose moved and blurred coverage explains what is seen of it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import torch
from scipy import ndimage

from warpvec.arrays import Floats, Mask
from warpvec.flat.constants.softness import SOFTNESS
from warpvec.flat.softness.shadow_fitting import FoundShadow, Zone, explained, fit_shadow, moved_blur
from warpvec.flat.softness.shadows import Shadow, is_soft
from warpvec.flat.softness.shapes import coverage
from warpvec.geometry.scene import Scene


@dataclass(frozen=True)
class DrawnCasters:
    """The paths above a shadow, any of which may cast it.

    Attributes:
        levels: the picture [h, w, C], in levels.
        shapes: the paths.
        shadow: one that is nearly right.
        threads: of the renderer.
    """

    levels: Floats
    shapes: Scene
    shadow: Shadow
    threads: int | None

    def find(self) -> list[int] | None:
        """Return the fewest paths that explain the shadow best; None if no shadow of theirs is one.

        Several strokes cannot be one path, so they count as none.
        """
        chosen, look = self._begin(), self.shadow.look
        for _ in range(SOFTNESS.rounds):
            before, chosen = chosen, self._toggled(chosen, look)
            fitted = fit_shadow(self._zone, self._union(chosen), look) if chosen else None
            if fitted is None:
                return None
            look = fitted
            if chosen == before:
                break
        strokes = self.shapes.strokes
        is_one = len(chosen) == 1 or strokes is None or not strokes.is_stroked[sorted(chosen)].any()
        return sorted(chosen) if is_one and is_soft(self.shadow.ground, look) else None

    def measured(self, casters: list[int]) -> Shadow:
        """Return the shadow that the paths ``casters`` cast, fitted with their exact coverage."""
        height, width = self.shadow.casters.shape
        cast = coverage(self.shapes.select(torch.tensor(casters)), height, width, self.threads)
        found = fit_shadow(self._zone, cast, self.shadow.look)
        return self.shadow if found is None else replace(self.shadow, casters=cast, look=found)

    def _begin(self) -> frozenset[int]:
        """Return the paths that lie mostly in what casts the rough shadow."""
        casters = self.shadow.casters
        return frozenset(k for k, own in enumerate(self._covers) if 2.0 * (own * casters).sum() > own.sum())

    def _toggled(self, chosen: frozenset[int], look: FoundShadow) -> frozenset[int]:
        """Return the ``chosen`` paths with each that helps to explain the picture, and without each that does not."""
        loss = self._loss(chosen, look)
        region = self.shadow.ground.region
        inside = [k for k, own in enumerate(self._covers) if 2.0 * own[region].sum() > own.sum()]
        for k in sorted(inside, key=lambda k: -self._covers[k].sum()):
            other = chosen ^ {k}
            again = self._loss(other, look)
            if again < SOFTNESS.better * loss or (k in chosen and again <= loss / SOFTNESS.better):
                chosen, loss = other, again
        return chosen

    def _loss(self, chosen: frozenset[int], look: FoundShadow) -> float:
        """Return the squared error that a shadow of the ``chosen`` paths leaves."""
        seen, varied = self._zone.pixels
        own = moved_blur(self._union(chosen), look.offset, look.sigma)[self._zone.is_seen]
        return float(((seen - explained(own, seen, varied)) ** 2).sum())

    def _union(self, chosen: frozenset[int]) -> Floats:
        """Return the coverage of the ``chosen`` paths [h, w], nearly right at edges that two of them share."""
        whole = np.zeros_like(self.shadow.casters)
        for k in chosen:
            whole += self._covers[k]
        return np.minimum(whole, 1.0)

    @cached_property
    def _covers(self) -> list[Floats]:
        """The coverage of each path [h, w]."""
        height, width = self.shadow.casters.shape
        rows = range(len(self.shapes))
        return [coverage(self.shapes.select(torch.tensor([k])), height, width, self.threads) for k in rows]

    @cached_property
    def _zone(self) -> Zone:
        """What the picture adds to the ground where no path covers it."""
        ground, (height, width) = self.shadow.ground, self.shadow.casters.shape
        covered: Mask = coverage(self.shapes, height, width, self.threads) > SOFTNESS.covered_min
        is_seen = ~ndimage.binary_dilation(covered) & ground.region
        return Zone(self.levels[..., : ground.below.shape[2]] - ground.below, ground.deviation, is_seen)
