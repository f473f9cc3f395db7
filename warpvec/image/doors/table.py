"""Which module reads a kind of file that Pillow does not, and what to do with files that nothing reads."""

from __future__ import annotations

import re
from importlib.util import find_spec
from typing import NamedTuple

from warpvec.errors import InputError

RULE = "must be a complete image, such as PNG, JPEG, WebP, AVIF, TIFF, GIF, BMP, PSD or PNM"
"""What a picture file must be."""


class Door(NamedTuple):
    """A kind of file.

    Attributes:
        kind: its name.
        start: how such files begin, a regular expression.
        work: module with a `work` for the sandbox; see `warpvec.image.decode_work`.
        package: that reads it, of the extra "formats"; None for none.
    """

    kind: str
    start: bytes
    work: str
    package: str | None

    @property
    def is_open(self) -> bool:
        """Whether its package is installed."""
        return self.package is None or find_spec(self.package) is not None


DOORS = (
    Door("HEIC", rb".{4}ftyp(?!.{0,40}avif)(heic|heix|heim|heis|hevc|mif1|msf1)", "heic", "pillow_heif"),
    Door("JPEG XL", rb"\xff\x0a|\0\0\0\x0cJXL ", "jxl", "pillow_jxl"),
    Door("PDF", rb"%PDF-", "pdf", "pypdfium2"),
    Door("OpenEXR", rb"v/1\x01", "exr", "OpenEXR"),
    Door("OpenRaster", rb"PK\x03\x04", "layers", None),
)
"""A file of Krita is as one of OpenRaster: an archive with the merged picture."""

TIFF = Door("TIFF", rb"II\*\0|MM\0\*|II\+\0|MM\0\+", "tiff", "tifffile")
"""TIFF files that Pillow refuses: RGB of more than 8 bits or floating point, CMYK with alpha."""

OTHER_TIFF = "save this kind of TIFF as RGB or grey with 8 or 16 bits"
"""What to do with a TIFF file that is whole, but not of a kind that Pillow reads right."""

_REMEDIES = (
    (
        rb"\x1f\x8b|(\xef\xbb\xbf)?\s*<(svg|\?xml|!--|!DOCTYPE svg)",
        "an SVG is a drawing already: see refine; run --from-svg draws it first",
    ),
    (TIFF.start, OTHER_TIFF),
)
"""How other files begin -> the remedy."""


def door_of(data: bytes) -> Door | None:
    """Return what reads the file ``data``; None for Pillow."""
    return next((door for door in DOORS if re.match(door.start, data, re.DOTALL)), None)


def remedy_of(data: bytes) -> str:
    """Return what to do with the file ``data``, which nothing reads."""
    return next((remedy for start, remedy in _REMEDIES if re.match(start, data, re.DOTALL)), "save it as PNG or JPEG")


def check_open(door: Door, label: str, name: str) -> None:
    """Raise InputError if the package of ``door`` is missing."""
    if not door.is_open:
        found = f"{label}, which is of the kind {door.kind}"
        raise InputError(name, RULE, found, "install 'warpvec[formats]', which reads it, or save it as PNG")
