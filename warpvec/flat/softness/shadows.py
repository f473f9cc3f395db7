"""Find the shadow or glow of what lies on the flat ground of a picture, or else a soft spot.

The *casters* are the plateaus of one colour with sharp edges. The *soft zone* is what is neither ground nor caster. A
shadow is the mask of the casters, moved by (dx, dy) and blurred by sigma, times an amplitude in each channel. Moves and
blur are fitted by damped Gauss-Newton steps; the amplitude follows by least squares.

The ground may be transparent. Such a picture is looked at over black and over white at once: it has C = 6 channels here
where an opaque one has 3.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from warpvec.arrays import Floats, Floats32, Mask
from warpvec.flat.connected_parts import with_filled_holes
from warpvec.flat.constants.softness import SOFTNESS
from warpvec.flat.softness.shadow_fitting import FoundShadow, fit_shadow, moved_blur, shade_of
from warpvec.flat.softness.spots import find_spot
from warpvec.image.alpha import from_mattes, is_transparent, over_mattes
from warpvec.svg.quantize import OPACITY_DECIMALS


@dataclass(frozen=True)
class Shadow:
    """A shadow, a glow or a soft spot.

    Attributes:
        casters: coverage of what casts it [h, w], in [0, 1]; of the spot itself if nothing does.
        ground: colour of what it lies on [C], sRGB-encoded in [0, 1].
        amplitude: what it adds to the ground in each channel [C]; negative for a shadow.
        offset: how far it is moved to the right and down, in pixels.
        sigma: its standard deviation in pixels.
        is_cast: whether shapes of the drawing cast it; else it is a spot that only looks like a soft one.
        clean: the picture without it [h, w, 3 or 4].
    """

    casters: Floats
    ground: Floats
    amplitude: Floats
    offset: tuple[float, float]
    sigma: float
    is_cast: bool
    clean: Floats32

    @property
    def paint(self) -> tuple[Floats, float]:
        """The colour [3] and the opacity that look like this on the ground.

        On an opaque one many do; they are the most extreme colour that can be, and the least opacity.
        """
        if len(self.amplitude) > 3:
            black, white = self.amplitude[:3], self.amplitude[3:]
            opacity = float(np.clip((black - white).mean(), 0.0, 1.0))
            return np.clip(black / max(opacity, 1e-6), 0.0, 1.0), opacity
        room = np.where(self.amplitude < 0.0, self.ground, 1.0 - self.ground)
        opacity = float(np.clip((np.abs(self.amplitude) / np.maximum(room, 1e-6)).max(), 0.0, 1.0))
        opacity = math.ceil(opacity * 10**OPACITY_DECIMALS - 1e-6) / 10**OPACITY_DECIMALS  # the colour makes up for it
        return np.clip(self.ground + self.amplitude / max(opacity, 1e-6), 0.0, 1.0), opacity


def find_shadow(image: Floats32) -> Shadow | None:
    """Return the shadow of ``image`` [h, w, 3 or 4], sRGB-encoded, with straight alpha, in [0, 1]; None without one."""
    if is_transparent(image) and not _has_soft_alpha(image[..., 3]):
        return None
    levels = 255.0 * channels_of(image)
    plateaus, count = _plateaus(levels)
    ground = _ground(levels, plateaus, count)
    if ground is None or count > SOFTNESS.spot_plateaus_max:
        return None
    color = np.median(levels[plateaus == ground], axis=0)
    is_ground = np.abs(levels - color).max(2) <= SOFTNESS.alike
    casters = _casters(levels, plateaus, count, ground, is_ground)
    shadow = None
    if casters is not None and count <= SOFTNESS.plateaus_max:
        shadow = _shadow_of(levels, casters, plateaus, color, is_ground)
    found = shadow or _spot(levels - color, casters)
    if found is None:
        return None
    casters, cast, (offset, sigma, amplitude, _) = found
    near = ndimage.binary_dilation(casters, iterations=2)
    shade = shade_of(cast, found[2])
    covered = _coverage(levels, casters, near, color + shade)
    # Nothing else is on the ground, or it is no part of the shadow and stays.
    clean = levels - (1.0 - covered[..., None]) * shade
    edge = near & ~casters
    clean[edge] = _unshaded(levels, color, shade, casters & (plateaus > 0), edge)
    clean[~near & (is_ground | (np.abs(clean - color).max(2) <= 3.0 * SOFTNESS.alike))] = color
    clean = np.clip(clean, 0.0, 255.0) / 255.0
    cleaned: Floats32 = (from_mattes(clean) if is_transparent(image) else clean).astype(np.float32)
    return Shadow(cast, color / 255.0, amplitude / 255.0, offset, sigma, shadow is not None, cleaned)


def _spot(change: Floats, casters: Mask | None) -> tuple[Mask, Floats, FoundShadow] | None:
    """Return what lies above a soft spot of the ground [h, w], the sharp coverage of the spot [h, w], and its fit.

    None without one.
    """
    whole = np.zeros(change.shape[:2], np.bool_) if casters is None else with_filled_holes(casters)
    spot = find_spot(change, ~ndimage.binary_dilation(whole, iterations=2))
    return (whole, *spot) if spot is not None and _is_soft(spot[1]) else None


def _is_soft(found: FoundShadow) -> bool:
    """Return whether a fit explains what is seen, is blurred, and shows."""
    _, sigma, amplitude, unexplained = found
    is_seen = bool(np.abs(amplitude).max() >= SOFTNESS.amplitude_min)
    return sigma >= SOFTNESS.sigma_min and is_seen and unexplained <= SOFTNESS.unexplained


def _has_soft_alpha(alpha: Floats32) -> bool:
    """Return whether ``alpha`` [h, w] is between 0 and 1 in wider areas than anti-aliased edges."""
    inner = ndimage.binary_erosion((alpha > 0.0) & (alpha < 1.0), np.ones((3, 3)))
    return bool(inner.sum() >= SOFTNESS.inner_area)


def channels_of(image: Floats32) -> Floats:
    """Return ``image`` [h, w, 3 or 4] as it is, or over black and white if it is transparent [h, w, C]."""
    channels: Floats = over_mattes(image).astype(np.float64)
    return channels


def _shadow_of(
    levels: Floats, casters: Mask, plateaus: NDArray[np.int32], color: Floats, is_ground: Mask
) -> tuple[Mask, Floats, FoundShadow] | None:
    """Return what casts a shadow [h, w], its coverage [h, w] and the shadow, fitted in rounds; None without one."""
    found = _cast(levels, casters, color, is_ground)
    bare = np.zeros_like(casters)
    for _ in range(SOFTNESS.rounds):
        if found is None:
            return None
        more = bare | _bare(levels - color, casters & ~bare, found)
        is_same, bare = not (more & ~bare).any(), more
        # Even parts of a shadow that lie between two shapes look like a shape with sharp edges.
        real = _without_shaded(levels - color, casters, plateaus, found)
        again = _cast(levels, casters if real is None else real, color, is_ground, found, bare)
        if real is not None and (again is None or again[1][3] > SOFTNESS.unexplained):
            # A shape has the colour of the shadow below it, by chance.
            real, again = None, _cast(levels, casters, color, is_ground, found, bare)
        casters = casters if real is None else real
        # The edges of the shapes are known better with the shadow.
        is_settled = again is not None and abs(np.log(again[1][1] / found[1][1])) < SOFTNESS.settled
        found = again
        if real is None and is_settled and is_same:
            break
    return (casters, *found) if found is not None and _is_soft(found[1]) else None


def _cast(
    levels: Floats,
    casters: Mask,
    color: Floats,
    is_ground: Mask,
    rough: tuple[Floats, FoundShadow] | None = None,
    bare: Mask | None = None,
) -> tuple[Floats, FoundShadow] | None:
    """Return the coverage [h, w] of what casts a shadow, and the shadow that fits best; None without a soft zone.

    Args:
        levels: the picture [h, w, C].
        casters: pixels of shapes with sharp edges [h, w].
        color: the ground [C], in levels.
        is_ground: where the picture shows it [h, w].
        rough: a shadow that is nearly right; None to look for it in a small copy alone.
        bare: pixels of shapes that cast none [h, w]; None if all do.
    """
    near = ndimage.binary_dilation(casters, iterations=2)
    if (~is_ground & ~near).sum() < SOFTNESS.zone_area:
        return None
    covered = _coverage(levels, casters, near, None if rough is None else color + shade_of(*rough))
    whole = casters | _painted_holes(casters, near, is_ground)
    masks = [(covered, ~near)]
    if (whole & ~casters).any():
        masks.append((np.where(whole, 1.0, covered), ~near & ~whole))
    if bare is not None:
        masks = [(np.where(bare, 0.0, mask), is_seen) for mask, is_seen in masks]
    begin = None if rough is None else rough[1]
    tried = [(mask, fit_shadow(levels - color, mask, is_seen, begin)) for mask, is_seen in masks]
    fits = [(mask, fit) for mask, fit in tried if fit is not None]
    return min(fits, key=lambda each: each[1][3]) if fits else None


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
    cast, (offset, sigma, amplitude, _) = found
    near = ndimage.binary_dilation(casters, iterations=2)
    labels, count = ndimage.label(near, np.ones((3, 3)))
    bare = np.zeros_like(casters)
    if not 1 < count <= SOFTNESS.shapes_max:
        return bare
    whole, strength = moved_blur(cast, offset, sigma), float(np.abs(amplitude).max())
    for number in range(1, count + 1):
        own = moved_blur(np.where(labels == number, cast, 0.0), offset, sigma)
        alone = ~near & (own > SOFTNESS.alone * whole) & (own * strength > SOFTNESS.amplitude_min)
        expected = own[alone][:, None] * amplitude
        seen = float((change[alone] * expected).sum())
        if alone.sum() >= SOFTNESS.plateau_area and seen < SOFTNESS.seen_min * float((expected * expected).sum()):
            bare |= labels == number
    return bare if not bare[near].all() else np.zeros_like(casters)


def _without_shaded(
    change: Floats, casters: Mask, plateaus: NDArray[np.int32], found: tuple[Floats, FoundShadow]
) -> Mask | None:
    """Return the ``casters`` [h, w] without the plateaus that are as dark as the shadow there; None if all are real.

    The shadow is that of the other ones: what belongs to it casts none.
    """
    numbers = np.unique(plateaus[casters & (plateaus > 0)])
    nearest = ndimage.distance_transform_edt(plateaus == 0, return_distances=False, return_indices=True)
    owner = plateaus[tuple(nearest)]
    like = numbers[_is_like_shade(change, plateaus, numbers, found[1][2])]
    others = np.where(casters & np.isin(owner, like), 0.0, found[0])
    rest = np.abs(change - shade_of(others, found[1])).max(2)
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


def _plateaus(levels: Floats) -> tuple[NDArray[np.int32], int]:
    """Return the areas of one colour [h, w], numbered from 1 (0: none), and their number."""
    spread = ndimage.maximum_filter(levels, (3, 3, 1)) - ndimage.minimum_filter(levels, (3, 3, 1))
    core = spread.max(2) <= SOFTNESS.alike
    labels, count = ndimage.label(core)
    return labels.astype(np.int32), int(count)


def _ground(levels: Floats, plateaus: NDArray[np.int32], count: int) -> int | None:
    """Return the plateau that a shadow may lie on: the largest that reaches the border of the picture."""
    sizes = np.bincount(plateaus.ravel(), minlength=count + 1)
    rim = np.concatenate([plateaus[0], plateaus[-1], plateaus[:, 0], plateaus[:, -1]])
    outer = np.unique(rim[rim > 0])
    if not len(outer):
        return None
    best = int(outer[np.argmax(sizes[outer])])
    return best if sizes[best] >= SOFTNESS.ground_share * plateaus.size else None


def _casters(levels: Floats, plateaus: NDArray[np.int32], count: int, ground: int, is_ground: Mask) -> Mask | None:
    """Return the pixels of the plateaus with sharp edges [h, w]; None if there are none."""
    found = np.zeros(plateaus.shape, np.bool_)
    sizes = np.bincount(plateaus.ravel(), minlength=count + 1)
    boxes = ndimage.find_objects(plateaus)
    for number in range(1, count + 1):
        if number == ground or sizes[number] < SOFTNESS.plateau_area:
            continue
        rows, columns = (slice(max(part.start - 6, 0), part.stop + 6) for part in boxes[number - 1])
        own = plateaus[rows, columns] == number
        part = levels[rows, columns]
        color = np.median(part[own], axis=0)
        is_like = np.abs(part - color).max(2) <= 2.0 * SOFTNESS.alike
        whole = ndimage.binary_propagation(own, mask=is_like)
        away = ndimage.distance_transform_edt(~whole)
        change = np.abs(part - color).max(2)
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
    return (found | closed) & ~is_ground


def _coverage(levels: Floats, casters: Mask, near: Mask, shaded: Floats | None) -> Floats:
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
        is_shade = np.abs(beside - shaded[v, u]).max(2) < SOFTNESS.jump
        beside = np.where(is_shade[..., None], shaded, beside)
    span = own - beside
    share = ((levels - beside) * span).sum(2) / np.maximum((span * span).sum(2), 1.0)
    return np.where(casters, 1.0, np.where(near, np.clip(share, 0.0, 1.0), 0.0))


def _unshaded(levels: Floats, ground: Floats, shade: Floats, pure: Mask, edge: Mask) -> Floats:
    """Return the colours of the pixels at an ``edge`` [K, C] as they mix the nearest ``pure`` colour and the ground."""
    _, (y, x) = ndimage.distance_transform_edt(~pure, return_indices=True)
    own, beside = levels[y, x][edge], (ground + shade)[edge]
    span = own - beside
    share = ((levels[edge] - beside) * span).sum(1) / np.maximum((span * span).sum(1), 1.0)
    share = np.clip(share, 0.0, 1.0)[:, None]
    mixed: Floats = share * own + (1.0 - share) * ground
    return mixed
