"""A placeholder: a rough, blurred drawing of an image in few bytes, which a web page shows until the image is there."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from PIL import Image
from torch import Tensor

from warpvec.checks import check_count
from warpvec.errors import InputError
from warpvec.fit.loop import single_torch_thread
from warpvec.image.read import ImageSource, read_image
from warpvec.placeholders.canvas import BlurredCanvas, Shapes
from warpvec.placeholders.fit import fit_shapes
from warpvec.placeholders.text import data_uri, placeholder_svg

BYTES_MIN, BYTES_MAX, BYTES_DEFAULT = 300, 5_000, 1_000
"""Bounds of the bytes of the data URI. With less, not even one shape fits in; with more, an image file looks better."""

BLUR_BYTES_MIN = 450
"""Smallest size with the filter, which takes the bytes of two shapes. In 400 bytes the filter loses 0.2 dB, in 600 it
gains 0.3 dB (mean of six photos)."""

SIDES = ((1_500, 96, 1.0), (3_000, 128, 0.8), (BYTES_MAX, 160, 0.8))
"""Largest number of bytes -> longest side of the viewBox, and standard deviation of the blur, in its units. Finer
units pay with many shapes only: 128 instead of 96 gain 0.2 dB in 2,000 bytes and nothing in 1,000."""

PROPORTION_MAX = 50
"""Largest ratio of an image's sides: the shorter side needs a unit or two."""

SIDE_SHARE = 0.9
"""Shortest longest side, as a share of that of ``SIDES``. Among these, that whose proportions are nearest counts."""


class Placeholder(NamedTuple):
    """A placeholder.

    Attributes:
        svg: its text, with a viewBox and no size of its own.
        uri: the text as a data URI, for ``url("...")`` in CSS and ``src="..."`` in HTML.
        shape_count: number of shapes above the background.
    """

    svg: str
    uri: str
    shape_count: int


def placeholder(image: ImageSource, max_bytes: int = BYTES_DEFAULT, *, background: str = "white") -> str:
    """Return a data URI of at most ``max_bytes`` characters, with a drawing that stands for ``image`` while it loads.

    It goes into double quotes, as in ``background-image: url("...")`` and ``<img src="...">``.

    Args:
        image: a path, bytes, a PIL image, an array or a tensor, as `warpvec.vectorize` takes it.
        max_bytes: from 300 to 5,000.
        background: colour behind a transparent image.

    Raises:
        InputError: the image cannot be read, or ``max_bytes`` or ``background`` is wrong.
    """
    check_bytes(max_bytes)
    return fit_placeholder(read_image(image, background, name="image"), max_bytes).uri


def check_bytes(max_bytes: int, name: str = "max_bytes") -> int:
    """Return ``max_bytes``, which a message calls ``name``.

    Raises:
        InputError: it is no whole number from 300 to 5,000.
    """
    return check_count(name, max_bytes, BYTES_MIN, BYTES_MAX)


def fit_placeholder(photo: NDArray[np.float32], max_bytes: int) -> Placeholder:
    """Return the placeholder of ``photo`` [h, w, 3], whose data URI has at most ``max_bytes`` characters.

    Raises:
        InputError: one side is more than ``PROPORTION_MAX`` times as long as the other.
    """
    side, deviation = next(row[1:] for row in SIDES if max_bytes <= row[0])
    deviation = deviation if max_bytes >= BLUR_BYTES_MIN else 0.0
    width, height = _view_box(photo.shape[1], photo.shape[0], side)

    def text_of(shapes: Shapes) -> str:
        return placeholder_svg(shapes, width, height, deviation)

    def size_of(shapes: Shapes) -> int:
        return len(data_uri(text_of(shapes)))

    with single_torch_thread(), torch.no_grad():
        canvas = BlurredCanvas(_reduced(photo, width, height), deviation)
        shapes = fit_shapes(canvas, max_bytes, size_of)
    svg = text_of(shapes)
    return Placeholder(svg, data_uri(svg), svg.count("<path") - 1)


def _view_box(width: int, height: int, side: int) -> tuple[int, int]:
    """Return the whole width and height that have most nearly the proportions of ``width`` and ``height``."""
    short, long = sorted((width, height))
    if long > PROPORTION_MAX * short:
        rule = f"must be at most {PROPORTION_MAX} times as long as wide for a placeholder"
        raise InputError("image", rule, f"{width} x {height}", "crop it")

    def sides(longest: int) -> tuple[float, int, int]:
        shortest = max(1, round(longest * short / long))
        return abs(shortest * long - longest * short) / (longest * long), -longest, shortest

    _, longest, shortest = min(map(sides, range(round(SIDE_SHARE * side), side + 1)))
    return (-longest, shortest) if width >= height else (shortest, -longest)


def _reduced(photo: NDArray[np.float32], width: int, height: int) -> Tensor:
    """Return the means [height, width, 3] of ``photo`` in the units of the viewBox."""
    channels = (Image.fromarray(np.ascontiguousarray(photo[..., index])) for index in range(3))
    means = [np.asarray(channel.resize((width, height), Image.Resampling.BOX)) for channel in channels]
    return torch.from_numpy(np.stack(means, -1))
