"""Formats by packages of the extra "formats", and what to do with files of formats that are not read."""

from __future__ import annotations

import importlib
import re
from contextlib import suppress

_INSTALL = "install it by pip install 'warpvec[formats]', or save it as PNG"

_REMEDIES = (
    (rb".{4}ftyp(heic|heix|hevc|mif1|msf1)", f"HEIC needs pillow-heif: {_INSTALL}"),
    (rb"\xff\x0a|\x00\x00\x00\x0cJXL ", f"JPEG XL needs pillow-jxl-plugin: {_INSTALL}"),
    (rb"\x1f\x8b|(\xef\xbb\xbf)?\s*<(svg|\?xml|!--|!DOCTYPE svg)", "if it is an SVG, it is a drawing already: see refine"),
    (rb"%PDF-", "save the page as PNG, such as by pdftoppm -png"),
    (rb"II\*\x00|MM\x00\*", "save this kind of TIFF as RGB or grey with 8 or 16 bits"),
)
"""How files begin -> the remedy."""


def _load() -> tuple[str, ...]:
    """Return Pillow's names of the formats whose package is installed."""
    found = []
    with suppress(ImportError):
        importlib.import_module("pillow_heif").register_heif_opener()
        found.append("HEIF")
    with suppress(ImportError):
        importlib.import_module("pillow_jxl")
        found.append("JXL")
    return tuple(found)


EXTRA_FORMATS = _load()
"""Formats that Pillow reads by the packages that are installed."""


def remedy_of(data: bytes) -> str:
    """Return what to do with the file ``data``, which no decoder takes."""
    return next((remedy for start, remedy in _REMEDIES if re.match(start, data, re.DOTALL)), "save it as PNG or JPEG")
