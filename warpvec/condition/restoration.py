"""The picture before its enlargement, and after it."""

from __future__ import annotations

import numpy as np

from warpvec.arrays import Floats, Floats32
from warpvec.condition.enlargement import Enlargement
from warpvec.condition.resampling import Upsampling
from warpvec.image.alpha import is_transparent, premultiplied, straight


def before_enlargement(pixels: Floats32, enlargement: Enlargement) -> Floats32:
    """Return the small picture that explains ``pixels`` [h, w, 3 or 4], in [0, 1], best.

    It has eight bits, as it had, so that even areas are even again. Programs enlarge colours that are multiplied by
    alpha.
    """
    if enlargement.is_of_whole_pixels and pixels.shape[0] % enlargement.height == 0:
        return _cells(pixels, enlargement)
    height, width = pixels.shape[:2]
    down = Upsampling(height, enlargement.height, enlargement.kernel)
    across = Upsampling(width, enlargement.width, enlargement.kernel)
    image = premultiplied(pixels) if is_transparent(pixels) else pixels
    channels = (np.asarray(image[..., k], np.float64) for k in range(image.shape[2]))
    small = np.stack([_inverse(across, _inverse(down, channel).T).T for channel in channels], -1).astype(np.float32)
    whole = straight(small) if is_transparent(pixels) else small.clip(0.0, 1.0)
    return np.asarray(np.rint(255.0 * whole) / 255.0, np.float32)


def after_enlargement(pixels: Floats, enlargement: Enlargement, height: int, width: int) -> Floats:
    """Return ``pixels`` [h, w, C] as ``enlargement`` makes a picture [height, width, C] of them."""
    down = Upsampling(height, enlargement.height, enlargement.kernel).matrix
    across = Upsampling(width, enlargement.width, enlargement.kernel).matrix
    channels = (down @ (across @ pixels[..., k].T).T for k in range(pixels.shape[2]))
    return np.stack(list(channels), -1)


def _cells(pixels: Floats32, enlargement: Enlargement) -> Floats32:
    """Return the mean of the inside of each square of ``pixels`` [h, w, 3 or 4]: JPEG mixes colours at its sides."""
    rows, columns, side = enlargement.height, enlargement.width, pixels.shape[1] // enlargement.width
    squares = pixels.reshape(rows, pixels.shape[0] // rows, columns, side, -1)
    margin = min(squares.shape[1], side) // 3
    inside = squares[:, margin : squares.shape[1] - margin, :, margin : side - margin]
    return np.asarray(np.rint(255.0 * inside.mean((1, 3), np.float64)) / 255.0, np.float32)


def _inverse(enlargement: Upsampling, rows: Floats) -> Floats:
    """Return the small rows [small, N] that explain ``rows`` [large, N], which are cut off below 0 and above 1."""
    half_level = 0.5 / 255.0
    return enlargement.inverse_of_cut_off(rows, half_level, 1.0 - half_level)
