"""Round images to 8 bits, and write them as PNG files."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec.files import check_writable, write_atomic


def to_8_bits(pixels: NDArray[np.floating[Any]]) -> NDArray[np.uint8]:
    """Clamp ``pixels`` to [0, 1] and round them to uint8."""
    return np.rint(np.clip(pixels, 0.0, 1.0) * 255.0).astype(np.uint8)


def round_to_8_bits(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """Clamp ``image`` to [0, 1] and round it to 8-bit levels, in place and still as float."""
    np.clip(image, 0.0, 1.0, out=image)
    np.rint(np.multiply(image, 255.0, out=image), out=image)
    return np.divide(image, 255.0, out=image)


def png_bytes(pixels: NDArray[np.uint8], **options: int) -> bytes:
    """Return the PNG file of ``pixels`` [h, w, 3 or 4], without metadata; ``options`` are those of Pillow."""
    import imageio.v3 as iio  # not above: importing it takes a tenth of a second, which reading pictures does without

    write: Callable[..., bytes] = iio.imwrite  # its type knows no options of Pillow
    return write("<bytes>", pixels, extension=".png", plugin="pillow", **options)


def write_png(path: str | os.PathLike[str], pixels: NDArray[np.floating[Any]], name: str = "path") -> None:
    """Write ``pixels`` [h, w, 3 or 4] in [0, 1] as an 8-bit PNG, completely or not at all.

    Raises:
        InputError: ``path``, which messages call ``name``, cannot be written.
        OSError: writing failed for another reason, such as a full disk.
    """
    check_writable(path, name)
    write_atomic(path, png_bytes(to_8_bits(pixels)))
