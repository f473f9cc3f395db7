"""Small valid files of each kind, which together use most features that a reader may meet."""

from __future__ import annotations

import io
from functools import cache

import numpy as np
from PIL import Image, ImageCms


@cache
def seeds(kind: str) -> list[bytes]:
    """Return the files of ``kind``, one of `KINDS`."""
    return _MAKERS[kind]()


def _pngs() -> list[bytes]:
    grey16 = Image.fromarray(np.arange(54, dtype=np.uint16).reshape(6, 9) * 1000)
    exif = Image.Exif()
    exif[0x0112] = 6
    return [
        _encoded("PNG", _pixels("RGB"), exif=exif), _encoded("PNG", _pixels("RGBA")), _encoded("PNG", grey16),
        _encoded("PNG", _pixels("P"), transparency=3), _encoded("PNG", _pixels("LA")), _encoded("PNG", _pixels("1")),
        _encoded("PNG", _pixels("RGB"), icc_profile=_profile()),
        _encoded("PNG", _pixels("RGB"), save_all=True, append_images=[_pixels("RGB", 1)]),
    ]  # fmt: skip


def _jpegs() -> list[bytes]:
    exif = Image.Exif()
    exif[0x0112], exif[0x010F] = 3, "maker"
    return [
        _encoded("JPEG", _pixels("RGB"), exif=exif), _encoded("JPEG", _pixels("L")),
        _encoded("JPEG", _pixels("CMYK")), _encoded("JPEG", _pixels("RGB"), progressive=True),
        _encoded("JPEG", _pixels("RGB"), icc_profile=_profile(), subsampling=0),
    ]  # fmt: skip


def _webps() -> list[bytes]:
    return [
        _encoded("WEBP", _pixels("RGB")), _encoded("WEBP", _pixels("RGBA")),
        _encoded("WEBP", _pixels("RGBA"), lossless=True), _encoded("WEBP", _pixels("RGB"), icc_profile=_profile()),
        _encoded("WEBP", _pixels("RGB"), save_all=True, append_images=[_pixels("RGB", 1)]),
    ]  # fmt: skip


def _tiffs() -> list[bytes]:
    kinds = ["raw", "tiff_lzw", "tiff_adobe_deflate", "packbits", "jpeg"]
    real = Image.fromarray(np.linspace(0, 1, 54, dtype=np.float32).reshape(6, 9))
    grey16 = Image.fromarray(np.arange(54, dtype=np.uint16).reshape(6, 9) * 1000)
    return [
        *(_encoded("TIFF", _pixels("RGB"), compression=kind) for kind in kinds), _encoded("TIFF", real),
        _encoded("TIFF", grey16), _encoded("TIFF", _pixels("1"), compression="group4"),
        _encoded("TIFF", _pixels("RGBA"), compression="tiff_lzw"), _encoded("TIFF", _pixels("CMYK")),
        _encoded("TIFF", _pixels("P"), icc_profile=_profile()),
    ]  # fmt: skip


def _bmps() -> list[bytes]:
    return [_encoded("BMP", _pixels(mode)) for mode in ("RGB", "L", "P", "1", "RGBA")]


def _gifs() -> list[bytes]:
    return [
        _encoded("GIF", _pixels("P")), _encoded("GIF", _pixels("P"), transparency=2), _encoded("GIF", _pixels("1")),
        _encoded("GIF", _pixels("P"), save_all=True, append_images=[_pixels("P", 1)], disposal=2),
    ]  # fmt: skip


def _pixels(mode: str, seed: int = 0) -> Image.Image:
    noise = np.random.default_rng(seed).integers(0, 256, (6, 9, 4), np.uint8)
    return Image.fromarray(noise).convert("RGB").convert(mode) if mode != "RGBA" else Image.fromarray(noise)


def _profile() -> bytes:
    return ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes()


def _encoded(format: str, image: Image.Image, **options: object) -> bytes:
    stream = io.BytesIO()
    image.save(stream, format=format, **options)
    return stream.getvalue()


_MAKERS = {"png": _pngs, "jpeg": _jpegs, "webp": _webps, "tiff": _tiffs, "bmp": _bmps, "gif": _gifs}
KINDS = tuple(_MAKERS)
