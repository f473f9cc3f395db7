"""The files that the page saves: SVG, svgz, PNG of any size, and PDF if the extra "print" is installed."""

from __future__ import annotations

import io
import math

from PIL import Image

from warpvec.errors import InputError
from warpvec.svg.document import parse_svg
from warpvec.svg.measure import draw
from warpvec.svg.print_formats import check_print_support, encode_drawing
from warpvec.svg.units import stated_size

MEDIA_TYPES = {
    "svg": "image/svg+xml",
    "svgz": "image/svg+xml",
    "png": "image/png",
    "pdf": "application/pdf",
}
"""Format -> the type that the answer states."""

PNG_SIDE_MAX = 16_384
"""Longest side of a PNG in pixels; the area has the limit of all pictures."""


def usable_formats() -> list[str]:
    """Return the formats that can be written here; PDF needs CairoSVG and the library cairo."""
    try:
        check_print_support("drawing.pdf", "format")
    except InputError:
        return [name for name in MEDIA_TYPES if name != "pdf"]
    return list(MEDIA_TYPES)


def encode(text: str, kind: str, width: int | None = None, *, transparent: bool = False) -> bytes:
    """Return the bytes of the file of ``kind`` with the drawing ``text``.

    Args:
        text: SVG text.
        kind: one of ``MEDIA_TYPES``.
        width: width of a PNG in pixels; None for that of the drawing.
        transparent: whether a PNG has alpha instead of white paper.

    Raises:
        InputError: the text is no SVG that can be drawn, the kind is unknown or not usable, or the width is none.
    """
    if kind not in MEDIA_TYPES:
        raise InputError("format", f"must be one of {', '.join(MEDIA_TYPES)}", repr(kind), "reload the page")
    document = parse_svg(text)
    across, down = stated_size(document.root)
    if not (0.0 < across < math.inf and 0.0 < down < math.inf):
        raise InputError("SVG", "must have a positive size", f"{across:g} x {down:g}", "change its width and height")
    if kind != "png":
        return encode_drawing(text, f"drawing.{kind}")
    columns = across if width is None else float(width)
    rows = max(1.0, columns * down / across)
    if not (1.0 <= columns <= PNG_SIDE_MAX and rows <= PNG_SIDE_MAX):
        raise InputError("width", f"must give sides from 1 to {PNG_SIDE_MAX} pixels", f"{columns:g}", "give another")
    stream = io.BytesIO()
    Image.fromarray(draw(document, round(columns), round(rows), transparent=transparent)).save(stream, "PNG")
    return stream.getvalue()
