"""Refuse TIFF files with missing strips, and keep libtiff from writing to stderr: Pillow does neither."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

from PIL import Image, TiffImagePlugin


def check_tiles(image: Image.Image) -> None:
    """Check that an opened TIFF file names a place for each of its uncompressed strips or tiles.

    Pillow leaves the pixels of strips that are not named black. libtiff, which reads compressed files, refuses them.

    Raises:
        ValueError: strips or tiles are missing.
    """
    if not isinstance(image, TiffImagePlugin.TiffImageFile) or image.use_load_libtiff or not image.tile:
        return  # an image without tiles is already loaded, or Pillow refuses it
    # Each band of a planar file has strips of its own.
    is_planar = image.tag_v2.get(TiffImagePlugin.PLANAR_CONFIGURATION, 1) == 2
    needed = image.width * image.height * (len(image.getbands()) if is_planar else 1)
    extents = [tile.extents for tile in image.tile if tile.extents is not None]
    if sum((right - left) * (bottom - top) for left, top, right, bottom in extents) < needed:
        raise ValueError("strips are missing")


@contextmanager
def silent_libtiff() -> Iterator[None]:
    """Keep libtiff from writing its errors to stderr: Pillow raises an exception for each that matters.

    The setting holds for all threads, so only one thread at a time may use this. Where Pillow contains libtiff as a
    private part, as on Windows, nothing changes.
    """
    set_handler = _error_handler_setter()
    if set_handler is None:
        yield
        return
    before = set_handler(None)
    try:
        yield
    finally:
        set_handler(before)


@cache
def _error_handler_setter() -> Any:
    """Return ``TIFFSetErrorHandler`` of Pillow's libtiff, which returns the handler before; None if out of reach."""
    try:
        setter = ctypes.CDLL(Image.core.__file__).TIFFSetErrorHandler  # type: ignore[attr-defined]
    except (OSError, AttributeError):
        return None
    setter.argtypes, setter.restype = [ctypes.c_void_p], ctypes.c_void_p
    return setter
