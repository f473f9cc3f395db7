"""TIFF files of colours that Pillow refuses, by tifffile: RGB with 16 bits or floating point, CMYK with alpha."""

from __future__ import annotations

from io import BytesIO
from typing import Any

import numpy as np
import tifffile
from numpy.typing import NDArray
from PIL import Image

from warpvec.image.alpha import straight
from warpvec.image.decode import check_size, guarded
from warpvec.image.decode_work import sent
from warpvec.image.decoded import Decoded, page_index
from warpvec.image.icc import to_srgb

_COLOR_COUNTS = {tifffile.PHOTOMETRIC.RGB: 3, tifffile.PHOTOMETRIC.MINISBLACK: 1, tifffile.PHOTOMETRIC.SEPARATED: 4}
_ALPHA = (tifffile.EXTRASAMPLE.ASSOCALPHA, tifffile.EXTRASAMPLE.UNASSALPHA)
_UPRIGHT = 1
"""Value of the tag of the orientation."""


def work(data: bytes, label: str, name: str, page: int | None) -> list[bytes | memoryview]:
    """Return what `warpvec.image.decode_work.work` does."""
    with guarded(label, name), tifffile.TiffFile(BytesIO(data)) as file:
        pages = file.pages
        first = next((k + 1 for k, each in enumerate(pages) if not each.is_reduced), 1)
        index, unread = page_index(first if page is None else page, len(pages))
        found = pages[index]
        assert isinstance(found, tifffile.TiffPage)
        check_size(found.imagewidth, found.imagelength, bool(found.extrasamples), label, name)
        return sent(Decoded(_samples(found), unread))


def _samples(page: tifffile.TiffPage) -> NDArray[Any]:
    """Return colours and alpha of ``page`` [h, w, 1 to 4], in sRGB.

    Raises:
        ValueError: it has other samples.
    """
    count = _COLOR_COUNTS.get(page.photometric, 0)
    extra = page.samplesperpixel - count
    if not count or not (extra == 0 or (extra == 1 and page.extrasamples[0] in _ALPHA)):
        raise ValueError("samples that are no colours")
    if len(page.dataoffsets) != np.prod(page.chunked) or not all(page.databytecounts):  # else they would be black
        raise ValueError("strips are missing")
    tag = page.tags.get(274)
    if tag is not None and tag.value != _UPRIGHT:
        raise ValueError("a turned picture; save it upright")
    samples: NDArray[Any] = page.asarray()
    if page.samplesperpixel > 1 and page.planarconfig == tifffile.PLANARCONFIG.SEPARATE:
        samples = samples.transpose(1, 2, 0)
    samples = samples.reshape(page.imagelength, page.imagewidth, page.samplesperpixel)
    if samples.dtype.kind == "f":
        samples = _unit(samples.astype(np.float32))
    elif samples.dtype not in (np.uint8, np.uint16):
        raise ValueError(f"samples of the type {samples.dtype}; save it with 8 or 16 bits")
    alpha = samples[..., count:]
    colors = _in_srgb(samples[..., :count], page.tags.get(34675))
    if extra == 0:
        return colors
    pixels: NDArray[np.float32] = np.dstack([np.broadcast_to(_floats(colors), (*colors.shape[:2], 3)), _floats(alpha)])
    return straight(pixels) if page.extrasamples[0] == _ALPHA[0] else pixels


def _unit(samples: NDArray[np.float32]) -> NDArray[np.float32]:
    if not (samples.min() >= 0.0 and samples.max() <= 1.0):  # NaN too
        raise ValueError("numbers outside of [0, 1]; save it with 8 or 16 bits per channel")
    return samples


def _floats(samples: NDArray[Any]) -> NDArray[np.float32]:
    full = np.iinfo(samples.dtype).max if samples.dtype.kind == "u" else 1
    return samples.astype(np.float32) / np.float32(full)


def _in_srgb(colors: NDArray[Any], profile: Any) -> NDArray[Any]:
    """Return ``colors`` [h, w, 1, 3 or 4] as they are, or by their ``profile`` with 8 bits, as all CMYK."""
    if colors.shape[2] != 4 and profile is None:
        return colors
    levels = (_floats(colors) * 255.0).round().astype(np.uint8)
    image = Image.fromarray(
        levels[..., 0] if levels.shape[2] == 1 else levels, {1: "L", 3: "RGB", 4: "CMYK"}[levels.shape[2]]
    )
    if profile is not None:
        image.info["icc_profile"] = bytes(profile.value)
    return np.asarray(to_srgb(image))
