"""Images in and out: the one place that knows files, colour spaces and alpha.

Read with Pillow and not through imageio: that hands out arrays, which have lost the ICC profile and the key of a
transparent grey. Grey keeps all its bits; of 16 bit colour Pillow decodes the upper 8, an error of at most 1/257.
"""

from __future__ import annotations

import contextlib
import os
import re
import threading
import warnings
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray
from PIL import ExifTags, Image, UnidentifiedImageError

from warpvec.errors import InputError
from warpvec.image.colors import parse_color
from warpvec.image.icc import to_srgb

ImageSource = str | os.PathLike[str] | bytes | Image.Image | NDArray[Any]

MAX_PIXELS = 100_000_000
"""Largest image read. At float32 RGB it takes 1.2 GB, which a machine that fits images has."""

# Named so that no other decoder is tried: Pillow's list has some that start programs (EPS) or that nobody fuzzes.
_FORMATS = ("PNG", "JPEG", "WEBP", "TIFF", "BMP", "GIF")
_FORMAT_NAMES = "PNG, JPEG, WebP, TIFF, BMP or GIF"

# Value of the EXIF tag -> what turns the stored pixels upright (EXIF 2.3, section 4.6.4, tag 0x0112).
_UPRIGHT = {
    2: Image.Transpose.FLIP_LEFT_RIGHT,
    3: Image.Transpose.ROTATE_180,
    4: Image.Transpose.FLIP_TOP_BOTTOM,
    5: Image.Transpose.TRANSPOSE,
    6: Image.Transpose.ROTATE_270,
    7: Image.Transpose.TRANSVERSE,
    8: Image.Transpose.ROTATE_90,
}

# Pillow's size limit and Python's warning filters are global: one thread at a time may change and restore them.
_PILLOW_STATE = threading.Lock()


def read_image(source: ImageSource, background: str | None = None, name: str = "IN") -> NDArray[np.float32]:
    """Pixels [h, w, 3] of an image, or [h, w, 4] if it is transparent, upright, sRGB-encoded in [0, 1].

    An image whose alpha is 1 everywhere is RGB. One that is transparent is RGBA, straight, with black where nothing is
    to be seen: whatever colour the file hides there is gone.

    Args:
        source: a file's path or its bytes (PNG, JPEG, WebP, TIFF, BMP, or GIF; the first frame of an animation), a PIL
            image, or an array [h, w], [h, w, 1] grey, [h, w, 2] grey and alpha, [h, w, 3] RGB or [h, w, 4] RGBA
            of uint8, uint16, bool, or float in [0, 1]. Arrays are taken as sRGB with straight alpha.
        background: what a transparent image is composited over: "#rgb", "#rrggbb" or a CSS colour name; None keeps
            its alpha.
        name: what messages call ``source``.

    Raises:
        InputError: there is no such file, it is no complete image of these formats, it has no pixels or more than
            ``MAX_PIXELS``, the array's shape, type or range is wrong, or ``background`` is not a colour.
    """
    backdrop = None if background is None else parse_color(background)
    samples = _unit_samples(source if isinstance(source, np.ndarray) else _decode(source, name), name)
    if backdrop is None and samples.shape[2] in (2, 4) and samples[..., -1].min() < 1:
        return _visible(samples)
    return _composite(samples, np.ones(3, np.float32) if backdrop is None else backdrop)


def _decode(source: str | os.PathLike[str] | bytes | Image.Image, name: str) -> NDArray[Any]:
    if isinstance(source, Image.Image):
        with _guarded("this PIL image", name):
            return _upright_samples(source, "this PIL image", name)
    if isinstance(source, bytes | bytearray | memoryview):
        return _decode_stream(BytesIO(source), f"these {len(source)} bytes", name)
    if isinstance(source, str | os.PathLike):
        with _open_file(source, name) as stream:
            return _decode_stream(stream, repr(os.fspath(source)), name)
    rule = f"{name} must be a path, bytes, a PIL image or a numpy array"
    raise InputError(f"{rule}, got {type(source).__name__}; convert it to one of these")


def _open_file(source: str | os.PathLike[str], name: str) -> BinaryIO:
    path = Path(source)
    try:
        stream = path.open("rb")
    except (OSError, ValueError) as error:
        rule = f"{name} must be an image file, got {str(path)!r}"
        raise InputError(f"{rule} ({_reason(error)}); check the path") from error
    if stream.seekable():
        return stream
    with stream:
        return BytesIO(stream.read())


def _decode_stream(stream: BinaryIO, label: str, name: str) -> NDArray[Any]:
    if not stream.read(1):
        raise InputError(f"{name} must be a {_FORMAT_NAMES} image, but {label} is empty; export it again")
    stream.seek(0)
    with _guarded(label, name), Image.open(stream, formats=_FORMATS) as image:
        return _upright_samples(image, label, name)


@contextlib.contextmanager
def _guarded(label: str, name: str) -> Iterator[None]:
    """Pillow under our limit, without its warnings, and with each of its many exceptions on bad bytes as ours."""
    with _PILLOW_STATE, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        warnings.simplefilter("error", Image.DecompressionBombWarning)
        limit, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, MAX_PIXELS
        try:
            yield
        except (InputError, MemoryError):
            raise
        except Exception as error:
            raise InputError(_complaint(error, label, name)) from error
        finally:
            Image.MAX_IMAGE_PIXELS = limit


def _complaint(error: Exception, label: str, name: str) -> str:
    if isinstance(error, Image.DecompressionBombWarning | Image.DecompressionBombError):
        found = re.search(r"\d+ pixels", str(error))
        return _too_large(found[0] if found else "more", label, name)
    rule = f"{name} must be a complete {_FORMAT_NAMES} image"
    if isinstance(error, UnidentifiedImageError):
        return f"{rule}, but {label} is not recognised as one; save it as PNG or JPEG"
    return f"{rule}, but {label} cannot be decoded ({_reason(error)}); export it again"


def _reason(error: Exception) -> str:
    text = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
    return " ".join(text.split())[:100] or type(error).__name__


def _too_large(found: str, label: str, name: str) -> str:
    return f"{name} must have at most {MAX_PIXELS} pixels, but {label} has {found}; reduce it first"


def _check_size(width: int, height: int, label: str, name: str) -> None:
    if width < 1 or height < 1:
        raise InputError(f"{name} must have pixels, but {label} has {width} x {height}; check where it comes from")
    if width * height > MAX_PIXELS:
        raise InputError(_too_large(f"{width} x {height}", label, name))


def _upright_samples(image: Image.Image, label: str, name: str) -> NDArray[Any]:
    """The samples of a PIL image as an array of the kinds that ``read_image`` takes."""
    _check_size(*image.size, label, name)
    image.load()
    # After load: the TIFF decoder turns the image itself and then removes the tag.
    # Not ImageOps.exif_transpose: it writes the whole EXIF block anew and fails on tags that it cannot encode.
    turn = _UPRIGHT.get(image.getexif().get(ExifTags.Base.Orientation, 1))
    image = image if turn is None else image.transpose(turn)
    if image.mode in ("I", "F") or image.mode.startswith("I;16"):
        return _wide_samples(image, label, name)
    color = np.asarray(to_srgb(image))
    if not image.has_transparency_data:
        return color
    return np.dstack([color, np.asarray(image.convert("RGBA").getchannel("A"))])


def _wide_samples(image: Image.Image, label: str, name: str) -> NDArray[Any]:
    """Grey of more than 8 bits. Pillow's own conversion to RGB clips it at 255 instead of scaling."""
    samples = np.asarray(image)
    if image.mode == "F":
        return samples
    if samples.min() < 0 or samples.max() > 65535:
        raise InputError(f"{name} must have 8 or 16 bits a channel, but {label} has 32; save it with 16")
    grey = samples.astype(np.uint16)
    color, key = _grey_to_srgb(image, grey), image.info.get("transparency")
    if key is None:
        return color
    return np.dstack([color, np.where(grey == key, 0, 65535).astype(np.uint16)])


def _grey_to_srgb(image: Image.Image, grey: NDArray[np.uint16]) -> NDArray[np.uint16]:
    """16 bit grey through its profile: the colour engine returns 8 bits, so its 256 levels are interpolated."""
    if "icc_profile" not in image.info:
        return grey
    ramp = Image.linear_gradient("L").resize((1, 256))
    ramp.info["icc_profile"] = image.info["icc_profile"]
    levels = np.asarray(to_srgb(ramp))[:, 0, 0] * 257.0
    curve: NDArray[np.uint16] = np.interp(np.arange(65536) / 257.0, np.arange(256), levels).round().astype(np.uint16)
    return curve[grey]


def _unit_samples(samples: NDArray[Any], name: str) -> NDArray[np.float32]:
    """``samples`` as float32 [h, w, 1 to 4] in [0, 1]."""
    samples = samples[..., None] if samples.ndim == 2 else samples
    if samples.ndim != 3 or samples.shape[2] not in (1, 2, 3, 4):
        rule = "must have shape [h, w] or [h, w, 1 to 4]"
        raise InputError(f"{name} {rule}, got {list(samples.shape)}; put channels last and take one image of a batch")
    _check_size(samples.shape[1], samples.shape[0], "this array", name)
    if samples.dtype == np.bool_:
        return samples.astype(np.float32)
    if samples.dtype.kind == "u" and samples.dtype.itemsize <= 2:
        return np.asarray(samples, np.float32) / np.float32(np.iinfo(samples.dtype).max)
    return _unit_floats(samples, name)


def _unit_floats(samples: NDArray[Any], name: str) -> NDArray[np.float32]:
    if samples.dtype.kind != "f":
        raise InputError(f"{name} must be uint8, uint16, bool or float, got {samples.dtype}; convert it with astype")
    low, high = samples.min(), samples.max()
    if not (np.isfinite(low) and np.isfinite(high)):
        raise InputError(f"{name} must be finite, got values that are NaN or infinite; replace them")
    if low < 0 or high > 1:
        raise InputError(f"{name} must lie in [0, 1], got {low:g} to {high:g}; clip it, or pass 8 bit values as uint8")
    return samples.astype(np.float32)


def _visible(samples: NDArray[np.float32]) -> NDArray[np.float32]:
    """RGBA [h, w, 4] of ``samples`` [h, w, 2 or 4], without the colours that alpha hides wholly."""
    alpha = samples[..., -1]
    pixels = np.empty((*alpha.shape, 4), np.float32)
    pixels[..., :3], pixels[..., 3] = samples[..., :-1], alpha
    pixels[alpha == 0] = 0.0
    return pixels


def _composite(samples: NDArray[np.float32], backdrop: NDArray[np.float32]) -> NDArray[np.float32]:
    """Colour [h, w, 3] of ``samples`` [h, w, 1 to 4] over ``backdrop`` [3], blended as encoded, as SVG viewers do."""
    height, width, channel_count = samples.shape
    if channel_count == 3:
        return np.ascontiguousarray(samples)
    if channel_count == 1:
        return samples.repeat(3, -1)
    color, alpha = np.broadcast_to(samples[..., :-1], (height, width, 3)), samples[..., -1]
    blended = np.empty((height, width, 3), np.float32)
    # By channel: a broadcast over a last axis of 3 takes twice as long and twice the memory.
    for channel in range(3):
        blended[..., channel] = color[..., channel] * alpha + backdrop[channel] * (1 - alpha)
    return blended
