"""The outlines of photos: a rectangle, with round corners or not, an ellipse, or else a smooth curve.

Texture hides where a photo ends to a fraction of a pixel, and its designer took a simple form far more often than not.
"""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from warpvec.arrays import Floats, Mask
from warpvec.flat.connected_parts import with_filled_holes
from warpvec.flat.constants.textures import TEXTURES


def smooth_shares(share: Floats) -> Floats:
    """Return how much of each pixel [h, w] the photos cover, with a form or a smooth outline for each of them.

    Args:
        share: the same as the colours tell it, in [0, 1].
    """
    parts, _ = ndimage.label(share > 0.0, np.ones((3, 3), bool))
    found = np.zeros(share.shape)
    margin = TEXTURES.form_margin
    for number, place in enumerate(ndimage.find_objects(parts), 1):
        wide = tuple(slice(max(each.start - margin, 0), each.stop + margin) for each in place)
        own = np.where(parts[wide] == number, share[wide], 0.0)
        form = _nearest_form(own)
        found[wide] = np.maximum(found[wide], _smooth(own) if form is None else form)
    return found


def _nearest_form(share: Floats) -> Floats | None:
    """Return the shares of the form that is nearest to those of a photo [h, w]; None if none is near."""
    solid = np.where(_filled(share), 1.0, share)
    length = float(np.hypot(*np.gradient(solid)).sum())
    area = float(solid.sum())
    forms = [_shares_of(distance) for distance in _distances(solid, area)]
    errors = [float(np.abs(form - solid).sum()) for form in forms]
    best = int(np.argmin(errors))
    return forms[best] if errors[best] <= TEXTURES.form_error * length else None


def _filled(share: Floats) -> Mask:
    return with_filled_holes(share >= 1.0)


def _distances(share: Floats, area: float) -> list[Floats]:
    """Return the signed distances in pixels, below 0 inside, of forms with the place and size of a photo.

    They are those of a rectangle, of one with round corners, and of an ellipse. Its area, and how much it shows in each
    row and column, give the measures.
    """
    y, x = np.indices(share.shape, np.float64) + 0.5
    spans = [_span(share.sum(axis)) for axis in (0, 1)]
    (left, right), (top, bottom) = spans
    width, height = right - left, bottom - top
    across, down = np.abs(x - (left + right) / 2.0), np.abs(y - (top + bottom) / 2.0)
    radius = float(np.sqrt(max(width * height - area, 0.0) / (4.0 - np.pi)))
    found = [_to_rectangle(across, down, width, height, each) for each in (0.0, min(radius, width / 2, height / 2))]
    # An ellipse covers little of the outermost rows, so that its area tells its size better.
    size = float(np.sqrt(area / (np.pi * width * height))) * np.array([width, height])
    scaled = np.hypot(across / size[0], down / size[1])
    steep = np.hypot(across / size[0] ** 2, down / size[1] ** 2)
    found.append((scaled - 1.0) * scaled / np.maximum(steep, 1e-9))
    return found


def _span(profile: Floats) -> tuple[float, float]:
    """Return where a photo begins and ends by its ``profile``: the pixels that it covers in each column or row."""
    shown = np.flatnonzero(profile > 0.0)
    first, last = int(shown[0]), int(shown[-1])
    # The outermost column of a rectangle is covered by as much as that column is part of it.
    inner = max(float(profile[min(first + 1, last)]), 1e-9), max(float(profile[max(last - 1, first)]), 1e-9)
    return first + 1.0 - min(profile[first] / inner[0], 1.0), last + min(float(profile[last]) / inner[1], 1.0)


def _to_rectangle(across: Floats, down: Floats, width: float, height: float, radius: float) -> Floats:
    """Return the signed distance [h, w] to a rectangle with round corners, from places relative to its middle."""
    x, y = across - (width / 2.0 - radius), down - (height / 2.0 - radius)
    outside = np.hypot(np.maximum(x, 0.0), np.maximum(y, 0.0))
    return np.asarray(outside + np.minimum(np.maximum(x, y), 0.0) - radius)


def _shares_of(distance: Floats) -> Floats:
    """Return how much of each pixel a form covers, by its signed distance [h, w]."""
    return (0.5 - distance).clip(0.0, 1.0)


def _smooth(share: Floats) -> Floats:
    """Return shares [h, w] with a smoother outline."""
    level = ndimage.gaussian_filter(share, TEXTURES.outline_blur, mode="nearest")
    slope = np.hypot(*np.gradient(level))
    return (0.5 + (level - 0.5) / np.maximum(slope, 1e-6)).clip(0.0, 1.0)
