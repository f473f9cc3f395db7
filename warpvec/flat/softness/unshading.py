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


def without_shadow(
    image: Floats32, ground: TracedGround, cast: Floats, look: FoundShadow, mark: Floats | None
) -> Floats32:
    """Return the picture [h, w, 3 or 4] without the shadow of a coverage ``cast`` [h, w].

    What casts it in the very colour of the ground has the colour ``mark`` [3], in levels, if there is one.
    """
    levels = 255.0 * channels_of(image)
    count = ground.below.shape[2]
    clean = _unshaded(levels[..., :count], ground, cast, look)
    if mark is not None:
        # Its edge is where the shadow ends.
        shade = look.shade_of(cast, ground.deviation)
        seen = share_of(levels[..., :count] - ground.below, shade, np.zeros(3))
        near = ndimage.binary_dilation(_is_hidden(clean, ground, cast), iterations=2)
        own = np.where(near, np.where(largest_channel(np.abs(shade)) > SOFTNESS.jump, 1.0 - seen, cast), 0.0)[..., None]
        clean = own * mark + (1.0 - own) * ground.below
    if count < levels.shape[2]:  # an opaque ground of a transparent picture, which is the same over black and white
        clean = np.concatenate([clean, levels[..., count:] + clean - levels[..., :count]], 2)
    clean = np.clip(clean, 0.0, 255.0) / 255.0
    return (from_mattes(clean) if clean.shape[2] > 3 else clean).astype(np.float32)


def mark_for(ground: TracedGround, image: Floats32, cast: Floats, regions: Regions) -> Floats | None:
    """Return the colour [3] for what casts a shadow in the very colour of its ``ground``; None if nothing does.

    It is the colour that is farthest from all others of the picture.
    """
    levels = 255.0 * channels_of(image, ground.below.shape[2])
    if len(ground.color) > 3 or not ndimage.binary_erosion(_is_hidden(levels, ground, cast)).any():
        return None
    choices = 127.5 * np.stack(np.indices((3, 3, 3)), -1).reshape(27, 3)
    known = 255.0 * np.concatenate([regions.paints.color, ground.color[None] / 255.0])
    return np.asarray(choices[np.abs(choices[:, None] - known).max(2).min(1).argmax()])


def _is_hidden(levels: Floats, ground: TracedGround, cast: Floats) -> Mask:
    """Return the pixels of shapes [h, w] that cast a shadow and have the colour of their ground."""
    is_alike = largest_channel(np.abs(levels - ground.below)) <= 2.0 * ground.alike
    return np.asarray((cast > 0.0) & ndimage.binary_dilation(is_alike & (ground.pieces > 0) & (cast == 1.0)))


def _unshaded(levels: Floats, ground: TracedGround, cast: Floats, found: FoundShadow) -> Floats:
    """Return the picture ``levels`` [h, w, C] without the shadow of a coverage ``cast`` [h, w], below the pieces."""
    reaches = ndimage.binary_dilation(ground.is_open, iterations=3)
    above = (ground.pieces > 0) | ~ground.region | ~reaches  # single pixels between two pieces are no ground
    shade = found.shade_of(cast, ground.deviation)
    near = ndimage.binary_dilation(above, iterations=2)
    clean = np.where(above[..., None], levels, levels - shade)
    # Only edges that the ground reaches are mixed with it; those of letters on a card are mixed of other colours.
    edge = near & ground.region & reaches
    inner = ndimage.binary_erosion(above, border_value=1)
    clean[edge] = _mixed_again(levels, ground.below, shade, inner if inner.any() else above, edge)
    if ground.noise < SOFTNESS.ringing:
        is_alike = largest_channel(np.abs(clean - ground.below)) <= 2.0 * ground.alike
        clear = ~near & ground.region & (ground.is_seen | is_alike)
        clean[clear] = ground.below[clear]
    return clean


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
