"""Read images from files, bytes, PIL images, numpy arrays and torch tensors as sRGB pixels."""

from __future__ import annotations

import json
import os
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias, cast

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from warpvec.checks import check_count
from warpvec.errors import InputError
from warpvec.image.colors import parse_color
from warpvec.image.decode import check_size, decode_file, decode_image, reason_of, undecodable
from warpvec.image.decoded import Decoded, refuse_page
from warpvec.image.doors.table import OTHER_TIFF, TIFF, check_open, door_of
from warpvec.image.quick_files import is_quick
from warpvec.inputs import read_file, too_long
from warpvec.sandbox.run import SandboxError, run_in_sandbox

if TYPE_CHECKING:
    from torch import Tensor

ImageSource: TypeAlias = "str | os.PathLike[str] | bytes | Image.Image | NDArray[Any] | Tensor"

MAX_IMAGE_BYTES = 2**30
"""Largest image file in bytes: more than ``MAX_PIXELS`` of eight bytes, those of RGBA with 16 bits, take uncompressed.
Stops endless streams and devices."""

_KINDS = ("uint8", "uint16", "float32", "bool")
"""Types of the samples of files."""

_HEAD_BYTES = 200
"""More than the line before the samples has."""


class PictureFile(NamedTuple):
    """A picture, and what its file says of it.

    Attributes:
        pixels: as `read_image` returns them.
        unread: what of the file was left out, such as "all but page 2 of 3"; None for nothing.
        meters: width of what the picture shows in the world, as a GeoTIFF states it; None for none.
    """

    pixels: NDArray[np.float32]
    unread: str | None
    meters: float | None


def read_image(source: ImageSource, background: str | None = None, name: str = "image") -> NDArray[np.float32]:
    """Return the pixels of `read_picture`."""
    return read_picture(source, background, name).pixels


def read_picture(
    source: ImageSource, background: str | None = None, name: str = "image", page: int | None = None
) -> PictureFile:
    """Read an image as upright sRGB pixels in [0, 1]: [h, w, 3], or [h, w, 4] if it is transparent.

    An image whose alpha is 1 everywhere counts as RGB. A transparent image is straight RGBA. Its invisible pixels are
    black, whatever colour the file has there.

    Args:
        source: the path or the bytes of a file (see `warpvec.image.decode.FORMATS`; the first frame of an animation), a
            PIL image, or a numpy array or torch tensor. Arrays and tensors are [h, w] or [h, w, 1] grey, [h, w, 2]
            grey and alpha, [h, w, 3] RGB or [h, w, 4] RGBA, of uint8, uint16, bool, or float in [0, 1], in sRGB
            with straight alpha. A tensor may be on any device and may require gradients.
        background: colour behind a transparent image: "#rgb", "#rrggbb" or a CSS colour name; None keeps its alpha.
        name: what messages call ``source``.
        page: of a TIFF or PDF file, from 1; None for the first.

    Raises:
        InputError: the file does not exist, does not have this page, is not a complete image of these formats or has
            more than ``MAX_IMAGE_BYTES``; the image has no pixels, more than ``MAX_PIXELS``, or, if it has alpha, more
            than ``MAX_ALPHA_PIXELS``; an array has the wrong shape, type or range; or ``background`` is not a colour.
    """
    backdrop = None if background is None else parse_color(background)
    if page is not None:
        check_count("page", page, 1)
    samples, unread, meters = _load(source, name, page)
    samples = _unit_samples(samples, name)  # the largest image of a file takes memory that is free from here on
    if backdrop is None and samples.shape[2] in (2, 4) and samples[..., -1].min() < 1:
        pixels = _visible(samples)
    else:
        pixels = _composite(samples, np.ones(3, np.float32) if backdrop is None else backdrop)
    return PictureFile(pixels, unread, meters)


def _load(source: ImageSource, name: str, page: int | None) -> Decoded:
    """Return what ``source`` has; its samples may have any shape and type."""
    if isinstance(source, np.ndarray) or _is_tensor(source):
        refuse_page(page)
        return Decoded(source if isinstance(source, np.ndarray) else _tensor_samples(cast("Tensor", source), name))
    if isinstance(source, Image.Image):
        return decode_image(source, name, page)
    if isinstance(source, bytes | bytearray | memoryview):
        if memoryview(source).nbytes > MAX_IMAGE_BYTES:
            raise too_long(MAX_IMAGE_BYTES, name, f"these {len(source)} bytes")
        return _decode_file(bytes(source), f"these {len(source)} bytes", name, page)
    if isinstance(source, str | os.PathLike):
        label = repr(os.fspath(source))
        if os.path.isdir(source):
            raise InputError(name, "must be an image file", f"the folder {label}", "draw its pictures by warpvec batch")
        return _decode_file(read_file(source, MAX_IMAGE_BYTES, name, "an image file"), label, name, page)
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
        raise InputError(name, rule, f"an error ({reason_of(error)})", "convert it first") from error
    return samples


def _decode_file(data: bytes, label: str, name: str, page: int | None) -> Decoded:
    """Return what a picture file has, decoded here if that is quick, and in the sandbox if it may not be."""
    if is_quick(data):
        return decode_file(data, label, name, page)
    door = door_of(data)
    if door is not None:
        check_open(door, label, name)
        return _decode_in_sandbox(f"doors.{door.work}", data, label, name, page)
    try:
        return _decode_in_sandbox("decode_work", data, label, name, page)
    except InputError as error:
        if error.remedy != OTHER_TIFF or not TIFF.is_open:
            raise
        try:
            return _decode_in_sandbox(f"doors.{TIFF.work}", data, label, name, page)
        except InputError as other:
            if other.name == "page":
                raise
            raise InputError(name, other.rule, other.value, OTHER_TIFF) from None  # Pillow only knows no such kind


def _decode_in_sandbox(work: str, data: bytes, label: str, name: str, page: int | None) -> Decoded:
    try:
        return _received(run_in_sandbox(f"warpvec.image.{work}", data, label=label, name=name, page=page))
    except (SandboxError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise undecodable(reason_of(error), label, name) from None


def _received(result: bytes) -> Decoded:
    """Return what `warpvec.image.decode_work` has sent, which hostile input may have made to send anything.

    Raises:
        ValueError: these are none.
    """
    head, mark, _ = result[:_HEAD_BYTES].partition(b"\n")
    unread, meters, kind, *shape = json.loads(head)
    if kind not in _KINDS or not all(type(side) is int and side > 0 for side in shape):
        raise ValueError("no samples")
    if not (isinstance(unread, str | None) and isinstance(meters, float | None)):
        raise ValueError("no facts")
    return Decoded(np.frombuffer(result, kind, offset=len(head + mark)).reshape(shape), unread, meters)


def _unit_samples(samples: NDArray[Any], name: str) -> NDArray[np.float32]:
    """Return ``samples`` as float32 [h, w, 1 to 4] in [0, 1]."""
    samples = samples[..., None] if samples.ndim == 2 else samples
    if samples.ndim != 3 or samples.shape[2] not in (1, 2, 3, 4):
        raise InputError(name, "must have shape [h, w] or [h, w, 1 to 4]", str(list(samples.shape)), _reshape(samples))
    check_size(samples.shape[1], samples.shape[0], samples.shape[2] in (2, 4), "this array", name)
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
