"""Decode picture files with Pillow.

Not with imageio, whose arrays have lost the ICC profile and the transparent level of a grey image. Grey images keep all
their bits. Of 16-bit colours Pillow decodes the upper 8 bits, an error of at most 1/257.
"""

from __future__ import annotations

import contextlib
import functools
import re
import threading
import warnings
from collections.abc import Iterator
from io import BytesIO
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import ExifTags, Image, TiffImagePlugin, UnidentifiedImageError

from warpvec.errors import InputError
from warpvec.image import tiff
from warpvec.image.decoded import Decoded, refuse_page
from warpvec.image.doors.table import OTHER_TIFF, RULE, remedy_of
from warpvec.image.icc import to_srgb
from warpvec.image.jpeg2000 import check_depth
from warpvec.image.pam import PAM_MARK, pam_samples
from warpvec.image.png_colors import in_srgb, png_curve, png_matrix
from warpvec.image.quick_files import MAX_SCANS, scan_count
from warpvec.image.tiff import check_tiles, silent_libtiff
from warpvec.image.world import world_width

MAX_PIXELS = 50_000_000
"""Largest image in pixels, four times a photo of a phone: a run that fits and measures it takes less than 2 GB."""

MAX_ALPHA_PIXELS = 37_500_000
"""Largest image with alpha: as many samples as the largest RGB image has, so that it takes no more memory."""

# Only these decoders are tried: some of Pillow's others start programs (EPS). TGA comes last, as it has no signature.
FORMATS = (
    "PNG", "JPEG", "WEBP", "TIFF", "BMP", "GIF", "AVIF", "PPM", "PSD", "ICO", "ICNS", "QOI", "PCX", "DDS", "JPEG2000",
    "TGA",
)  # fmt: skip

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


def decode_file(
    data: bytes, label: str, name: str, page: int | None = None, formats: tuple[str, ...] = FORMATS
) -> Decoded:
    """Return what a picture file has.

    Args:
        data: bytes of the file.
        label: what messages call them.
        name: what messages call the argument.
        page: of a TIFF file, from 1; None for the first that is no smaller copy of another.
        formats: Pillow's names of the formats that are tried.

    Raises:
        InputError: it is not a complete picture, has too many pixels or scans, or does not have the page.
    """
    with guarded(label, name):
        if not data:
            remedy = "export it again"
            raise InputError(name, RULE, f"{label}, which is empty", remedy)
        if scan_count(data) > MAX_SCANS:
            raise InputError(name, f"must have at most {MAX_SCANS} scans", f"more in {label}", "save it as PNG")
        if data.startswith(PAM_MARK):
            refuse_page(page)
            check = functools.partial(check_size, label=label, name=name)
            return Decoded(pam_samples(data, check))
        try:
            image = Image.open(BytesIO(data), formats=formats)
        except UnidentifiedImageError as error:
            raise InputError(name, RULE, f"{label}, which is not recognised as one", remedy_of(data)) from error
        with image:
            if image.format == "JPEG2000":
                check_depth(data)
            return _decoded(image, label, name, png_matrix(data), page)


def decode_image(image: Image.Image, name: str, page: int | None = None) -> Decoded:
    """Return what a PIL image has; see `decode_file`."""
    with guarded("this PIL image", name):
        return _decoded(image, "this PIL image", name, page=page)


@contextlib.contextmanager
def guarded(label: str, name: str) -> Iterator[None]:
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
    if isinstance(error, tiff.OtherLayout):
        return InputError(name, RULE, f"{label}, which has {error}", OTHER_TIFF)
    return undecodable(reason_of(error), label, name)


def undecodable(reason: str, label: str, name: str) -> InputError:
    """Return the error for a file that cannot be decoded for this ``reason``."""
    return InputError(name, RULE, f"{label}, which cannot be decoded ({reason})", "export it again")


def reason_of(error: Exception) -> str:
    """Return the message of an exception in one short line."""
    text = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
    return " ".join(text.split())[:100] or type(error).__name__


def _too_large(found: str, label: str, name: str) -> InputError:
    return InputError(name, f"must have at most {MAX_PIXELS} pixels", f"{found} in {label}", "reduce it first")


def check_size(width: int, height: int, has_alpha: bool, label: str, name: str) -> None:
    """Raise `InputError` if a picture has no pixels or too many."""
    if width < 1 or height < 1:
        raise InputError(name, "must have pixels", f"{width} x {height} in {label}", "check where it comes from")
    if width * height > MAX_PIXELS:
        raise _too_large(f"{width} x {height}", label, name)
    if has_alpha and width * height > MAX_ALPHA_PIXELS:
        rule = f"must have at most {MAX_ALPHA_PIXELS} pixels if it has alpha"
        raise InputError(name, rule, f"{width} x {height} in {label}", "reduce it first")


def _decoded(
    image: Image.Image, label: str, name: str, matrix: NDArray[np.float64] | None = None, page: int | None = None
) -> Decoded:
    """Return what a PIL image has. ``matrix`` [3, 3] turns its linear colours into those of sRGB."""
    if getattr(image, "default_image", False) and getattr(image, "n_frames", 1) > 1:
        image.seek(1)  # of an APNG, whose default image is for programs that know no APNG
    if not isinstance(image, TiffImagePlugin.TiffImageFile):
        refuse_page(page)
        return Decoded(_upright_samples(image, label, name, matrix))
    unread, meters = tiff.choose_page(image, page), world_width(image)
    return Decoded(_upright_samples(image, label, name, matrix), unread, meters)


def _upright_samples(image: Image.Image, label: str, name: str, matrix: NDArray[np.float64] | None) -> NDArray[Any]:
    """Return the samples of a PIL image as an array that ``read_image`` takes."""
    check_size(*image.size, image.has_transparency_data, label, name)
    tiff.check_samples(image)
    check_tiles(image)
    image.load()
    outside = _outside(image)
    # The tag is read after loading, because the TIFF decoder turns the image itself and then removes the tag.
    # ImageOps.exif_transpose is not used: it rewrites the whole EXIF block and fails on tags that it cannot encode.
    turn = _UPRIGHT.get(image.getexif().get(ExifTags.Base.Orientation, 1))
    image = image if turn is None else image.transpose(turn)
    if image.mode in ("I", "F") or image.mode.startswith("I;16"):
        return _wide_samples(image, label, name)
    color = np.asarray(to_srgb(image))
    curve = png_curve(image.info)
    if curve is not None:
        color = (curve * 255).round().astype(np.uint8)[color]
    if matrix is not None:
        color = in_srgb(color, matrix)
    if not image.has_transparency_data and outside is None:
        return color
    alpha = np.array(image.convert("RGBA").getchannel("A"))
    if outside is not None:
        alpha[outside] = 0
    return np.dstack([color, alpha])


def _outside(image: Image.Image) -> NDArray[np.bool_] | None:
    """Return what the first frame of a GIF leaves open of its screen [h, w]: transparent, as in browsers."""
    if image.format != "GIF" or getattr(image, "dispose_extent", None) is None:
        return None
    left, top, right, bottom = image.dispose_extent  # type: ignore[attr-defined]
    outside = np.ones((image.height, image.width), bool)
    outside[top:bottom, left:right] = False
    return outside if outside.any() else None


def _wide_samples(image: Image.Image, label: str, name: str) -> NDArray[Any]:
    """Return grey samples of more than 8 bits, which Pillow's own conversion to RGB would clip at 255."""
    samples = np.asarray(image)
    if image.mode == "F":
        low, high = samples.min(), samples.max()
        if not (low >= 0 and high <= 1):  # NaN too, which is both of them
            found = f"{low:g} to {high:g} in {label}".replace("nan to nan", "NaN")
            raise InputError(name, "must have numbers in [0, 1]", found, "save it with 8 or 16 bits per channel")
        return 1 - samples if tiff.is_negative(image) else samples
    if samples.min() < 0 or samples.max() > 65535:
        raise InputError(name, "must have 8 or 16 bits per channel", f"32 in {label}", "save it with 16 bits")
    grey = samples.astype(np.uint16)
    if tiff.is_negative(image):
        grey = 65535 - grey
    color, key = _grey_to_srgb(image, grey), image.info.get("transparency")
    if key is None:
        return color
    return np.dstack([color, np.where(grey == key, 0, 65535).astype(np.uint16)])


def _grey_to_srgb(image: Image.Image, grey: NDArray[np.uint16]) -> NDArray[np.uint16]:
    """Convert 16-bit grey by its profile. The colour engine returns 8 bits, so its 256 levels are interpolated."""
    gamma = png_curve(image.info, 65536)
    if gamma is not None:
        toned: NDArray[np.uint16] = (gamma * 65535).round().astype(np.uint16)[grey]
        return toned
    if "icc_profile" not in image.info:
        return grey
    ramp = Image.linear_gradient("L").resize((1, 256))
    ramp.info["icc_profile"] = image.info["icc_profile"]
    levels = np.asarray(to_srgb(ramp))[:, 0, 0] * 257.0
    curve: NDArray[np.uint16] = np.interp(np.arange(65536) / 257.0, np.arange(256), levels).round().astype(np.uint16)
    return curve[grey]
