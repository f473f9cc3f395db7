"""The format HEIC by the package of the extra "formats", and what to do with files of formats that are not read."""

from __future__ import annotations

import re

_REMEDIES = (
    (
        rb".{4}ftyp(heic|heix|hevc|mif1|msf1)",
        "install 'warpvec[formats]', which reads HEIC, or save it as PNG",
    ),
    (rb"\xff\x0a|\x00\x00\x00\x0cJXL ", "save this JPEG XL as PNG, such as by djxl"),
    (
        rb"\x1f\x8b|(\xef\xbb\xbf)?\s*<(svg|\?xml|!--|!DOCTYPE svg)",
        "an SVG is a drawing already: see refine",
    ),
    (rb"%PDF-", "save the page as PNG, such as by pdftoppm -png"),
    (rb"II\*\x00|MM\x00\*", "save this kind of TIFF as RGB or grey with 8 or 16 bits"),
)
"""How files begin -> the remedy."""


try:
    from pillow_heif import register_heif_opener
except ImportError:
    EXTRA_FORMATS: tuple[str, ...] = ()
else:
    register_heif_opener()
    EXTRA_FORMATS = ("HEIF",)


def remedy_of(data: bytes) -> str:
    """Return what to do with the file ``data``, which no decoder takes."""
    return next((remedy for start, remedy in _REMEDIES if re.match(start, data, re.DOTALL)), "save it as PNG or JPEG")
