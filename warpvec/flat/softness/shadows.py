"""Find the shadow or glow of what lies on a ground of a picture, or else a soft spot.

The ground has one colour or a gradient, or is transparent. A transparent picture is looked at over black and over white
at once: it has C = 6 channels here where an opaque one, and an opaque shape of a transparent one, has 3.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import chain

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats, Floats32, Mask
from warpvec.flat.connected_parts import with_filled_holes
from warpvec.flat.constants.softness import SOFTNESS
from warpvec.flat.regions.regions import Regions, find_regions
from warpvec.flat.softness.casters import Casting
from warpvec.flat.softness.grounds import Ground, find_grounds
from warpvec.flat.softness.shadow_fitting import FoundShadow, Zone
from warpvec.flat.softness.spots import find_spot
from warpvec.image.alpha import from_mattes, is_transparent, over_mattes
from warpvec.image.spread import largest_channel
from warpvec.svg.quantize import OPACITY_DECIMALS


@dataclass(frozen=True)
class Shadow:
    """A shadow, a glow or a soft spot.

    Attributes:
        casters: coverage of what casts it [h, w], in [0, 1]; of the spot itself if nothing does.
        ground: what it lies on.
        look: how it is moved, blurred and painted.
        is_cast: whether shapes of the drawing cast it. Nothing casts a soft spot.
        clean: the picture without it [h, w, 3 or 4].
    """

    casters: Floats
    ground: Ground
    look: FoundShadow
    is_cast: bool
    clean: Floats32

    @property
    def paint(self) -> tuple[Floats, float]:
        """The colour [3] and the opacity that look like this on the ground.

        On an opaque one of one colour many do; they are the most extreme colour that can be, and the least opacity.
        """
        ground, amplitude = self.ground.color / 255.0, self.look.amplitude / 255.0
        if len(amplitude) > 3:
            black, white = amplitude[:3], amplitude[3:]
            opacity = float(np.clip((black - white).mean(), 0.0, 1.0))
            return np.clip(black / max(opacity, 1e-6), 0.0, 1.0), opacity
        room = np.where(amplitude < 0.0, ground, 1.0 - ground)
        least = float((np.abs(amplitude) / np.maximum(room, 1e-6)).max())
        opacity = float(np.clip(max(least, self.look.opacity), 0.0, 1.0))
        opacity = math.ceil(opacity * 10**OPACITY_DECIMALS - 1e-6) / 10**OPACITY_DECIMALS  # the colour makes up for it
        return np.clip(ground + amplitude / max(opacity, 1e-6), 0.0, 1.0), opacity


def _never() -> bool:
    return False


def find_shadows(
    image: Floats32, regions: Regions | None = None, is_time_up: Callable[[], bool] = _never, is_jpeg: bool = False
) -> list[Shadow]:
    """Return the shadows of a picture; each is found in the picture without those before it.

    Args:
        image: [h, w, 3 or 4], sRGB-encoded in [0, 1], with straight alpha.
        regions: a rough tracing of it, with its shadows; None to make one.
        is_time_up: whether the search is to end.
        is_jpeg: whether the picture was saved as JPEG.
    """
    traced = find_regions(image) if regions is None else regions
    found: list[Shadow] = []
    if len(traced) > SOFTNESS.regions_max:
        return found
    for ground in find_grounds(255.0 * channels_of(image), traced, is_jpeg):
        is_more = True
        while is_more and len(found) < SOFTNESS.shadows_max and not is_time_up():
            shadow = _shadow_on(ground, found[-1].clean if found else image, traced, is_time_up)
            is_more = shadow is not None
            if shadow is not None:
                found.append(shadow)
    return found


def _shadow_on(ground: Ground, image: Floats32, regions: Regions, is_time_up: Callable[[], bool]) -> Shadow | None:
    """Return the shadow or the soft spot on a ``ground``, or on a part of it; None without one."""
    levels = 255.0 * channels_of(image, len(ground.color))
    ground = ground.after(levels)
    soft = ground.is_open & ~ground.is_seen
    if soft.sum() < SOFTNESS.zone_area:
        return None
    shapes = ndimage.label(ndimage.binary_dilation(ground.pieces > 0, iterations=2), np.ones((3, 3)))[0]
    for part in chain([ground], ground.parts(soft, ground.things), ground.parts(soft, shapes.astype(np.int32))):
        if is_time_up():
            return None
        light = _light_on(part, levels, regions)
        if light is not None:
            part, cast, look, is_cast = light
            return Shadow(cast, part, look, is_cast, _cleaned(image, levels, part, regions, cast, look))
    return None


def _light_on(ground: Ground, levels: Floats, regions: Regions) -> tuple[Ground, Floats, FoundShadow, bool] | None:
    """Return the ``ground``, the coverage of what casts the light on it [h, w], its fit, and whether shapes cast it."""
    if (ground.is_open & ~ground.is_seen).sum() < SOFTNESS.zone_area:
        return None
    casting = Casting(ground, levels - ground.below, regions)
    if casting.everything:
        cast = casting.best(SOFTNESS.part_unexplained if ground.is_part else SOFTNESS.coarse_unexplained)
        if cast is not None and _is_soft(ground, cast[2]):
            return cast[0].ground, *cast[1:], True
    spot = _spot(levels, ground)
    return (ground, *spot, False) if spot is not None and _is_soft(ground, spot[1]) else None


def _cleaned(
    image: Floats32, levels: Floats, ground: Ground, regions: Regions, cast: Floats, look: FoundShadow
) -> Floats32:
    """Return an ``image`` [h, w, 3 or 4] without a shadow: its ``levels`` [h, w, C] over the ground less what it adds."""
    clean = np.clip(_unshaded(levels, ground, regions, cast, look), 0.0, 255.0) / 255.0
    if clean.shape[2] > 3:
        return from_mattes(clean).astype(np.float32)
    if is_transparent(image):
        clean = np.where(ground.region[..., None], np.dstack([clean, image[..., 3]]), image)
    return clean.astype(np.float32)


def _spot(levels: Floats, ground: Ground) -> tuple[Floats, FoundShadow] | None:
    """Return the sharp coverage of a soft spot of the ground [h, w], and its fit; None without a spot.

    What the first fit is far from lies above the spot, if it is little: parts of a thin outline are no pieces.
    """
    is_open, change = ground.is_open, levels - ground.below
    most = SOFTNESS.spot_part_unexplained if ground.is_part else SOFTNESS.spot_unexplained
    for _ in range(SOFTNESS.spot_rounds):
        spot = find_spot(Zone(change, ground.deviation, is_open))
        if spot is None or spot[1].unexplained <= most:
            return spot
        rest = largest_channel(np.abs(change - spot[1].shade_of(spot[0], ground.deviation)))
        is_off = is_open & (rest > SOFTNESS.jump)
        if is_off.sum() > SOFTNESS.spot_off * (is_open & ~ground.is_seen).sum():
            return None
        is_open = is_open & ~with_filled_holes(is_off)
    return None


def _is_soft(ground: Ground, found: FoundShadow) -> bool:
    """Return whether a fit explains what is seen, is blurred, shows, has room, and a colour that can be painted."""
    is_seen = bool(np.abs(found.amplitude).max() >= SOFTNESS.amplitude_min)
    opaque = ground.color + found.amplitude
    can_be = bool(opaque.min() >= -SOFTNESS.jump and opaque.max() <= 255.0 + SOFTNESS.jump)
    has_room = bool(ground.region.sum() >= SOFTNESS.room * found.sigma**2)
    is_explained = found.unexplained <= SOFTNESS.unexplained
    return found.sigma >= SOFTNESS.sigma_min and is_seen and can_be and has_room and is_explained


def _unshaded(levels: Floats, ground: Ground, regions: Regions, cast: Floats, found: FoundShadow) -> Floats:
    """Return the picture without the shadow of a coverage ``cast`` [h, w], below the pieces on the ground, in levels."""
    above = (ground.pieces > 0) | ~ground.region
    shade = found.shade_of(cast, ground.deviation)
    near = ndimage.binary_dilation(above, iterations=2)
    clean = np.where(above[..., None], levels, levels - shade)
    # Only edges that the ground reaches are mixed with it; those of letters on a card are mixed of other colours.
    edge = near & ground.region & ndimage.binary_dilation(ground.is_open, iterations=3)
    pure = ndimage.binary_erosion(above, border_value=1) if ndimage.binary_erosion(above).any() else above
    clean[edge] = _mixed_again(levels, ground.below, shade, pure, edge)
    # Two shadows that overlap are a little less than the shadow of both shapes together.
    alike = 2.0 * ground.alike + SOFTNESS.overlapping * largest_channel(np.abs(shade))
    is_alike = largest_channel(np.abs(clean - ground.below)) <= alike
    clear = ~near & ground.region & (ground.is_seen | is_alike)
    if ground.noise < 0.3:
        clean[clear] = ground.below[clear]
    return clean


def channels_of(image: Floats32, count: int | None = None) -> Floats:
    """Return ``image`` [h, w, 3 or 4] as it is, or over black and white if it is transparent [h, w, C].

    If a ``count`` of 3 channels is asked for, a transparent one is over black alone.
    """
    channels: Floats = over_mattes(image).astype(np.float64)
    return channels[..., :count]


def _mixed_again(levels: Floats, below: Floats, shade: Floats, pure: Mask, edge: Mask) -> Floats:
    """Return the colours of the pixels at an ``edge`` [K, C] by their mix of the nearest ``pure`` one and ``below``."""
    _, (y, x) = ndimage.distance_transform_edt(~pure, return_indices=True)
    own, beside = levels[y, x][edge], (below + shade)[edge]
    share = share_of(levels[edge], own, beside)[:, None]
    mixed: Floats = share * own + (1.0 - share) * below[edge]
    return mixed


def share_of(mixed: Floats, own: Floats, beside: Floats) -> Floats:
    """Return the share [...] of a colour ``own`` in ``mixed`` ones, beside another [..., C], in levels."""
    span = own - beside
    share: Floats = ((mixed - beside) * span).sum(-1) / np.maximum((span * span).sum(-1), 1.0)
    return np.clip(share, 0.0, 1.0)
