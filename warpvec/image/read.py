"""Read images from files, bytes, PIL images, numpy arrays and torch tensors as sRGB pixels.

Files are read with Pillow and not with imageio, whose arrays have lost the ICC profile and the transparent level of a
grey image. Grey images keep all their bits. Of 16-bit colours Pillow decodes the upper 8 bits, an error of at most
1/257.
"""

from __future__ import annotations

import contextlib
import os
import re
import threading
import warnings
from collections.abc import Iterator
from io import BytesIO
from typing import TYPE_CHECKING, Any, BinaryIO, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray
from PIL import ExifTags, Image, UnidentifiedImageError

from warpvec.errors import InputError
from warpvec.image.colors import parse_color
from warpvec.image.icc import to_srgb
from warpvec.image.tiff import check_tiles, silent_libtiff
from warpvec.inputs import read_file, too_long

if TYPE_CHECKING:
    from torch import Tensor

ImageSource: TypeAlias = "str | os.PathLike[str] | bytes | Image.Image | NDArray[Any] | Tensor"

MAX_PIXELS = 50_000_000
"""Largest image in pixels, four times a photo of a phone: a run that fits and measures it takes less than 2 GB."""

MAX_IMAGE_BYTES = 2**30
"""Largest image file in bytes: more than ``MAX_PIXELS`` of eight bytes, those of RGBA with 16 bits, take uncompressed.
Stops endless streams and devices."""

MAX_ALPHA_PIXELS = 37_500_000
"""Largest image with alpha: as many samples as the largest RGB image has, so that it takes no more memory."""

# Only these decoders are tried: some of Pillow's others start programs (EPS) or have never been fuzzed.
_FORMATS = ("PNG", "JPEG", "WEBP", "TIFF", "BMP", "GIF")
_FORMAT_NAMES = "PNG, JPEG, WebP, TIFF, BMP or GIF"

# Value of the EXIF orientation tag -> operation that turns the pixels upright (EXIF 2.3, section 4.6.4, tag 0x0112).
_UPRIGHT = {
    2: Image.Transpose.FLIP_LEFT_RIGHT,
    3: Image.Transpose.ROTATE_180,
    4: Image.Transpose.FLIP_TOP_BOTTOM,
    5: Image.Transpose.TRANSPOSE,
    6: Image.Transpose.ROTATE_270,
    7: Image.Transpose.TRANSVERSE,
    8: Image.Transpose.ROTATE_90,
}

# Pillow's size limit and Python's warning filters are global, so only one thread at a time may change them.
_PILLOW_STATE = threading.Lock()


def read_image(source: ImageSource, background: str | None = None, name: str = "image") -> NDArray[np.float32]:
    """Read an image as upright sRGB pixels in [0, 1]: [h, w, 3], or [h, w, 4] if it is transparent.

    An image whose alpha is 1 everywhere counts as RGB. A transparent image is straight RGBA. Its invisible pixels are
    black, whatever colour the file has there.

    Args:
        source: the path or the bytes of a file (PNG, JPEG, WebP, TIFF, BMP, or GIF; the first frame of an animation), a
            PIL image, or a numpy array or torch tensor. Arrays and tensors are [h, w] or [h, w, 1] grey, [h, w, 2]
            grey and alpha, [h, w, 3] RGB or [h, w, 4] RGBA, of uint8, uint16, bool, or float in [0, 1], in sRGB
            with straight alpha. A tensor may be on any device and may require gradients.
        background: colour behind a transparent image: "#rgb", "#rrggbb" or a CSS colour name; None keeps its alpha.
        name: what messages call ``source``.

    Raises:
        InputError: the file does not exist, is not a complete image of these formats or has more than
            ``MAX_IMAGE_BYTES``; the image has no pixels, more than ``MAX_PIXELS``, or, if it has alpha, more than
            ``MAX_ALPHA_PIXELS``; an array has the wrong shape, type
            or range; or ``background`` is not a colour.
    """
    backdrop = None if background is None else parse_color(background)
    samples = _unit_samples(_load(source, name), name)
    if backdrop is None and samples.shape[2] in (2, 4) and samples[..., -1].min() < 1:
        return _visible(samples)
    return _composite(samples, np.ones(3, np.float32) if backdrop is None else backdrop)


def _load(source: ImageSource, name: str) -> NDArray[Any]:
    """Return the samples of ``source`` as an array of any shape and type."""
    if isinstance(source, np.ndarray):
        return source
    if _is_tensor(source):
        return _tensor_samples(cast("Tensor", source), name)
    if isinstance(source, Image.Image):
        with _guarded("this PIL image", name):
            return _upright_samples(source, "this PIL image", name)
    if isinstance(source, bytes | bytearray | memoryview):
        if memoryview(source).nbytes > MAX_IMAGE_BYTES:
            raise too_long(MAX_IMAGE_BYTES, name, f"these {len(source)} bytes")
        return _decode_stream(BytesIO(source), f"these {len(source)} bytes", name)
    if isinstance(source, str | os.PathLike):
        data = read_file(source, MAX_IMAGE_BYTES, name, "an image file")
        return _decode_stream(BytesIO(data), repr(os.fspath(source)), name)
    rule = "must be a path, bytes, a PIL image, a numpy array or a torch tensor"
    raise InputError(name, rule, type(source).__name__, "convert it")


def _is_tensor(source: object) -> bool:
    # By name, since importing torch takes longer than reading an image.
    return any(kind.__name__ == "Tensor" and kind.__module__ == "torch" for kind in type(source).__mro__)


def _tensor_samples(tensor: Tensor, name: str) -> NDArray[Any]:
    try:
        tensor = tensor.detach().cpu()
        # numpy has no bfloat16.
        samples: NDArray[Any] = (tensor.float() if str(tensor.dtype) == "torch.bfloat16" else tensor).numpy()
    except (TypeError, RuntimeError) as error:
        rule = "must be a tensor that can be converted to a numpy array"
        raise InputError(name, rule, f"an error ({_reason(error)})", "convert it first") from error
    return samples


def _decode_stream(stream: BinaryIO, label: str, name: str) -> NDArray[Any]:
    with _guarded(label, name):
        if not stream.read(1):
            remedy = "export it again"
            raise InputError(name, f"must be a {_FORMAT_NAMES} image", f"{label}, which is empty", remedy)
        stream.seek(0)
        with Image.open(stream, formats=_FORMATS) as image:
            return _upright_samples(image, label, name)


@contextlib.contextmanager
def _guarded(label: str, name: str) -> Iterator[None]:
    """Run Pillow with ``MAX_PIXELS`` and without warnings; turn its many exceptions for bad bytes into `InputError`."""
    with _PILLOW_STATE, warnings.catch_warnings(), silent_libtiff():
        warnings.simplefilter("ignore")
        warnings.simplefilter("error", Image.DecompressionBombWarning)
        limit, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, MAX_PIXELS
        try:
            yield
        except (InputError, MemoryError):
            raise
        except Exception as error:
            raise _refusal(error, label, name) from error
        finally:
            Image.MAX_IMAGE_PIXELS = limit


def _refusal(error: Exception, label: str, name: str) -> InputError:
    if isinstance(error, Image.DecompressionBombWarning | Image.DecompressionBombError):
        found = re.search(r"\d+ pixels", str(error))
        return _too_large(found[0] if found else "more", label, name)
    rule = f"must be a complete {_FORMAT_NAMES} image"
    if isinstance(error, UnidentifiedImageError):
        return InputError(name, rule, f"{label}, which is not recognised as one", "save it as PNG or JPEG")
    return InputError(name, rule, f"{label}, which cannot be decoded ({_reason(error)})", "export it again")


def _reason(error: Exception) -> str:
    text = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
    return " ".join(text.split())[:100] or type(error).__name__


def _too_large(found: str, label: str, name: str) -> InputError:
    return InputError(name, f"must have at most {MAX_PIXELS} pixels", f"{found} in {label}", "reduce it first")


def _check_size(width: int, height: int, has_alpha: bool, label: str, name: str) -> None:
    if width < 1 or height < 1:
        raise InputError(name, "must have pixels", f"{width} x {height} in {label}", "check where it comes from")
    if width * height > MAX_PIXELS:
        raise _too_large(f"{width} x {height}", label, name)
    if has_alpha and width * height > MAX_ALPHA_PIXELS:
        rule = f"must have at most {MAX_ALPHA_PIXELS} pixels if it has alpha"
        raise InputError(name, rule, f"{width} x {height} in {label}", "reduce it first")


def _upright_samples(image: Image.Image, label: str, name: str) -> NDArray[Any]:
    """Return the samples of a PIL image as an array that ``read_image`` takes."""
    _check_size(*image.size, image.has_transparency_data, label, name)
    check_tiles(image)
    image.load()
    # The tag is read after loading, because the TIFF decoder turns the image itself and then removes the tag.
    # ImageOps.exif_transpose is not used: it rewrites the whole EXIF block and fails on tags that it cannot encode.
    turn = _UPRIGHT.get(image.getexif().get(ExifTags.Base.Orientation, 1))
    image = image if turn is None else image.transpose(turn)
    if image.mode in ("I", "F") or image.mode.startswith("I;16"):
        return _wide_samples(image, label, name)
    color = np.asarray(to_srgb(image))
    if not image.has_transparency_data:
        return color
    return np.dstack([color, np.asarray(image.convert("RGBA").getchannel("A"))])


def _wide_samples(image: Image.Image, label: str, name: str) -> NDArray[Any]:
    """Return grey samples of more than 8 bits, which Pillow's own conversion to RGB would clip at 255."""
    samples = np.asarray(image)
    if image.mode == "F":
        return samples
    if samples.min() < 0 or samples.max() > 65535:
        raise InputError(name, "must have 8 or 16 bits per channel", f"32 in {label}", "save it with 16 bits")
    grey = samples.astype(np.uint16)
    color, key = _grey_to_srgb(image, grey), image.info.get("transparency")
    if key is None:
        return color
    return np.dstack([color, np.where(grey == key, 0, 65535).astype(np.uint16)])


def _grey_to_srgb(image: Image.Image, grey: NDArray[np.uint16]) -> NDArray[np.uint16]:
    """Convert 16-bit grey by its profile. The colour engine returns 8 bits, so its 256 levels are interpolated."""
    if "icc_profile" not in image.info:
        return grey
    ramp = Image.linear_gradient("L").resize((1, 256))
    ramp.info["icc_profile"] = image.info["icc_profile"]
    levels = np.asarray(to_srgb(ramp))[:, 0, 0] * 257.0
    curve: NDArray[np.uint16] = np.interp(np.arange(65536) / 257.0, np.arange(256), levels).round().astype(np.uint16)
    return curve[grey]


def _unit_samples(samples: NDArray[Any], name: str) -> NDArray[np.float32]:
    """Return ``samples`` as float32 [h, w, 1 to 4] in [0, 1]."""
    samples = samples[..., None] if samples.ndim == 2 else samples
    if samples.ndim != 3 or samples.shape[2] not in (1, 2, 3, 4):
        raise InputError(name, "must have shape [h, w] or [h, w, 1 to 4]", str(list(samples.shape)), _reshape(samples))
    _check_size(samples.shape[1], samples.shape[0], samples.shape[2] in (2, 4), "this array", name)
    if samples.dtype == np.bool_:
        return samples.astype(np.float32)
    if samples.dtype.kind == "u" and samples.dtype.itemsize <= 2:
        unit = samples.astype(np.float32)
        unit /= np.float32(np.iinfo(samples.dtype).max)  # in place: of the largest image a copy takes 1.6 GB
        return unit
    return _unit_floats(samples, name)


def _reshape(samples: NDArray[Any]) -> str:
    """Return what to do with an array of a wrong shape."""
    if samples.ndim == 3 and samples.shape[0] <= 4:
        return "its channels come first: give tensor.permute(1, 2, 0) or array.transpose(1, 2, 0)"
    if samples.ndim == 4:
        return "give one image of the batch, with its channels last"
    return "put channels last"


def _unit_floats(samples: NDArray[Any], name: str) -> NDArray[np.float32]:
    if samples.dtype.kind != "f":
        raise InputError(name, "must be uint8, uint16, bool or float", str(samples.dtype), "convert it")
    low, high = samples.min(), samples.max()
    if not (np.isfinite(low) and np.isfinite(high)):
        raise InputError(name, "must be finite", "NaN or infinite values", "replace them")
    if low < 0 or high > 1:
        remedy = "clip it, or pass 8-bit values as uint8"
        raise InputError(name, "must be in [0, 1]", f"{low:g} to {high:g}", remedy)
    return samples.astype(np.float32)


def _visible(samples: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return RGBA [h, w, 4] of ``samples`` [h, w, 2 or 4], which may change, with black for invisible colours."""
    pixels = samples
    if samples.shape[2] == 2:
        pixels = np.empty((*samples.shape[:2], 4), np.float32)
        pixels[..., :3], pixels[..., 3] = samples[..., :1], samples[..., 1]
    pixels *= pixels[..., 3:] != 0
    return pixels


def _composite(samples: NDArray[np.float32], backdrop: NDArray[np.float32]) -> NDArray[np.float32]:
    """Composite ``samples`` [h, w, 1 to 4] over ``backdrop`` [3], blended as encoded, as SVG viewers do: [h, w, 3]."""
    height, width, channel_count = samples.shape
    if channel_count == 3:
        return np.ascontiguousarray(samples)
    if channel_count == 1:
        return samples.repeat(3, -1)
    color, alpha = np.broadcast_to(samples[..., :-1], (height, width, 3)), samples[..., -1]
    blended = np.empty((height, width, 3), np.float32)
    # One channel at a time: a broadcast over a last axis of 3 takes twice as long and twice the memory.
    for channel in range(3):
        blended[..., channel] = color[..., channel] * alpha + backdrop[channel] * (1 - alpha)
    return blended
