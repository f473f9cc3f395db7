"""Refuse TIFF files that Pillow reads wrongly, choose their page, and keep libtiff from writing to stderr."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

import numpy as np
from PIL import Image, TiffImagePlugin

from warpvec.image.decoded import page_index

_NEW_SUBFILE_TYPE, _REDUCED = 254, 1
"""The tag of what a page is, and its bit of a smaller copy of another page (TIFF 6, page 36)."""

_RGB, _GREY, _SIGNED = 2, (0, 1), 2
"""Values of the photometric interpretation, and of the sample format."""

_MAX_PAGES = 100
"""Pages that are looked at: a file may have millions."""


class OtherLayout(ValueError):
    """The file is whole, but Pillow reads its samples wrongly. The message says what it has."""


def choose_page(image: TiffImagePlugin.TiffImageFile, page: int | None) -> str | None:
    """Go to a ``page`` of an opened TIFF file, which counts from 1, and return what is left out, in words.

    None is the first page that is no smaller copy of another.

    Raises:
        InputError: the file does not have this page.
    """
    count = image.n_frames
    index, unread = page_index(_first_page(image, count) if page is None else page, count)
    image.seek(index)
    return unread


def _first_page(image: TiffImagePlugin.TiffImageFile, count: int) -> int:
    for index in range(min(count, _MAX_PAGES)):
        image.seek(index)
        if not _is_reduced(image):
            return index + 1
    return 1


def _is_reduced(image: TiffImagePlugin.TiffImageFile) -> bool:
    return bool(image.tag_v2.get(_NEW_SUBFILE_TYPE, 0) & _REDUCED)


def is_negative(image: Image.Image) -> bool:
    """Return whether 0 is white: Pillow inverts such grey TIFF files only of 1 and 8 bits."""
    tags = getattr(image, "tag_v2", {})
    return image.format == "TIFF" and tags.get(TiffImagePlugin.PHOTOMETRIC_INTERPRETATION) == 0


def check_samples(image: Image.Image) -> None:
    """Check that Pillow reads the samples of an opened TIFF file as they are.

    Raises:
        OtherLayout: it reads 16-bit planes as 8-bit ones.
        ValueError: it reads signed samples as unsigned ones, or leaves bands out.
    """
    if not isinstance(image, TiffImagePlugin.TiffImageFile) or not image.tile:
        return
    tags = image.tag_v2
    bits, formats = (max(np.atleast_1d(tags.get(tag, 1))) for tag in (258, 339))
    count, photometric = tags.get(277, 1), tags.get(262)
    if bits in (8, 16) and formats == _SIGNED:
        raise ValueError(f"samples of {bits} bits with a sign, such as heights; save it without, over the whole range")
    if photometric in _GREY and count > len(image.getbands()):
        raise ValueError(f"{count} bands, which are no colours; save one band, or three as RGB")
    if photometric == _RGB and count > len(image.getbands()):
        raise ValueError(f"{count} samples per pixel, and no word on what number 4 is; save it as RGB or RGBA")
    if count > 1 and bits > 8 and not image.use_load_libtiff and tags.get(TiffImagePlugin.PLANAR_CONFIGURATION, 1) == 2:
        raise OtherLayout(f"uncompressed planes of {bits} bits")


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
