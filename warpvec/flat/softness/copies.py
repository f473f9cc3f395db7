"""Find shadows that are copies of traced pieces, moved and blurred, and whether they are shorter to say than slabs."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats, Floats32
from warpvec.flat.constants.softness import SOFTNESS
from warpvec.flat.evidence.evidence import ROUNDING, Evidence
from warpvec.flat.price import SHADOW_NUMBERS, number_nats
from warpvec.flat.regions.regions import Regions, find_regions
from warpvec.flat.softness.shadow_fitting import FoundShadow
from warpvec.flat.softness.shadows import Shadow, channels_of, is_soft, mixed_again
from warpvec.flat.softness.traced_casters import Casting
from warpvec.flat.softness.traced_grounds import TracedGround, find_traced_grounds
from warpvec.watch.decisions import Decision, are_wanted, box_of, note


def find_copies(
    image: Floats32, traced: Regions, is_time_up: Callable[[], bool], saved: Evidence | None = None
) -> list[Shadow]:
    """Return the shadow of an opaque picture as a copy of traced pieces; none if there is none or it does not pay.

    Args:
        image: [h, w, 3], sRGB-encoded in [0, 1].
        traced: a rough tracing of it, with its shadow.
        is_time_up: whether the search is to end.
        saved: what it says if it was saved as JPEG; None for no JPEG.
    """
    if image.shape[2] > 3 or not 1 < len(traced) <= SOFTNESS.pieces_max:
        return []
    levels, is_jpeg = 255.0 * channels_of(image), saved is not None
    for ground in find_traced_grounds(levels, traced, is_jpeg):
        if is_time_up():
            return []
        shadow = _copy_on(ground, levels, traced)
        if shadow is None or (is_jpeg and _is_bleed(shadow.look)):
            continue
        evidence = saved or Evidence(levels, np.full(3, math.sqrt(ROUNDING + ground.noise**2)))
        nats = gain(evidence, traced, shadow, find_regions(shadow.clean, is_jpeg=is_jpeg))
        if are_wanted():
            place = box_of(np.argwhere(shadow.casters > 0.5)[:, ::-1].astype(np.float64))
            note(Decision("shadow", place, "regions", f"blur of {shadow.look.sigma:.2f} px", nats, 0.0, nats > 0.0))
        if nats > 0.0:
            return [shadow]
    return []


def _is_bleed(look: FoundShadow) -> bool:
    """Return whether a shadow is what a JPEG with colours at half size makes around each shape: unmoved and narrow."""
    return look.sigma <= SOFTNESS.bleed_sigma and math.hypot(*look.offset) <= SOFTNESS.bleed_offset


def gain(evidence: Evidence, before: Regions, shadow: Shadow, after: Regions) -> float:
    """Return by how many nats the picture of ``evidence`` is shorter to say with a ``shadow``.

    Args:
        evidence: the picture.
        before: its regions, with slabs of the shadow.
        shadow: a shadow of it.
        after: the regions of the picture without it.
    """
    ground, look, levels = shadow.ground, shadow.look, evidence.levels
    assert isinstance(ground, TracedGround)
    shade = look.shade_of(shadow.casters, ground.deviation)
    # What was taken away at edges is a mix; elsewhere it may be noise too.
    added = np.where(ground.is_open[..., None], shade, levels - 255.0 * shadow.clean)
    return before.nats(evidence) - after.nats(evidence, added) - SHADOW_NUMBERS * number_nats(max(levels.shape))


def _copy_on(ground: TracedGround, levels: Floats, regions: Regions) -> Shadow | None:
    """Return the shadow on a ``ground`` of a picture, ``levels`` [h, w, 3]; None without one."""
    if (ground.is_open & ~ground.is_seen).sum() < SOFTNESS.zone_area:
        return None
    casting = Casting(ground, levels - ground.below, regions)
    found = casting.best() if casting.everything else None
    if found is None or not is_soft(found[0].ground, found[2]):
        return None
    on, cast, look = found[0].ground, found[1], found[2]
    clean = np.clip(_unshaded(levels, on, cast, look), 0.0, 255.0) / 255.0
    return Shadow(cast, on, look, True, clean.astype(np.float32))


def _unshaded(levels: Floats, ground: TracedGround, cast: Floats, found: FoundShadow) -> Floats:
    """Return the picture in levels without the shadow of a coverage ``cast`` [h, w], below the pieces."""
    reaches = ndimage.binary_dilation(ground.is_open, iterations=3)
    above = (ground.pieces > 0) | ~ground.region | ~reaches  # single pixels between two pieces are no ground
    shade = found.shade_of(cast, ground.deviation)
    near = ndimage.binary_dilation(above, iterations=2)
    clean = np.where(above[..., None], levels, levels - shade)
    # Only edges that the ground reaches are mixed with it; those of letters on a card are mixed of other colours.
    edge = near & ground.region & reaches
    inner = ndimage.binary_erosion(above, border_value=1)
    clean[edge] = mixed_again(levels, ground.below, shade, inner if inner.any() else above, edge)
    if ground.noise < SOFTNESS.ringing:
        is_alike = np.abs(clean - ground.below).max(2) <= 2.0 * ground.alike
        clear = ~near & ground.region & (ground.is_seen | is_alike)
        clean[clear] = ground.below[clear]
    return clean
