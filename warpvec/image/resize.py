"""Reduce images to the size that a fit works with."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from warpvec.image.alpha import is_transparent, straight


def reduce_image(pixels: NDArray[np.float32], longest_side: int) -> NDArray[np.float32]:
    """Reduce ``pixels`` [h, w, 3 or 4] until neither side is longer than ``longest_side``; never enlarge them.

    The filter is Lanczos-3, whose overshoot is clipped to [0, 1]. Straight colours with alpha are premultiplied for
    filtering and straight again in the result. A side keeps at least one pixel.
    """
    height, width = pixels.shape[:2]
    size = fitted_size(height, width, longest_side)[::-1]
    if size == (width, height):
        return pixels
    # One channel at a time: the largest image would take 1 GB more at once.
    channels = (Image.fromarray(_channel(pixels, index)) for index in range(pixels.shape[2]))
    reduced = np.stack([np.asarray(channel.resize(size, Image.Resampling.LANCZOS)) for channel in channels], -1)
    return straight(reduced) if is_transparent(pixels) else reduced.clip(0.0, 1.0)


def _channel(pixels: NDArray[np.float32], index: int) -> NDArray[np.float32]:
    """Return a channel [h, w] of ``pixels``, a colour premultiplied."""
    channel = np.ascontiguousarray(pixels[..., index])
    return channel * pixels[..., 3] if is_transparent(pixels) and index < 3 else channel


def fitted_size(height: int, width: int, longest_side: int) -> tuple[int, int]:
    """Return the height and width to which `reduce_image` reduces an image of ``height`` x ``width`` pixels."""
    longest = max(height, width)
    if longest <= longest_side:
        return height, width
    return max(1, round(height * longest_side / longest)), max(1, round(width * longest_side / longest))
