"""Small valid files of each kind, which together use most features that a reader may meet."""

from __future__ import annotations

import gzip
import io

import numpy as np
from PIL import Image

NS = 'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" width="32" height="24"'

_SVG_CONTENTS = [
    '<rect id="background" width="32" height="24" fill="#abc"/><g id="layer-1-generation-0">'
    '<path fill="#12f" d="M4 5c1 .5 3-1 4 1-1 2-3 2-4-1z"/><path fill="#345678" fill-opacity=".5" '
    'd="M9 9c3-1 5 3 5 5-2 3-5-1-5-5z"/></g><g id="layer-2-generation-3"><path fill="#fff" d="M1 1c5 0 5 5 5 5z"/></g>',
    '<style>.a,rect.b{fill:#f0f;stroke:red} #c{opacity:50%}</style><g transform="matrix(1 .2 0 1 3 4) rotate(30)">'
    '<rect class="a" x="5%" y="1mm" width="9" height="8" rx="2"/><circle id="c" cx="9" cy="9" r="5"/></g>'
    '<ellipse rx="5" ry="20%"/><polygon points="1,2 9,8 3 9"/><polyline points="1 2 3,4"/><line x2="9"/>',
    '<defs><symbol id="s" viewBox="0 0 9 9"><path d="M1 1A4 5 20 0 1 8 8Q1 9 2 3T4 4S9 1 3 3z"/></symbol></defs>'
    '<use href="#s" x="3" width="9" height="9"/><svg viewBox="0 0 9 9" preserveAspectRatio="xMinYMax slice">'
    '<use xlink:href="#s" transform="scale(2)"/></svg><switch><g><path d="M0 0h9v9H0zm2 2v5h5V2z"/></g></switch>',
    '<linearGradient id="g"><stop offset="20%" stop-color="red"/><stop offset="1" stop-color="#00f8"/></linearGradient>'
    '<radialGradient id="h" href="#g"/><pattern id="p" width="4" height="4" patternUnits="userSpaceOnUse"><rect '
    'width="2" height="2"/></pattern><rect width="9" height="9" fill="url(#h)"/><path fill="url(#p) rgb(9,9,9)" '
    'd="M9 9h9v9z" stroke="hsl(9,9%,9%)" stroke-width="2" stroke-dasharray="1 2"/>',
    '<mask id="m"><rect width="9" height="9" fill="#fff"/></mask><clipPath id="c"><circle r="9"/></clipPath>'
    '<filter id="f"><feGaussianBlur stdDeviation="1"/></filter><g mask="url(#m)" opacity=".5"><path '
    'd="M1 1l9 0 0 9z" clip-path="url(#c)"/><path filter="url(#f)" d="M1 1L9 1 0 9z" style="mix-blend-mode:multiply"/>'
    '</g><text x="3" y="9">a&amp;b</text><image width="4" height="4" href="data:image/png;base64,iVBORw0KGgo="/>',
]


def seeds(kind: str) -> list[bytes]:
    """Return the files of ``kind``: "png", "jpeg", "webp", "tiff" or "svg"."""
    return {"png": _pngs, "jpeg": _jpegs, "webp": _webps, "tiff": _tiffs, "svg": _svgs}[kind]()


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


def _svgs() -> list[bytes]:
    texts = [f'<?xml version="1.0"?>\n<svg {NS} viewBox="0 0 32 24">{content}</svg>' for content in _SVG_CONTENTS]
    return [*(text.encode() for text in texts), gzip.compress(texts[0].encode(), mtime=0)]


def _pixels(mode: str, seed: int = 0) -> Image.Image:
    noise = np.random.default_rng(seed).integers(0, 256, (6, 9, 4), np.uint8)
    return Image.fromarray(noise).convert("RGB").convert(mode) if mode != "RGBA" else Image.fromarray(noise)


def _profile() -> bytes:
    from image_files import LINEAR_RGB

    return LINEAR_RGB


def _encoded(format: str, image: Image.Image, **options: object) -> bytes:
    stream = io.BytesIO()
    image.save(stream, format=format, **options)
    return stream.getvalue()
