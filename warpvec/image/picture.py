"""A picture to draw, at full size and reduced to the size of a fit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from warpvec.image.alpha import is_transparent, straight


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture, and the copy that a fit compares its paths with.

    Attributes:
        pixels: the picture [h, w, 3], sRGB-encoded in [0, 1], or [h, w, 4] with straight alpha.
        reduced: its copy, reduced to the size of a fit.
        title: title of its drawing; None for none.
        unread: what of its file was left out, such as "all but page 2 of 3"; None for nothing.
        is_restored: whether the copy shows the picture as it was before something happened to it.
        blur: standard deviation in pixels of the blur of the copy, which its drawing is to be without; 0 for none.
    """

    pixels: NDArray[np.float32]
    reduced: NDArray[np.float32]
    title: str | None = None
    unread: str | None = None
    is_restored: bool = False
    blur: float = 0.0

    @staticmethod
    def of(pixels: NDArray[np.float32], fit_size: int, title: str | None = None, unread: str | None = None) -> Picture:
        """Return the picture with these ``pixels``, as `warpvec.image.read.read_image` gives them.

        The copy has a longest side of at most ``fit_size`` pixels.
        """
        return Picture(pixels, reduce_image(pixels, fit_size), title, unread)

    @property
    def height(self) -> int:
        """Height in pixels."""
        return self.pixels.shape[0]

    @property
    def width(self) -> int:
        """Width in pixels."""
        return self.pixels.shape[1]

    @property
    def reduced_size(self) -> tuple[int, int]:
        """Height and width of the copy."""
        return self.reduced.shape[0], self.reduced.shape[1]

    @property
    def is_damage_undone(self) -> bool:
        """Whether a drawing shows the picture as it was before something happened to it, its blur included."""
        return self.is_restored or self.blur > 0.0

    @property
    def enlargement(self) -> tuple[float, float]:
        """Width and height of the picture over those of its copy."""
        rows, columns = self.reduced_size
        return self.width / columns, self.height / rows

    @property
    def reduction(self) -> tuple[float, float]:
        """Width and height of the copy over those of the picture."""
        rows, columns = self.reduced_size
        return columns / self.width, rows / self.height

    @property
    def is_transparent(self) -> bool:
        """Whether the picture has alpha."""
        return is_transparent(self.pixels)

    @property
    def blocks(self) -> int:
        """Side in pixels of the blocks whose means leave a blur of about one pixel."""
        return 1 if self.is_transparent else max(1, round(self.blur))

    @property
    def sharp_copy(self) -> NDArray[np.float32]:
        """The means of the ``blocks`` of the copy: what a picture is shows in sharp edges."""
        if self.blocks == 1:
            return self.reduced
        channels = (Image.fromarray(_channel(self.reduced, index)) for index in range(self.reduced.shape[2]))
        return np.stack([np.asarray(channel.reduce(self.blocks)) for channel in channels], -1)


def reduce_image(pixels: NDArray[np.float32], longest_side: int) -> NDArray[np.float32]:
    """Reduce ``pixels`` [h, w, 3 or 4] until neither side is longer than ``longest_side``; never enlarge them.

    The filter is Lanczos-3, whose overshoot is clipped to [0, 1]. Straight colours with alpha are premultiplied for
    filtering and straight again in the result. A side keeps at least one pixel.
    """
    return _reduced(pixels, longest_side, _lanczos)


def mean_image(pixels: NDArray[np.float32], longest_side: int) -> NDArray[np.float32]:
    """Reduce ``pixels`` [h, w, 3 or 4] as `reduce_image`, but by means, which leave no halos at edges.

    A drawing would show the halos of Lanczos. A photo is 0.1 to 0.3 dB closer with them.
    """
    return _reduced(pixels, longest_side, lambda channel, rows, columns: _means(_means(channel, rows).T, columns).T)


def _reduced(
    pixels: NDArray[np.float32],
    longest_side: int,
    reduce: Callable[[NDArray[np.float32], int, int], NDArray[np.float32]],
) -> NDArray[np.float32]:
    """Return ``pixels`` whose channels ``reduce`` makes of so many rows and columns; the rest as `reduce_image`."""
    height, width = pixels.shape[:2]
    rows, columns = fitted_size(height, width, longest_side)
    if (rows, columns) == (height, width):
        return pixels
    # One channel at a time: the largest image would take 1 GB more at once.
    channels = (_channel(pixels, index) for index in range(pixels.shape[2]))
    reduced = np.stack([reduce(channel, rows, columns) for channel in channels], -1)
    return straight(reduced) if is_transparent(pixels) else reduced.clip(0.0, 1.0)


def _lanczos(channel: NDArray[np.float32], rows: int, columns: int) -> NDArray[np.float32]:
    return np.asarray(Image.fromarray(channel).resize((columns, rows), Image.Resampling.LANCZOS))


def _means(values: NDArray[np.float32], count: int) -> NDArray[np.float32]:
    """Return the means of ``values`` [n, m] over ``count`` windows of the first axis.

    A value is the mean over its pixel already. With windows of this width the variance of both is that of a pixel of
    the result, as a renderer draws it: where a window is a whole pixel of the result, edges are too soft.
    """
    factor = len(values) / count
    width = max((factor**2 - 1.0) ** 0.5, 1.0)
    middle = (np.arange(count) + 0.5) * factor
    start, stop = (middle - width / 2.0).clip(0.0), (middle + width / 2.0).clip(None, len(values))
    first, found = np.floor(start).astype(np.int64), np.zeros((count, values.shape[1]), np.float32)
    for step in range(int(np.ceil(width)) + 1):
        row = np.minimum(first + step, len(values) - 1)
        weight = (np.minimum(stop, first + step + 1) - np.maximum(start, first + step)).clip(0.0)
        found += (weight / (stop - start)).astype(np.float32)[:, None] * values[row]
    return found.clip(0.0, 1.0)


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
