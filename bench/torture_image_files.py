"""Small valid files of each kind, which together use most features that a reader may meet."""

from __future__ import annotations

import io
import struct
import zipfile
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from typing import Any

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


def _avifs() -> list[bytes]:
    two = {"save_all": True, "append_images": [_pixels("RGB", 1)]}
    return [
        _encoded("AVIF", _pixels("RGB")), _encoded("AVIF", _pixels("RGBA")), _encoded("AVIF", _pixels("RGB"), **two),
        _encoded("AVIF", _pixels("RGB"), icc_profile=_profile(), subsampling="4:0:0"),
    ]  # fmt: skip


def _netpbms() -> list[bytes]:
    """Return files of netpbm, binary and as text, of one and two bytes a sample; PAM is this program's own."""
    binary = [_encoded("PPM", _pixels(mode)) for mode in ("RGB", "L", "1")]
    deep = b"P5\n# deep\n3 2\n1000\n" + struct.pack(">6H", 0, 1, 500, 999, 1000, 7)
    plain = [b"P1 3 2\n1 0 1 0 0 1\n", b"P2\n3 2\n9\n0 1 2 3 9 5\n", b"P3 1 2 255 # red, green\n255 0 0 0 255 0\n"]
    head = "P7\nWIDTH 3\nHEIGHT 2\nDEPTH {}\nMAXVAL {}\nTUPLTYPE {}\nENDHDR\n"
    pams = [
        head.format(4, 255, "RGB_ALPHA").encode() + bytes(range(24)),
        head.format(1, 1, "BLACKANDWHITE").encode() + b"\0\1" * 3,
        head.format(2, 65535, "GRAYSCALE_ALPHA").encode() + bytes(range(24)),
    ]
    return [*binary, deep, *plain, *pams, _encoded("PPM", Image.fromarray(np.eye(5, dtype=np.uint16) * 60_000))]


def _psds() -> list[bytes]:
    """Return files of Photoshop with the composite alone: RGB, grey, CMYK and with alpha, plain and in runs."""
    found = []
    for mode, number, channels in (("RGB", 3, 3), ("L", 1, 1), ("CMYK", 4, 4), ("RGBA", 3, 4)):
        samples = np.asarray(_pixels(mode)).reshape(6, 9, channels)
        head = b"8BPS" + struct.pack(">H6xHIIHH", 1, channels, 6, 9, 8, number) + bytes(12)
        planes = samples.transpose(2, 0, 1)
        rows = [b"\x08" + row.tobytes() for plane in planes for row in plane]  # a run of nine other bytes
        found.append(head + b"\0\0" + planes.tobytes())
        found.append(head + b"\0\1" + struct.pack(f">{len(rows)}H", *map(len, rows)) + b"".join(rows))
    return found


def _icons() -> list[bytes]:
    image = _pixels("RGBA").resize((32, 32))
    sizes = {"sizes": [(16, 16), (32, 32)]}
    return [_encoded("ICO", image, **sizes), _encoded("ICO", image, bitmap_format="bmp"), _encoded("ICNS", image)]


def _others() -> list[bytes]:
    """Return files of old formats and of games."""
    return [
        *(_encoded("TGA", _pixels(mode)) for mode in ("RGB", "RGBA", "L", "P")),
        _encoded("TGA", _pixels("RGB"), compression="tga_rle"), _encoded("QOI", _pixels("RGB")),
        _encoded("QOI", _pixels("RGBA")), *(_encoded("PCX", _pixels(mode)) for mode in ("RGB", "L", "P", "1")),
        *(_encoded("DDS", _pixels(mode)) for mode in ("RGB", "RGBA", "L")),
        _encoded("DDS", _pixels("RGBA").resize((8, 8)), pixel_format="DXT5"),
    ]  # fmt: skip


def _jpeg2000s() -> list[bytes]:
    return [
        _encoded("JPEG2000", _pixels("RGB")), _encoded("JPEG2000", _pixels("RGBA")), _encoded("JPEG2000", _pixels("L")),
        _encoded("JPEG2000", _pixels("RGB"), no_jp2=True), _encoded("JPEG2000", _pixels("RGB"), irreversible=True),
    ]  # fmt: skip


def _doors() -> list[bytes]:
    """Return files of the kinds that packages of the extra "formats" read, as far as they are installed."""
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("mergedimage.png", _encoded("PNG", _pixels("RGBA")))
    pages = {"save_all": True, "append_images": [_pixels("L", 1)]}
    found = [archive.getvalue(), _encoded("PDF", _pixels("RGB"), **pages)]
    for package, make in (
        ("pillow_jxl", _jxls),
        ("pillow_heif", _heics),
        ("OpenEXR", _exrs),
        ("tifffile", _color_tiffs),
    ):
        if find_spec(package) is not None:
            found += make(import_module(package))
    return found


def _jxls(package: Any) -> list[bytes]:
    return [_encoded("JXL", _pixels(mode)) for mode in ("RGB", "RGBA", "L")]


def _heics(package: Any) -> list[bytes]:
    streams = [io.BytesIO(), io.BytesIO()]
    for stream, mode in zip(streams, ("RGB", "RGBA"), strict=True):
        package.from_pillow(_pixels(mode).resize((64, 64))).save(stream, quality=50)
    return [stream.getvalue() for stream in streams]


def _exrs(package: Any) -> list[bytes]:
    found, pixels = [], np.linspace(0, 2, 6 * 9 * 4, dtype=np.float16).reshape(6, 9, 4)
    for compression in (package.ZIP_COMPRESSION, package.PIZ_COMPRESSION, package.NO_COMPRESSION):
        header = {"compression": compression, "type": package.scanlineimage}
        package.File(header, {"RGBA": pixels}).write(stream := io.BytesIO())
        found.append(stream.getvalue())
    return found


def _color_tiffs(package: Any) -> list[bytes]:
    colors, inks = np.linspace(0, 1, 162, dtype=np.float32).reshape(6, 9, 3), np.arange(270, dtype=np.uint8)
    streams = [io.BytesIO() for _ in range(3)]
    package.imwrite(streams[0], colors, photometric="rgb")
    package.imwrite(streams[1], inks.reshape(6, 9, 5), photometric="separated", extrasamples=["unassalpha"])
    planes = (colors.transpose(2, 0, 1) * 65535).astype(np.uint16)
    package.imwrite(streams[2], planes, photometric="rgb", planarconfig="separate")
    return [stream.getvalue() for stream in streams]


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
_MAKERS |= {"avif": _avifs, "netpbm": _netpbms, "psd": _psds, "icon": _icons, "other": _others, "jp2": _jpeg2000s}
_MAKERS |= {"door": _doors}
KINDS = tuple(_MAKERS)
