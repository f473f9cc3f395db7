"""Take a shadow out of a picture."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats, Floats32, Mask
from warpvec.flat.constants.softness import SOFTNESS
from warpvec.flat.regions.regions import Regions
from warpvec.flat.softness.shadow_fitting import FoundShadow
from warpvec.flat.softness.shadows import channels_of
from warpvec.flat.softness.traced_grounds import TracedGround
from warpvec.image.alpha import from_mattes
from warpvec.image.spread import largest_channel

REACH = 3
"""Pixels beyond the open ground at which a shadow is taken out of the edges of shapes."""


def without_shadow(
    image: Floats32, ground: TracedGround, cast: Floats, covered: Floats, look: FoundShadow, mark: Floats | None
) -> Floats32:
    """Return the picture [h, w, 3 or 4] without a shadow.

    Args:
        image: the picture, sRGB-encoded in [0, 1], with straight alpha.
        ground: what the shadow lies on.
        cast: coverage of what casts it [h, w].
        covered: coverage of all pieces on the ground [h, w].
        look: the shadow.
        mark: the colour [3], in levels, of what casts it in the very colour of the ground; None if nothing does.
    """
    levels = 255.0 * channels_of(image)
    count = ground.below.shape[2]
    seen, shade = levels[..., :count] - ground.below, look.shade_of(cast, ground.deviation)
    reaches = ground.region & ndimage.binary_dilation(ground.is_open, iterations=REACH)  # none between two pieces
    covered = np.where(reaches, np.maximum(covered, _thin_coverage(seen - shade, covered)), 1.0)
    clean = levels[..., :count] - (1.0 - covered[..., None]) * shade
    most = 2.0 * ground.alike + SOFTNESS.overlapping * largest_channel(np.abs(shade))
    is_bare = (covered == 0.0) & (ground.is_seen | (largest_channel(np.abs(clean - ground.below)) <= most))
    if ground.noise < SOFTNESS.ringing:
        clean[is_bare] = ground.below[is_bare]
    if mark is not None:
        # Its edge is where the shadow ends.
        near = ndimage.binary_dilation(_is_hidden(levels[..., :count], ground, cast), iterations=2)
        is_shaded = largest_channel(np.abs(shade)) > SOFTNESS.jump
        own = np.where(near, np.where(is_shaded, 1.0 - share_of(seen, shade, np.zeros(count)), cast), 0.0)[..., None]
        clean = np.where(own > 0.0, own * mark + (1.0 - own) * ground.below, clean)
    if count < levels.shape[2]:  # an opaque ground of a transparent picture, which is the same over black and white
        clean = np.concatenate([clean, levels[..., count:] + clean - levels[..., :count]], 2)
    clean = np.clip(clean, 0.0, 255.0) / 255.0
    found = (from_mattes(clean) if clean.shape[2] > 3 else clean).astype(np.float32)
    if count < levels.shape[2]:
        found[..., 3] = image[..., 3]
    return found


def _thin_coverage(rest: Floats, covered: Floats) -> Floats:
    """Return how much of each pixel thin things that are no pieces cover [h, w], by what a shadow leaves of a picture.

    They are far from it, and nothing but them is, away from the pieces that are ``covered`` [h, w].
    """
    away = np.where(ndimage.binary_dilation(covered > 0.0, iterations=2), 0.0, largest_channel(np.abs(rest)))
    most = ndimage.maximum_filter(away, 5)
    thin: Floats = np.where(most > SOFTNESS.off_levels, away / np.maximum(most, 1.0), 0.0)
    return thin


def mark_for(ground: TracedGround, image: Floats32, cast: Floats, regions: Regions) -> Floats | None:
    """Return the colour [3] for what casts a shadow in the very colour of its ``ground``; None if nothing does.

    It is the colour that is farthest from all others of the picture.
    """
    levels = 255.0 * channels_of(image, ground.below.shape[2])
    if len(ground.color) > 3 or not ndimage.binary_erosion(_is_hidden(levels, ground, cast)).any():
        return None
    choices = 127.5 * np.indices((3, 3, 3)).reshape(3, 27).T
    known = 255.0 * np.concatenate([regions.paints.color, ground.color[None] / 255.0])
    return np.asarray(choices[np.abs(choices[:, None] - known).max(2).min(1).argmax()])


def _is_hidden(levels: Floats, ground: TracedGround, cast: Floats) -> Mask:
    """Return the pixels of shapes [h, w] that cast a shadow and have the colour of their ground."""
    is_alike = largest_channel(np.abs(levels - ground.below)) <= 2.0 * ground.alike
    return np.asarray((cast > 0.0) & ndimage.binary_dilation(is_alike & (ground.pieces > 0) & (cast == 1.0)))


def share_of(mixed: Floats, own: Floats, beside: Floats) -> Floats:
    """Return the share [...] of a colour ``own`` in ``mixed`` ones, beside another [..., C], in levels."""
    span = own - beside
    share: Floats = ((mixed - beside) * span).sum(-1) / np.maximum((span * span).sum(-1), 1.0)
    return np.clip(share, 0.0, 1.0)
