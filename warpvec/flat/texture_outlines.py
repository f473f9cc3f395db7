"""Paint the photos of a drawing in one colour, so that they can be outlined like any other area."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats, Floats32, Mask
from warpvec.flat.constants.textures import TEXTURES
from warpvec.flat.texture_forms import smooth_shares

KEYS = np.array([[1, 0, 1], [0, 1, 0], [0, 1, 1], [1, 1, 0], [0, 0, 1], [1, 0, 0], [0, 0, 0], [1, 1, 1]], np.float32)
"""Colours that may stand for photos: the one that is least like all others of the drawing does."""


class Keyed(NamedTuple):
    """A drawing whose photos are of one colour.

    Attributes:
        image: the drawing [h, w, 3] in [0, 1].
        color: the colour [3] of its photos.
        photo: the photos alone [h, w, 3] in [0, 1], where they are seen.
        is_seen: pixels [h, w] where they are. Mixed ones have the colour of the nearest that is not.
    """

    image: Floats32
    color: Floats32
    photo: Floats32
    is_seen: Mask


def with_key(image: Floats32, is_texture: Mask) -> Keyed:
    """Return ``image`` [h, w, 3] in [0, 1] with one colour in place of the photos in the pixels ``is_texture`` [h, w].

    A mixed pixel of the edge shows as much of this colour as it did of the photo.
    """
    color = _key(image[~is_texture])
    share = smooth_shares(_shares(image, is_texture))
    ground = _nearest(image, ~is_texture)
    part = share[..., None].astype(np.float32)
    is_keyed = (is_texture | (share > 0.0))[..., None]
    keyed = np.where(is_keyed, ground + part * (color - ground), image)
    is_whole = share >= TEXTURES.whole_min
    return Keyed(keyed.astype(np.float32), color, _nearest(image, is_whole), share > 0.0)


def _key(others: Floats32) -> Floats32:
    """Return the colour of `KEYS` that is farthest from the nearest of the colours of ``others`` [P, 3]."""
    seen = np.unique(np.rint(31.0 * others).astype(np.int64), axis=0) / np.float32(31.0)
    distances = [float(np.abs(seen - key).sum(1).min()) if len(seen) else 0.0 for key in KEYS]
    return np.asarray(KEYS[int(np.argmax(distances))])


def _shares(image: Floats32, is_texture: Mask) -> Floats:
    """Return how much of each pixel [h, w] is photo, by the mix of the colours beside it."""
    inside = ndimage.binary_erosion(is_texture, _square(), border_value=1)
    if not inside.any():
        return is_texture.astype(np.float64)
    photo, ground = _nearest(image, inside), _nearest(image, ~is_texture)
    way = (photo - ground).astype(np.float64)
    length = np.square(way).sum(2)
    mixed = ((image - ground) * way).sum(2) / np.maximum(length, 1e-9)
    is_clear = 255.0 * np.sqrt(length) >= TEXTURES.contrast_min
    share = np.where(is_texture & ~inside & is_clear, mixed, is_texture)
    return np.asarray(share.clip(0.0, 1.0))


def _nearest(image: Floats32, is_source: Mask) -> Floats32:
    """Return ``image`` [h, w, 3] with the nearest pixel of ``is_source`` [h, w] in place of each other one."""
    if not is_source.any():
        return image
    rows, columns = ndimage.distance_transform_edt(~is_source, return_distances=False, return_indices=True)
    return np.asarray(image[rows, columns])


def _square() -> Mask:
    return np.ones((3, 3), bool)
