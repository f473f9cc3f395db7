"""Find the shapes that cast a shadow on a ground, and that shadow.

The *casters* are the plateaus of one colour and the areas of a gradient that have sharp edges. The *soft zone* is what
is neither ground nor caster. A shadow is the mask of the casters, moved by (dx, dy) and blurred by sigma, times an
amplitude in each channel.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from warpvec.arrays import Floats, Mask
from warpvec.flat.connected_parts import with_filled_holes
from warpvec.flat.constants.softness import SOFTNESS
from warpvec.flat.softness.grounds import Ground, Parts
from warpvec.flat.softness.shadow_fitting import FoundShadow, Zone, fit_shadow, moved_blur
from warpvec.image.spread import largest_channel, spread


def find_casters(
    levels: Floats, parts: Parts, ground: Ground, is_time_up: Callable[[], bool] = lambda: False
) -> Mask | None:
    """Return the pixels of the parts on a ``ground`` with sharp edges [h, w]; None if there are none.

    Args:
        levels: the picture [h, w, C].
        parts: its plateaus and areas with a gradient.
        ground: what a shadow would lie on.
        is_time_up: whether the search is to end; the parts that are left are no casters then.
    """
    found = np.zeros(parts.number.shape, np.bool_)
    sizes = np.bincount(parts.number.ravel(), minlength=parts.count + 1)
    change = spread(levels)
    for number, box in enumerate(ndimage.find_objects(parts.number), 1):
        is_graded = number > parts.plateaus
        if is_time_up():
            break
        if box is None or sizes[number] < (SOFTNESS.zone_area if is_graded else SOFTNESS.plateau_area):
            continue
        rows, columns = (slice(max(part.start - 6, 0), part.stop + 6) for part in box)
        own = parts.number[rows, columns] == number
        is_ground = ground.is_seen[rows, columns] | ground.area[rows, columns]
        if is_ground[own].mean() > (SOFTNESS.own_share_graded if is_graded else SOFTNESS.own_share):
            continue
        away, like = _unlike_inside(levels[rows, columns], own, change[rows, columns] if is_graded else None)
        whole = ndimage.binary_propagation(own, mask=away <= like)
        if _has_sharp_edge(away, whole):
            found[rows, columns] |= whole
    if not found.any():
        return None
    # The anti-aliased edge between two sharp parts belongs to them. A shadow that they enclose does not.
    closed: Mask = ndimage.binary_closing(np.pad(found, 4))[4:-4, 4:-4]
    return (found | closed) & ~ground.is_seen & ground.region


def _unlike_inside(part: Floats, own: Mask, change: Floats | None) -> tuple[Floats, Floats]:
    """Return how far each pixel of a ``part`` [h, w, C] is from the colour of what is its ``own``, and the most [h, w].

    The second is up to which it belongs to it. That colour is the nearest one if it is known how much the colours
    ``change`` in 3 x 3 pixels [h, w]: then it is a gradient.
    """
    if change is None:
        color = np.median(part[own], axis=0)
        return largest_channel(np.abs(part - color)), np.full(own.shape, 2.0 * SOFTNESS.alike)
    far, (y, x) = ndimage.distance_transform_edt(~own, return_indices=True)
    like = np.where(far <= SOFTNESS.grown, 2.0 * SOFTNESS.alike + 0.5 * far * change[y, x], -1.0)
    return largest_channel(np.abs(part - part[y, x])), like


def _has_sharp_edge(change: Floats, whole: Mask) -> bool:
    """Return whether the ``change`` from the colour inside [h, w] is great right beside a ``whole`` area [h, w]."""
    away = ndimage.distance_transform_edt(~whole)
    first, later = change[(away > 1.5) & (away <= 2.5)], change[(away > 3.5) & (away <= 4.5)]
    if not len(first) or not len(later):
        return False
    step, rest = float(np.median(first)), abs(float(np.median(later)) - float(np.median(first)))
    return step >= SOFTNESS.jump and step >= SOFTNESS.sharpness * rest


def find_cast_shadow(
    levels: Floats, parts: Parts, ground: Ground, casters: Mask, is_time_up: Callable[[], bool]
) -> tuple[Mask, Floats, FoundShadow] | None:
    """Return what casts a shadow [h, w], its coverage [h, w] and the shadow, fitted in rounds.

    None without one, or if the time is up.

    Args:
        levels: the picture [h, w, C].
        parts: its plateaus and areas with a gradient.
        ground: what the shadow lies on.
        casters: shapes that may cast it [h, w], as `find_casters` returns them.
        is_time_up: whether the search is to end.
    """
    change = levels - ground.below
    found = _cast(levels, casters, ground)
    bare, above = np.zeros_like(casters), casters
    for _ in range(SOFTNESS.rounds):
        if found is None or is_time_up():
            return None
        # A rough shadow is far from the true one in places, so this is asked anew each time.
        above = _with_unlike(change, casters, ground, found)
        near = ndimage.binary_dilation(above, iterations=2)
        more = bare | _bare(change, above & ~bare, ground.region & ~near, found)
        is_same, bare = not (more & ~bare).any(), more
        # Even parts of a shadow that lie between two shapes look like a shape with sharp edges.
        real = _without_shaded(change, above, parts, ground, found)
        again = _cast(levels, above if real is None else real, ground, found, bare)
        if real is not None and (again is None or again[1].unexplained > SOFTNESS.unexplained):
            # A shape has the colour of the shadow below it, by chance.
            real, again = None, _cast(levels, above, ground, found, bare)
        above = above if real is None else real
        casters = casters & above
        # The edges of the shapes are known better with the shadow.
        is_settled = again is not None and abs(np.log(again[1].sigma / found[1].sigma)) < SOFTNESS.settled
        found = again
        if real is None and is_settled and is_same:
            break
    if found is None:
        return None
    marks = _marks_in(above, change, ground, found)
    return above | marks, np.where(marks, 1.0, _without_specks(found[0])), found[1]


def _marks_in(above: Mask, change: Floats, ground: Ground, found: tuple[Floats, FoundShadow]) -> Mask:
    """Return the holes [h, w] of what lies ``above`` that do not show the shadow: letters with some of its colour."""
    holes, count = ndimage.label(with_filled_holes(above) & ~above, np.ones((3, 3)))
    shade = found[1].shade_of(found[0], ground.deviation)
    is_shade = largest_channel(np.abs(change - shade)) <= SOFTNESS.jump
    share = np.bincount(holes.ravel(), is_shade.ravel(), count + 1) / np.maximum(np.bincount(holes.ravel()), 1)
    is_mark = share < SOFTNESS.hole_shade
    is_mark[0] = False
    return np.asarray(is_mark[holes])


def _without_specks(cast: Floats) -> Floats:
    """Return a coverage [h, w] without shapes and holes that are too small for a plateau: traces of thin things."""
    clean = cast.copy()
    for is_part, value in ((cast > 0.0, 0.0), (cast < 1.0, 1.0)):
        labels, count = ndimage.label(is_part, np.ones((3, 3)))
        is_small = np.bincount(labels.ravel(), minlength=count + 1) < SOFTNESS.speck_area
        is_small[0] = False
        clean[is_small[labels]] = value
    return clean


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


def _with_unlike(change: Floats, casters: Mask, ground: Ground, found: tuple[Floats, FoundShadow]) -> Mask:
    """Return the ``casters`` [h, w] with what is far from the shadow, if it is little: thin things with no plateau."""
    is_open = ground.region & ~ndimage.binary_dilation(casters, iterations=2)
    rest = largest_channel(np.abs(change - found[1].shade_of(found[0], ground.deviation)))
    most = max(SOFTNESS.off_levels, SOFTNESS.off_amplitude * float(np.abs(found[1].amplitude).max()))
    is_off = is_open & (rest > most) & ~ground.is_seen
    if not 0 < is_off.sum() <= SOFTNESS.cast_off * (is_open & ~ground.is_seen).sum():
        return casters
    # So do the anti-aliased pixels between it and the shapes.
    whole = ndimage.binary_closing(np.pad(casters | is_off, 4), iterations=2)[4:-4, 4:-4]
    return casters | (whole & ndimage.binary_dilation(is_off, iterations=3) & ground.region & ~ground.is_seen)


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


def _bare(change: Floats, casters: Mask, is_open: Mask, found: tuple[Floats, FoundShadow]) -> Mask:
    """Return the pixels of the shapes of which no shadow is seen where theirs should be [h, w].

    How strong the shadow of each is follows from all of them by least squares: those of letters overlap.

    Args:
        change: the picture minus its ground, in levels [h, w, C].
        casters: pixels of the shapes [h, w].
        is_open: where nothing covers the ground [h, w].
        found: the coverage of the shapes [h, w], and the shadow as if all of them cast it.
    """
    cast, shadow = found
    labels, count = _shapes(ndimage.binary_dilation(casters, iterations=2))
    bare = np.zeros_like(casters)
    if count <= 1:
        return bare
    energy = float(shadow.amplitude @ shadow.amplitude)
    chosen = np.flatnonzero(is_open)
    chosen = chosen[:: -(-len(chosen) // SOFTNESS.bare_samples) or 1]
    seen = (change @ shadow.amplitude / max(energy, 1e-12)).ravel()[chosen]
    alone = (np.where(labels == number, cast, 0.0) for number in range(1, count + 1))
    strengths = np.stack([moved_blur(mask, shadow.offset, shadow.sigma).ravel()[chosen] for mask in alone], 1)
    # Not by BLAS, whose sums depend on the number of threads.
    norms, products = np.einsum("ni,nj->ij", strengths, strengths), np.einsum("ni,n->i", strengths, seen)
    if not (norms.diagonal() > 0.0).any():
        return bare
    # What the picture does not tell stays: its strength is one.
    doubt = SOFTNESS.shape_doubt * norms.diagonal().max() * np.eye(count)
    shares = np.linalg.solve(norms + doubt, products + doubt.sum(1))
    most = float(np.abs(shadow.amplitude).max()) * strengths.max(0)
    is_bare = (shares < SOFTNESS.seen_min * max(float(shares.max()), 1.0)) & (most > SOFTNESS.amplitude_min)
    return bare if is_bare.all() else np.isin(labels, 1 + is_bare.nonzero()[0])


def _shapes(near: Mask) -> tuple[NDArray[np.int32], int]:
    """Return the number of the shape of each pixel of ``near`` [h, w], from 1 on, and how many shapes there are.

    If they are many, neighbours such as the letters of a word are one.
    """
    away = ndimage.distance_transform_edt(~near)
    for gap in SOFTNESS.shape_gaps:
        labels, count = ndimage.label(away <= gap, np.ones((3, 3)))
        if count <= SOFTNESS.shapes_max:
            return np.where(near, labels, 0), int(count)
    return near.astype(np.int32), 1


def _without_shaded(
    change: Floats, casters: Mask, parts: Parts, ground: Ground, found: tuple[Floats, FoundShadow]
) -> Mask | None:
    """Return the ``casters`` [h, w] without the parts that are as dark as the shadow there; None if all are real.

    The shadow is that of the other ones: what belongs to it casts none.
    """
    numbers = np.unique(parts.number[casters & (parts.number > 0)])
    nearest = ndimage.distance_transform_edt(parts.number == 0, return_distances=False, return_indices=True)
    owner = parts.number[tuple(nearest)]
    like = numbers[_is_like_shade(change, parts.number, numbers, found[1].amplitude)]
    others = np.where(casters & np.isin(owner, like), 0.0, found[0])
    rest = largest_channel(np.abs(change - found[1].shade_of(others, ground.deviation)))
    graded_error = SOFTNESS.graded_error * float(np.abs(found[1].amplitude).max())
    is_rough = (like > parts.plateaus) | (np.bincount(parts.number.ravel())[like] < SOFTNESS.plateau_area)
    error = np.where(is_rough, max(graded_error, SOFTNESS.shade_error), SOFTNESS.shade_error)
    shaded = like[ndimage.median(rest, parts.number, like) < error] if len(like) else like
    if not len(shaded) or len(shaded) == len(numbers):
        return None
    # What lies between a shape and the shadow is its anti-aliased edge, and no shape.
    real = casters & (parts.number > 0) & ~np.isin(parts.number, shaded)
    _, (y, x) = ndimage.distance_transform_edt(~real, return_indices=True)
    is_edge = (parts.number == 0) & (largest_channel(np.abs(change - change[y, x])) > SOFTNESS.jump)
    is_near = (rest < SOFTNESS.jump) | ndimage.binary_dilation(casters & np.isin(owner, shaded), iterations=3)
    return casters & ~np.isin(owner, shaded) & ~(is_edge & is_near)


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
