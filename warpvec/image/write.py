"""Write images: rounding to 8 bits, and PNG files."""

from __future__ import annotations

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from warpvec.files import check_writable, write_atomic


def to_8_bits(pixels: NDArray[np.floating[Any]]) -> NDArray[np.uint8]:
    """``pixels`` in [0, 1], clamped, as the nearest of 256 levels."""
    return np.rint(np.clip(pixels, 0.0, 1.0) * 255.0).astype(np.uint8)


def write_png(path: str | os.PathLike[str], pixels: NDArray[np.floating[Any]], name: str = "OUT") -> None:
    """Write ``pixels`` [h, w, 3 or 4] in [0, 1] as an 8 bit PNG, rounded to the nearest level, whole or not at all.

    Raises:
        InputError: ``path``, which messages call ``name``, cannot be written.
        OSError: writing it failed all the same: the disk is full, say.
    """
    check_writable(path, name)
    # Here and not above: only runs that save frames write images, and importing imageio takes a tenth of a second.
    import imageio.v3 as iio

    write_atomic(path, iio.imwrite("<bytes>", to_8_bits(pixels), extension=".png"))


def round_to_8_bits(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """``image`` clamped and rounded, in place, to what an 8-bit file can say."""
    np.clip(image, 0.0, 1.0, out=image)
    np.rint(np.multiply(image, 255.0, out=image), out=image)
    return np.divide(image, 255.0, out=image)
