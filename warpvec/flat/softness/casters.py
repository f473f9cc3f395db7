"""Find the shapes that cast a shadow on a ground, and that shadow.

The *casters* are the plateaus of one colour with sharp edges. The *soft zone* is what is neither ground nor caster. A
shadow is the mask of the casters, moved by (dx, dy) and blurred by sigma, times an amplitude in each channel.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from warpvec.arrays import Floats, Mask
from warpvec.flat.connected_parts import with_filled_holes
from warpvec.flat.constants.softness import SOFTNESS
from warpvec.flat.softness.grounds import Ground
from warpvec.flat.softness.shadow_fitting import FoundShadow, Zone, fit_shadow, moved_blur
from warpvec.image.spread import largest_channel


def find_casters(levels: Floats, plateaus: NDArray[np.int32], count: int, ground: Ground) -> Mask | None:
    """Return the pixels of the plateaus on a ``ground`` with sharp edges [h, w]; None if there are none.

    Args:
        levels: the picture [h, w, C].
        plateaus: numbers of its ``count`` plateaus, from 1 [h, w]; 0 for none.
        count: how many there are.
        ground: what a shadow would lie on.
    """
    found = np.zeros(plateaus.shape, np.bool_)
    sizes = np.bincount(plateaus.ravel(), minlength=count + 1)
    boxes = ndimage.find_objects(plateaus)
    for number in range(1, count + 1):
        if sizes[number] < SOFTNESS.plateau_area:
            continue
        rows, columns = (slice(max(part.start - 6, 0), part.stop + 6) for part in boxes[number - 1])
        own = plateaus[rows, columns] == number
        is_ground = ground.is_seen[rows, columns] | ground.area[rows, columns]
        if is_ground[own].mean() > SOFTNESS.own_share:
            continue
        part = levels[rows, columns]
        color = np.median(part[own], axis=0)
        is_like = largest_channel(np.abs(part - color)) <= 2.0 * SOFTNESS.alike
        whole = ndimage.binary_propagation(own, mask=is_like)
        away = ndimage.distance_transform_edt(~whole)
        change = largest_channel(np.abs(part - color))
        first, later = change[(away > 1.5) & (away <= 2.5)], change[(away > 3.5) & (away <= 4.5)]
        if not len(first) or not len(later):
            continue
        step, rest = float(np.median(first)), abs(float(np.median(later)) - float(np.median(first)))
        if step >= SOFTNESS.jump and step >= SOFTNESS.sharpness * rest:
            found[rows, columns] |= whole
    if not found.any():
        return None
    # The anti-aliased edge between two sharp parts belongs to them. A shadow that they enclose does not.
    closed: Mask = ndimage.binary_closing(np.pad(found, 4))[4:-4, 4:-4]
    return (found | closed) & ~ground.is_seen & ground.region


def find_cast_shadow(
    levels: Floats, plateaus: NDArray[np.int32], ground: Ground, casters: Mask, is_time_up: Callable[[], bool]
) -> tuple[Mask, Floats, FoundShadow] | None:
    """Return what casts a shadow [h, w], its coverage [h, w] and the shadow, fitted in rounds.

    None without one, or if the time is up.

    Args:
        levels: the picture [h, w, C].
        plateaus: numbers of its plateaus [h, w]; 0 for none.
        ground: what the shadow lies on.
        casters: shapes that may cast it [h, w], as `find_casters` returns them.
        is_time_up: whether the search is to end.
    """
    change = levels - ground.below
    found = _cast(levels, casters, ground)
    bare = np.zeros_like(casters)
    for _ in range(SOFTNESS.rounds):
        if found is None or is_time_up():
            return None
        more = bare | _bare(change, casters & ~bare, found)
        is_same, bare = not (more & ~bare).any(), more
        # Even parts of a shadow that lie between two shapes look like a shape with sharp edges.
        real = _without_shaded(change, casters, plateaus, ground, found)
        again = _cast(levels, casters if real is None else real, ground, found, bare)
        if real is not None and (again is None or again[1].unexplained > SOFTNESS.unexplained):
            # A shape has the colour of the shadow below it, by chance.
            real, again = None, _cast(levels, casters, ground, found, bare)
        casters = casters if real is None else real
        # The edges of the shapes are known better with the shadow.
        is_settled = again is not None and abs(np.log(again[1].sigma / found[1].sigma)) < SOFTNESS.settled
        found = again
        if real is None and is_settled and is_same:
            break
    return None if found is None else (casters, *found)


def _cast(
    levels: Floats,
    casters: Mask,
    ground: Ground,
    rough: tuple[Floats, FoundShadow] | None = None,
    bare: Mask | None = None,
) -> tuple[Floats, FoundShadow] | None:
    """Return the coverage [h, w] of what casts a shadow, and the shadow that fits best; None without a soft zone.

    Args:
        levels: the picture [h, w, C].
        casters: pixels of shapes with sharp edges [h, w].
        ground: what the shadow lies on.
        rough: a shadow that is nearly right; None to look for it in a small copy alone.
        bare: pixels of shapes that cast none [h, w]; None if all do.
    """
    near = ndimage.binary_dilation(casters, iterations=2)
    is_bare = ground.region & ~near
    if (is_bare & ~ground.is_seen).sum() < SOFTNESS.zone_area:
        return None
    shaded = None if rough is None else ground.below + rough[1].shade_of(rough[0], ground.deviation)
    covered = coverage_of(levels, casters, near, shaded)
    whole = casters | _painted_holes(casters, near, ground.is_seen)
    masks = [(covered, is_bare)]
    if (whole & ~casters).any():
        masks.append((np.where(whole, 1.0, covered), is_bare & ~whole))
    if bare is not None:
        masks = [(np.where(bare, 0.0, mask), is_seen) for mask, is_seen in masks]
    begin = None if rough is None else rough[1]
    change = levels - ground.below
    zones = [(mask, Zone(change, ground.deviation, is_seen)) for mask, is_seen in masks]
    coarse_max = SOFTNESS.part_unexplained if ground.is_part else SOFTNESS.coarse_unexplained
    tried = [(mask, fit_shadow(zone, mask, begin, coarse_max)) for mask, zone in zones]
    fits = [(mask, fit) for mask, fit in tried if fit is not None]
    return min(fits, key=lambda each: each[1].unexplained) if fits else None


def _painted_holes(casters: Mask, near: Mask, is_ground: Mask) -> Mask:
    """Return the holes of ``casters`` that show nothing but the ground [h, w]: they may be painted, and cast a shadow.

    Through others one sees the shadow.
    """
    labels, count = ndimage.label(with_filled_holes(casters) & ~casters)
    if not count:
        return np.zeros_like(casters)
    numbers = np.arange(1, count + 1)
    inside, ground = (ndimage.sum(each, labels, numbers) for each in (~near, ~near & is_ground))
    return np.isin(labels, numbers[(inside > 0) & (ground >= SOFTNESS.painted_min * inside)])


def _bare(change: Floats, casters: Mask, found: tuple[Floats, FoundShadow]) -> Mask:
    """Return the pixels of the shapes of which no shadow is seen where theirs alone should be [h, w]."""
    cast, shadow = found
    near = ndimage.binary_dilation(casters, iterations=2)
    labels, count = ndimage.label(near, np.ones((3, 3)))
    bare = np.zeros_like(casters)
    if not 1 < count <= SOFTNESS.shapes_max:
        return bare
    whole, strength = moved_blur(cast, shadow.offset, shadow.sigma), float(np.abs(shadow.amplitude).max())
    for number in range(1, count + 1):
        own = moved_blur(np.where(labels == number, cast, 0.0), shadow.offset, shadow.sigma)
        alone = ~near & (own > SOFTNESS.alone * whole) & (own * strength > SOFTNESS.amplitude_min)
        expected = own[alone][:, None] * shadow.amplitude
        seen = float((change[alone] * expected).sum())
        if alone.sum() >= SOFTNESS.plateau_area and seen < SOFTNESS.seen_min * float((expected * expected).sum()):
            bare |= labels == number
    return bare if not bare[near].all() else np.zeros_like(casters)


def _without_shaded(
    change: Floats, casters: Mask, plateaus: NDArray[np.int32], ground: Ground, found: tuple[Floats, FoundShadow]
) -> Mask | None:
    """Return the ``casters`` [h, w] without the plateaus that are as dark as the shadow there; None if all are real.

    The shadow is that of the other ones: what belongs to it casts none.
    """
    numbers = np.unique(plateaus[casters & (plateaus > 0)])
    nearest = ndimage.distance_transform_edt(plateaus == 0, return_distances=False, return_indices=True)
    owner = plateaus[tuple(nearest)]
    like = numbers[_is_like_shade(change, plateaus, numbers, found[1].amplitude)]
    others = np.where(casters & np.isin(owner, like), 0.0, found[0])
    rest = largest_channel(np.abs(change - found[1].shade_of(others, ground.deviation)))
    shaded = like[ndimage.median(rest, plateaus, like) < SOFTNESS.shade_error] if len(like) else like
    if not len(shaded) or len(shaded) == len(numbers):
        return None
    return casters & ~np.isin(owner, shaded)


def _is_like_shade(change: Floats, plateaus: NDArray[np.int32], numbers: NDArray[np.int32], amplitude: Floats) -> Mask:
    """Return which plateaus of these ``numbers`` [K] have a colour that a shadow of this ``amplitude`` [C] may have."""
    medians = np.stack([ndimage.median(each, plateaus, numbers) for each in np.moveaxis(change, 2, 0)], 1)
    share = medians @ amplitude / max(float(amplitude @ amplitude), 1e-12)
    apart = np.abs(medians - share[:, None] * amplitude).max(1)
    is_like: Mask = (share > 0.0) & (share < 1.0 + SOFTNESS.unexplained) & (apart < SOFTNESS.jump)
    return is_like


def coverage_of(levels: Floats, casters: Mask, near: Mask, shaded: Floats | None) -> Floats:
    """Return how much of each pixel the casters cover [h, w]; of a pixel at their edge, by its colour.

    Args:
        levels: the picture [h, w, C].
        casters: pixels that they cover [h, w].
        near: these and the pixels at their edges [h, w].
        shaded: the ground with its shadow [h, w, C], which changes within a few pixels; None if that is not known.
    """
    _, (y, x) = ndimage.distance_transform_edt(~casters, return_indices=True)
    _, (v, u) = ndimage.distance_transform_edt(near, return_indices=True)
    own, beside = levels[y, x], levels[v, u]
    if shaded is not None:
        is_shade = largest_channel(np.abs(beside - shaded[v, u])) < SOFTNESS.jump
        beside = np.where(is_shade[..., None], shaded, beside)
    return np.where(casters, 1.0, np.where(near, share_of(levels, own, beside), 0.0))


def share_of(mixed: Floats, own: Floats, beside: Floats) -> Floats:
    """Return the share [...] of a colour ``own`` in ``mixed`` ones, beside another [..., C], in levels."""
    span = own - beside
    share: Floats = ((mixed - beside) * span).sum(-1) / np.maximum((span * span).sum(-1), 1.0)
    return np.clip(share, 0.0, 1.0)
