"""Find which pieces of a tracing cast a shadow on a ground, and that shadow.

A shadow is the union of some pieces, moved by (dx, dy) and blurred by sigma, times an amplitude in each channel. What
another shape hides of a piece casts it too: the hull of the pieces tells how far it goes on there.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw
from scipy import ndimage

from warpvec.arrays import Floats, Mask
from warpvec.flat.constants.softness import SOFTNESS
from warpvec.flat.regions.regions import Regions
from warpvec.flat.softness.shadow_fitting import FoundShadow, Zone, explained, fit_shadow, moved_blur, rough_loss
from warpvec.flat.softness.traced_grounds import TracedGround, borders, painted
from warpvec.flat.softness.unshading import share_of
from warpvec.image.spread import largest_channel


@dataclass(frozen=True)
class Casting:
    """The pieces of a tracing on a ground, any of which may cast a shadow.

    Attributes:
        ground: what they lie on.
        change: the picture minus the ground, in levels [h, w, C].
        regions: the tracing.
    """

    ground: TracedGround
    change: Floats
    regions: Regions

    @cached_property
    def numbers(self) -> list[int]:
        """The pieces that are large enough to be asked, the largest first."""
        sizes = np.bincount(self.ground.pieces.ravel())
        sizes[0] = 0
        large = np.flatnonzero(sizes >= SOFTNESS.piece_area)
        return [int(k) for k in large[np.argsort(-sizes[large], kind="stable")]][: SOFTNESS.shapes_max]

    @cached_property
    def everything(self) -> frozenset[int]:
        """All pieces."""
        return frozenset(np.unique(self.ground.pieces).tolist()) - {0}

    def mask(self, chosen: frozenset[int]) -> Floats:
        """Return the coverage [h, w] of the ``chosen`` pieces, with what other pieces hide of them."""
        pieces = self.ground.pieces
        own = _among(chosen, pieces)
        # The rest of a pixel at an edge belongs to the neighbour.
        edge = ndimage.maximum_filter(own, 3) & self._is_mixed
        other_in = edge & ~own & (pieces == 0) & _among(np.unique(self.regions.label[own]), self.regions.other)
        covered = np.where(own, 1.0, 0.0)
        covered = np.where(own & edge & self._beside_open, self.regions.share, covered)
        covered = np.where(other_in, 1.0 - self.regions.share.astype(np.float64), covered)
        if len(chosen) < len(self.everything):
            for number in chosen:
                covered[self._hidden(number) & ~own] = 1.0
        return covered

    @cached_property
    def _is_mixed(self) -> Mask:
        return np.asarray(self.regions.share < 1.0)

    @cached_property
    def _beside_open(self) -> Mask:
        return np.asarray(ndimage.binary_dilation(self.ground.pieces == 0))

    def _hidden(self, number: int) -> Mask:
        """Return the pixels of all pieces in the hull of one [h, w]."""
        if number not in self._hulls:
            self._hulls[number] = _hull(self.ground.pieces == number) & (self.ground.pieces > 0)
        return self._hulls[number]

    @cached_property
    def _hulls(self) -> dict[int, Mask]:
        return {}

    def slabs_beside(self, number: int) -> frozenset[int]:
        """Return the smaller pieces between one piece and the ground: the tracing may have made them of its shadow."""
        first, second, _ = self._borders
        met = np.bincount(first, minlength=len(self._sizes))
        beside = np.bincount(first[second == number], minlength=len(met))
        on_ground = np.bincount(first[self.ground_like[second]], minlength=len(met))
        least = SOFTNESS.slab_border * met
        is_slab = (beside >= least) & (on_ground >= least) & (met > 0) & (2 * self._sizes < self._sizes[number])
        return frozenset(np.flatnonzero(is_slab).tolist()) & self.everything

    @cached_property
    def _sizes(self) -> NDArray[np.int64]:
        return np.bincount(self.ground.pieces.ravel())

    @cached_property
    def ground_like(self) -> Mask:
        """Whether each number [P] stands for the ground, and for no piece on it."""
        found = self._sizes == 0
        found[0] = True
        return np.asarray(found)

    @cached_property
    def _borders(self) -> tuple[NDArray[np.int32], NDArray[np.int32], Mask]:
        pieces = self.ground.pieces + 1  # the ground has a number too
        first, second, marked = borders(pieces, self.ground.is_open)
        return first - 1, second - 1, marked

    def exact_mask(self, chosen: frozenset[int], look: FoundShadow, cast: Floats | None = None) -> Floats:
        """Return what `mask` does, with edges by how their colours are mixed of the pieces and of the shaded ground.

        The shadow is that of a coverage ``cast`` [h, w], or else of the ``chosen`` pieces. A JPEG spreads the colours
        at an edge beyond it, so there the tracing knows the edges better.
        """
        exact = self.mask(chosen)
        if self.ground.is_jpeg:
            return exact
        near, own, is_pure = self._edges
        shade = look.shade_of(exact if cast is None else cast, self.ground.deviation)
        is_own = near & ndimage.binary_dilation(np.isin(self.ground.pieces, list(chosen)) & is_pure, np.ones((3, 3)))
        exact[near] = np.where(is_own[near], share_of(self.change[near], own, shade[near]), 0.0)
        return np.asarray(exact)

    @cached_property
    def _edges(self) -> tuple[Mask, Floats, Mask]:
        """The pixels between pieces and the open ground [h, w], the colour of a piece there [K, C], and pure pixels.

        Colours are those that the paint of the nearest piece adds to the ground. Pixels [h, w] are pure if they have
        it; a shadow beside the piece may have been taken for a part of it. Pieces without pure pixels have no edges.
        """
        pieces = self.ground.pieces
        _, (y, x) = ndimage.distance_transform_edt(pieces == 0, return_indices=True)
        own = painted(self.regions, self.regions.label[y, x])[..., : self.change.shape[2]] - self.ground.below
        is_pure = (pieces > 0) & (largest_channel(np.abs(self.change - own)) <= self.ground.alike)
        has_pure = np.bincount(pieces.ravel(), is_pure.ravel()) > 0
        beside = ndimage.binary_dilation(self.ground.is_open, iterations=4)
        near = beside & ndimage.binary_dilation(pieces > 0, iterations=2) & ~is_pure & has_pure[pieces[y, x]]
        return near, own[near], is_pure

    def within(self, cast: Floats) -> frozenset[int]:
        """Return the pieces that lie mostly in a coverage ``cast`` [h, w]."""
        inside = np.bincount(self.ground.pieces.ravel(), cast.ravel(), len(self._sizes))
        return frozenset(np.flatnonzero(2.0 * inside > self._sizes).tolist()) & self.everything

    def best(self) -> tuple[Casting, frozenset[int], FoundShadow] | None:
        """Return the pieces that cast the shadow that fits best, and it; None if none does.

        With it comes the casting in which slabs of the shadow are no pieces.
        """
        found = self._rough()
        for number in self.numbers[: SOFTNESS.starts_max]:
            slabs = self.slabs_beside(number)
            if slabs and (found is None or found[2].unexplained > SOFTNESS.well_explained):
                again = replace(self, ground=self.ground.opened(slabs))._rough()
                if again is not None and (found is None or again[2].unexplained < found[2].unexplained):
                    found = again
        if found is None or found[2].unexplained > SOFTNESS.coarse_unexplained:
            return None
        settled = found[0].settled(*found[1:])
        if settled is None:
            return None
        return found[0].finished(*settled) or (found[0], *settled)

    def finished(self, chosen: frozenset[int], look: FoundShadow) -> tuple[Casting, frozenset[int], FoundShadow] | None:
        """Return what `best` does, from ``chosen`` pieces and a ``look`` on; None if they cast no shadow."""
        slabs = self._shaded(chosen, look)
        opened = replace(self, ground=self.ground.opened(slabs)) if slabs else self
        settled = opened.settled(chosen - slabs, look)
        return None if settled is None else (opened, *settled)

    def _rough(self) -> tuple[Casting, frozenset[int], FoundShadow] | None:
        """Return the pieces whose shadow fits best in a small copy, of all together and each alone."""
        zone = self.ground.zone(self.change)
        masks = [(chosen, self.mask(chosen)) for chosen in self._starts()]
        masks.sort(key=lambda each: rough_loss(zone, each[1]))
        fits = [(chosen, fit_shadow(zone, mask, None, 1.0)) for chosen, mask in masks[: SOFTNESS.fits_max]]
        tried = [(self, chosen, look) for chosen, look in fits if look is not None]
        return min(tried, key=lambda each: each[2].unexplained) if tried else None

    def settled(self, chosen: frozenset[int], look: FoundShadow) -> tuple[frozenset[int], FoundShadow] | None:
        """Return the pieces that cast the shadow best, and it, from some that nearly do; None if none do."""
        for _ in range(SOFTNESS.rounds):
            before = chosen
            chosen = self._toggled(chosen, look)
            mask = self.exact_mask(chosen, look)
            again = fit_shadow(self._trimmed(mask, look), mask, look)
            if again is None:
                return None
            is_settled, look = abs(np.log(again.sigma / look.sigma)) < SOFTNESS.settled, again
            if chosen == before and is_settled:
                break
        return chosen, look

    def _shaded(self, chosen: frozenset[int], look: FoundShadow) -> frozenset[int]:
        """Return the pieces that look like the ground in the shadow of other ``chosen`` ones: slabs of a tracing."""
        first, second, _ = self._borders
        touching = frozenset(first[np.isin(second, list(chosen)) & (first != second)].tolist())
        outer = frozenset(first[self.ground_like[second]].tolist())
        casting = chosen & outer or chosen
        shade = look.shade_of(self.mask(casting), self.ground.deviation)
        found = set[int]()
        for number in self.numbers:
            if number in casting:
                if number not in touching or len(casting) == 1:
                    continue
                others = self.mask(casting - {number})
                seen = look.shade_of(others, self.ground.deviation)
            else:
                seen = shade
            change = self.change[self.ground.pieces == number]
            off = change - seen[self.ground.pieces == number]
            energies = (float(np.median((each * each).max(1))) for each in (off, change))
            if next(energies) <= SOFTNESS.unexplained * next(energies):
                found.add(number)
        return frozenset(found)

    def _starts(self) -> Iterator[frozenset[int]]:
        yield self.everything
        if len(self.everything) > 1:
            yield from (frozenset([k]) for k in self.numbers[: SOFTNESS.starts_max])

    def _toggled(self, chosen: frozenset[int], look: FoundShadow) -> frozenset[int]:
        """Return the ``chosen`` pieces with each that helps to explain the picture, and without each that does not."""
        loss = self._loss(chosen, look)
        for number in self.numbers:
            other = chosen ^ {number}
            if other and (again := self._loss(other, look)) < SOFTNESS.better * loss:
                chosen, loss = other, again
        return chosen

    def _loss(self, chosen: frozenset[int], look: FoundShadow) -> float:
        """Return the squared error that a shadow of the ``chosen`` pieces leaves; single pixels hardly count."""
        is_open, varied = self.ground.is_open, self.ground.deviation
        seen = self.change[is_open]
        own = moved_blur(self.mask(chosen), look.offset, look.sigma)[is_open]
        left = seen - explained(own, seen, None if varied is None else varied[is_open])
        return float(np.minimum((left * left).sum(1), self._most(look) ** 2).sum())

    def _most(self, look: FoundShadow) -> float:
        """Return up to how many levels a pixel may differ from the shadow and yet show it."""
        amplitude = SOFTNESS.off_amplitude * float(np.abs(look.amplitude).max())
        return max(SOFTNESS.off_levels, amplitude, 2.0 * SOFTNESS.noises * self.ground.noise)

    def _trimmed(self, mask: Floats, look: FoundShadow) -> Zone:
        """Return the zone without what is far from the shadow, if it is little: thin things without a piece."""
        is_open = self.ground.is_open
        rest = largest_channel(np.abs(self.change - look.shade_of(mask, self.ground.deviation)))
        is_off = is_open & (rest > self._most(look))
        few = is_off.sum() <= SOFTNESS.cast_off * max(int((is_open & ~self.ground.is_seen).sum()), 1)
        return self.ground.zone(self.change, is_open & ~is_off if few else is_open)


def _among(numbers: Iterable[int], values: NDArray[np.int32]) -> Mask:
    """Return where ``values`` [h, w], from 0 on, are some of the ``numbers``: a table is faster than `numpy.isin`."""
    chosen = np.fromiter(numbers, np.intp)
    table = np.zeros(max(int(values.max()), int(chosen.max(initial=0))) + 1, np.bool_)
    table[chosen] = True
    return np.asarray(table[values])


def _hull(mask: Mask) -> Mask:
    """Return the pixels of the convex hull of ``mask`` [h, w]."""
    from scipy.spatial import ConvexHull, QhullError  # pictures without a shadow need not load it

    points = np.argwhere(mask & ~ndimage.binary_erosion(mask))
    try:
        corners = points[ConvexHull(points).vertices]
    except (QhullError, ValueError):
        return mask
    canvas = Image.new("1", mask.shape[::-1])
    ImageDraw.Draw(canvas).polygon([(int(x), int(y)) for y, x in corners], fill=1, outline=1)
    return np.asarray(canvas, np.bool_)
