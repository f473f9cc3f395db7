"""Write PNG pictures of drawings, as resvg draws them."""

from __future__ import annotations

import math

from warpvec.errors import InputError
from warpvec.writers.writer import Canvas, Target, Writer

SIDE_MAX = 16_384
"""Longest side of a PNG in pixels; the area has the limit of all pictures."""


def drawing_size(svg: str) -> tuple[float, float]:
    """Return the width and height of a drawing in pixels, as its text states them.

    Raises:
        InputError: the text is no SVG with a size.
    """
    from warpvec.svg.document import parse_svg  # not above: it takes time that the help does without
    from warpvec.svg.units import stated_size

    across, down = stated_size(parse_svg(svg).root)
    if not (0.0 < across < math.inf and 0.0 < down < math.inf):
        raise InputError("SVG", "must have a positive size", f"{across:g} x {down:g}", "change its width and height")
    return across, down


def canvas_of(svg: str, width: float | None = None, *, transparent: bool = False) -> Canvas:
    """Return the canvas of a drawing that is ``width`` pixels wide, or as wide as the drawing says.

    Raises:
        InputError: the text is no SVG with a size, or a side is too long.
    """
    across, down = drawing_size(svg)
    columns = across if width is None else float(width)
    rows = max(1.0, columns * down / across)
    if not (1.0 <= columns <= SIDE_MAX and rows <= SIDE_MAX):
        raise InputError("width", f"must give sides from 1 to {SIDE_MAX} pixels", f"{columns:g}", "give another")
    return Canvas(round(columns), round(rows), transparent)


def _encode(svg: str, target: Target) -> bytes:
    from warpvec.image.write import png_bytes
    from warpvec.svg.measure import draw

    width, height, transparent = target.canvas or canvas_of(svg)
    return png_bytes(draw(svg, width, height, transparent=transparent))


WRITER = Writer(".png", "image/png", _encode)
