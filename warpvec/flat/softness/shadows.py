"""Find the shadow or glow of what lies on a ground of a picture, or else a soft spot.

The ground has one colour or a gradient, or is transparent. A transparent picture is looked at over black and over white
at once: it has C = 6 channels here where an opaque one, and an opaque shape of a transparent one, has 3.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from hashlib import sha256
from itertools import chain

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from warpvec.arrays import Floats, Floats32, Mask
from warpvec.flat.connected_parts import with_filled_holes
from warpvec.flat.constants.softness import SOFTNESS
from warpvec.flat.softness.casters import coverage_of, find_cast_shadow, find_casters, share_of
from warpvec.flat.softness.grounds import Ground, Parts, find_cards, find_grounds, find_parts, find_plateaus
from warpvec.flat.softness.reached import find_covering, soft_zone, split_parts
from warpvec.flat.softness.shadow_fitting import FoundShadow, Zone
from warpvec.flat.softness.spots import find_spot
from warpvec.flat.softness.traced_grounds import TracedGround
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
    ground: Ground | TracedGround
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


_FindGrounds = Callable[[Floats, NDArray[np.int32], int], Iterator[Ground]]


def _never() -> bool:
    return False


def find_shadows(image: Floats32, is_time_up: Callable[[], bool] = _never) -> list[Shadow]:
    """Return the shadows of a picture; each is found in the picture without those before it.

    Arguments as for `find_shadow`.
    """
    found: list[Shadow] = []
    without = set[bytes]()
    while len(found) < SOFTNESS.shadows_max:
        shadow = find_shadow(found[-1].clean if found else image, is_time_up, without)
        if shadow is None:
            break
        found.append(shadow)
    return found


def find_shadow(
    image: Floats32, is_time_up: Callable[[], bool] = _never, without: set[bytes] | None = None
) -> Shadow | None:
    """Return the shadow of a picture; None without one, or if the time is up before one is found.

    Args:
        image: [h, w, 3 or 4], sRGB-encoded in [0, 1], with straight alpha.
        is_time_up: whether the search is to end.
        without: hashes of grounds on which no shadow was found before; more are added.
    """
    without = set() if without is None else without
    if not is_transparent(image):
        return _best_shadow(image, find_grounds, is_time_up, without)
    found = _best_shadow(image, find_grounds, is_time_up, without) if _has_soft_alpha(image[..., 3]) else None
    return found or _on_opaque_card(image, is_time_up, without)


def _best_shadow(
    image: Floats32, find: _FindGrounds, is_time_up: Callable[[], bool], without: set[bytes]
) -> Shadow | None:
    """Return the shadow of a picture on one of the grounds that ``find`` finds; None without one."""
    levels = 255.0 * channels_of(image)
    plateaus, count = find_plateaus(levels)
    if count > SOFTNESS.spot_plateaus_max:
        return None
    parts = find_parts(levels, plateaus, count)
    best = None
    for ground in find(levels, plateaus, count):
        for part in _with_parts(levels, ground):
            if is_time_up():
                return best
            found = _found_on(part, levels, parts, is_time_up, without)
            if found is not None and (best is None or found.look.unexplained < best.look.unexplained):
                best = found
            if best is not None and best.look.unexplained <= SOFTNESS.explained:
                return best
    return best


def _with_parts(levels: Floats, ground: Ground) -> Iterator[Ground]:
    """Yield a ``ground``, its parts around each thing, and those around each shape; none without a soft zone."""
    soft = soft_zone(levels, ground)
    if soft.sum() < SOFTNESS.zone_area:
        return
    yield ground
    yield from ground.parts(soft, ground.things())
    yield from split_parts(levels, ground, soft)


def _on_opaque_card(image: Floats32, is_time_up: Callable[[], bool], without: set[bytes]) -> Shadow | None:
    """Return the shadow on an opaque shape of a transparent picture ``image`` [h, w, 4]; None without one."""
    is_opaque = image[..., 3] == 1.0

    def cards(levels: Floats, plateaus: NDArray[np.int32], count: int) -> Iterator[Ground]:
        return (ground for ground in find_cards(levels, plateaus, count) if is_opaque[ground.region].all())

    if is_opaque.mean() < SOFTNESS.plate_share:
        return None
    found = _best_shadow(image[..., :3] * image[..., 3:], cards, is_time_up, without)
    if found is None:
        return None
    clean = np.where(found.ground.region[..., None], np.dstack([found.clean, image[..., 3]]), image)
    return replace(found, clean=clean.astype(np.float32))


def _found_on(
    ground: Ground, levels: Floats, parts: Parts, is_time_up: Callable[[], bool], without: set[bytes]
) -> Shadow | None:
    """Return the shadow or the soft spot on a ``ground``; None without one. Arguments as for `find_casters`.

    Grounds that are just as those ``without`` are not searched again.
    """
    key = _key(ground, levels)
    if key in without:
        return None
    light = _light_on(ground, levels, parts, is_time_up)
    if light is None:
        without.add(key)
        return None
    ground, found, is_cast = light
    clean = np.clip(_unshaded(levels, parts, ground, *found), 0.0, 255.0) / 255.0
    cleaned: Floats32 = (from_mattes(clean) if clean.shape[2] > 3 else clean).astype(np.float32)
    return Shadow(found[1], ground, found[2], is_cast, cleaned)


def _key(ground: Ground, levels: Floats) -> bytes:
    """Return a hash of a ``ground`` and of all that the picture shows in its region."""
    return sha256(b"".join(map(np.ndarray.tobytes, (ground.region, ground.is_seen, levels[ground.region])))).digest()


def _light_on(
    ground: Ground, levels: Floats, parts: Parts, is_time_up: Callable[[], bool]
) -> tuple[Ground, tuple[Mask, Floats, FoundShadow], bool] | None:
    """Return a ``ground`` as it is seen, the shadow or the spot on it, and whether shapes cast it; None without one.

    Three things describe the light: the shapes above it [h, w], the coverage of what casts it [h, w], and its fit. The
    arguments are those of `find_casters`.
    """
    casters = find_casters(levels, parts, ground, is_time_up)
    for seen, mask in _above_light(ground, levels, casters):
        if is_time_up():
            return None
        if mask is None:
            found = _spot(levels, seen, casters)
        else:
            is_few = parts.seen <= SOFTNESS.plateaus_max
            found = find_cast_shadow(levels, parts, seen, mask, is_time_up) if is_few else None
        if found is not None and found[2].unexplained <= SOFTNESS.unexplained and is_soft(seen, found[2]):
            return seen, found, mask is not None
    return None


def _above_light(ground: Ground, levels: Floats, casters: Mask | None) -> Iterator[tuple[Ground, Mask | None]]:
    """Yield a ``ground`` as it is seen beside what may cast a shadow, and that [h, w]; None stands for a soft spot.

    The likeliest is first. On a transparent picture that is all that is opaque. Elsewhere what the ground does not
    reach is last: it does not reach the steep middle of a spot either.
    """
    is_opaque = levels.shape[2] == 3
    bend_max = SOFTNESS.edge_bends if is_opaque else SOFTNESS.edge_bends[:1]
    found = (find_covering(levels, ground, each) for each in bend_max)
    covering = ((each[1], each[0]) for each in found if each is not None)
    sharp = [] if casters is None else [(ground, casters)]
    tried: list[Mask] = []
    for seen, mask in chain(sharp, [(ground, None)], covering) if is_opaque else chain(covering, sharp):
        if mask is None or not any(_are_alike(mask, other) for other in tried):
            tried += [] if mask is None else [mask]
            yield seen, mask
    if not is_opaque:
        yield ground, None


def _are_alike(mask: Mask, other: Mask) -> bool:
    """Return whether two masks [h, w] differ only at their edges."""
    beyond = (one & ~ndimage.binary_dilation(two, iterations=3) for one, two in ((mask, other), (other, mask)))
    return bool(sum(int(each.sum()) for each in beyond) < SOFTNESS.zone_area)


def _spot(levels: Floats, ground: Ground, casters: Mask | None) -> tuple[Mask, Floats, FoundShadow] | None:
    """Return what lies above a soft spot of the ground [h, w], the sharp coverage of the spot [h, w], and its fit.

    What the first fit is far from lies above the spot too, if it is little: parts of a thin outline are no casters.
    None without a spot.
    """
    whole = np.zeros(levels.shape[:2], np.bool_) if casters is None else with_filled_holes(casters)
    change = levels - ground.below
    most = SOFTNESS.spot_part_unexplained if ground.is_part else SOFTNESS.spot_unexplained
    for _ in range(SOFTNESS.spot_rounds):
        is_bare = ground.region & ~ndimage.binary_dilation(whole, iterations=2)
        spot = find_spot(Zone(change, ground.deviation, is_bare))
        if spot is None or spot[1].unexplained <= most:
            return None if spot is None else (whole, *spot)
        rest = largest_channel(np.abs(change - spot[1].shade_of(spot[0], ground.deviation)))
        is_off = is_bare & (rest > SOFTNESS.jump)
        if is_off.sum() > SOFTNESS.spot_off * (is_bare & ~ground.is_seen).sum():
            return None
        whole = with_filled_holes(whole | is_off)
    return None


def is_soft(ground: Ground | TracedGround, found: FoundShadow) -> bool:
    """Return whether a fit is blurred, shows, has room, and a colour that can be painted."""
    is_seen = bool(np.abs(found.amplitude).max() >= SOFTNESS.amplitude_min)
    opaque = ground.color + found.amplitude
    can_be = bool(opaque.min() >= -SOFTNESS.jump and opaque.max() <= 255.0 + SOFTNESS.jump)
    has_room = bool(ground.region.sum() >= SOFTNESS.room * found.sigma**2)
    return found.sigma >= SOFTNESS.sigma_min and is_seen and can_be and has_room


def _unshaded(levels: Floats, parts: Parts, ground: Ground, casters: Mask, cast: Floats, found: FoundShadow) -> Floats:
    """Return the picture without the shadow of a coverage ``cast`` [h, w], below the ``casters`` [h, w], in levels."""
    near = ndimage.binary_dilation(casters, iterations=2)
    shade = found.shade_of(cast, ground.deviation)
    covered = np.where(ground.region, coverage_of(levels, casters, near, ground.below + shade), 1.0)
    # Nothing else is on the ground, or it is no part of the shadow and stays.
    clean = np.where((near & ~casters)[..., None], levels, levels - (1.0 - covered[..., None]) * shade)
    # Those inside the shapes, such as those of letters on a card, are mixed of other colours.
    is_shade = largest_channel(np.abs(levels - ground.below - shade)) <= SOFTNESS.jump
    beside = (ground.region & ~near) | ndimage.binary_opening(is_shade & ~casters, np.ones((2, 2)))
    edge = near & ~casters & ground.region & ndimage.binary_dilation(beside, iterations=3)
    clean[edge] = mixed_again(levels, ground.below, shade, casters & (parts.number > 0), edge)
    # Two shadows that overlap are a little less than the shadow of both shapes together.
    alike = 3.0 * SOFTNESS.alike + SOFTNESS.overlapping * largest_channel(np.abs(shade))
    is_alike = largest_channel(np.abs(clean - ground.below)) <= alike
    clear = ~near & ground.region & (ground.is_seen | is_alike)
    clean[clear] = ground.below[clear]
    return clean


def _has_soft_alpha(alpha: Floats32) -> bool:
    """Return whether ``alpha`` [h, w] is between 0 and 1 in wider areas than anti-aliased edges."""
    inner = ndimage.binary_erosion((alpha > 0.0) & (alpha < 1.0), np.ones((3, 3)))
    return bool(inner.sum() >= SOFTNESS.inner_area)


def channels_of(image: Floats32, count: int | None = None) -> Floats:
    """Return ``image`` [h, w, 3 or 4] as it is, or over black and white if it is transparent [h, w, C].

    If a ``count`` of 3 channels is asked for, a transparent one is over black alone.
    """
    channels: Floats = over_mattes(image).astype(np.float64)
    return channels[..., :count]


def mixed_again(levels: Floats, below: Floats, shade: Floats, pure: Mask, edge: Mask) -> Floats:
    """Return the colours of the pixels at an ``edge`` [K, C] by their mix of the nearest ``pure`` one and ``below``."""
    _, (y, x) = ndimage.distance_transform_edt(~pure, return_indices=True)
    own, beside = levels[y, x][edge], (below + shade)[edge]
    share = share_of(levels[edge], own, beside)[:, None]
    mixed: Floats = share * own + (1.0 - share) * below[edge]
    return mixed
