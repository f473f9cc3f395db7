"""The place of a picture's pixels in a document: lengths, boxes and matrices of SVG, without Inkscape.

A matrix (a, b, c, d, e, f) takes (x, y) to (a x + c y + e, b x + d y + f), as in SVG's ``matrix()``.
"""

from __future__ import annotations

import math
import re
from typing import NamedTuple

from warpvec_refusal import Refusal

Matrix = tuple[float, float, float, float, float, float]

IDENTITY: Matrix = (1.0, 0.0, 0.0, 1.0, 0.0, 0.0)

CLOSE = 1e-9
"""Difference of two numbers of matrices that nothing can show: a millionth of a pixel at 1,000 pixels."""

_UNITS = {
    "": 1.0, "px": 1.0, "pt": 96 / 72, "pc": 16.0, "in": 96.0, "cm": 96 / 2.54, "mm": 96 / 25.4, "q": 96 / 101.6,
}  # fmt: skip
"""Unit -> its length in user units. SVG fixes 96 user units to an inch, however large the document is shown."""

_LENGTH = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([a-zA-Z]*|%)\s*")
_ALIGN = re.compile(r"\s*(?:defer\s+)?x(Min|Mid|Max)Y(Min|Mid|Max)(?:\s+(meet|slice))?\s*")
_SHARES = {"Min": 0.0, "Mid": 0.5, "Max": 1.0}


class Size(NamedTuple):
    """A width and a height."""

    width: float
    height: float


class Box(NamedTuple):
    """A rectangle in user units."""

    x: float
    y: float
    width: float
    height: float


def read_length(text: str, whole: float) -> float:
    """Return the length in user units that an attribute states; per cent are of ``whole``.

    Raises:
        Refusal: it is no length, or it depends on a font.
    """
    match = _LENGTH.fullmatch(text)
    number, unit = (match[1], match[2].lower()) if match else ("", "?")
    if unit == "%":
        return float(number) * whole / 100.0
    if unit not in _UNITS:
        raise Refusal(f"The image has a size of {text!r}. Drag one of its corners, then try again.")
    return float(number) * _UNITS[unit]


def image_box(x: str | None, y: str | None, width: str | None, height: str | None, pixels: Size, viewport: Size) -> Box:
    """Return the box that the attributes of an image state, as SVG defines it.

    Args:
        x, y, width, height: the attributes; None where the image has none.
        pixels: size of the picture.
        viewport: size in user units of the SVG around the image.

    Raises:
        Refusal: the box is empty, or a length cannot be read.
    """
    wide = None if width in (None, "", "auto") else read_length(str(width), viewport.width)
    high = None if height in (None, "", "auto") else read_length(str(height), viewport.height)
    if wide is None:
        wide = pixels.width if high is None else high * pixels.width / pixels.height
    if high is None:
        high = wide * pixels.height / pixels.width
    if not (wide > 0.0 and high > 0.0):
        raise Refusal("The image has no area. Make it larger, then try again.")
    return Box(read_length(x or "0", viewport.width), read_length(y or "0", viewport.height), wide, high)


def place_pixels(box: Box, pixels: Size, aspect: str | None) -> tuple[Matrix, bool]:
    """Return the matrix from pixels to user units, and whether the picture must be cut off at the edges of ``box``.

    Args:
        aspect: the attribute preserveAspectRatio. None and what SVG does not know mean "xMidYMid meet".
    """
    scales = box.width / pixels.width, box.height / pixels.height
    if (aspect or "").split()[:1] == ["none"]:
        return (scales[0], 0.0, 0.0, scales[1], box.x, box.y), False
    match = _ALIGN.fullmatch(aspect or "xMidYMid") or _ALIGN.fullmatch("xMidYMid")
    assert match is not None
    is_slice = match[3] == "slice"
    scale = max(scales) if is_slice else min(scales)
    left = box.width - scale * pixels.width
    above = box.height - scale * pixels.height
    matrix = (scale, 0.0, 0.0, scale, box.x + _SHARES[match[1]] * left, box.y + _SHARES[match[2]] * above)
    return matrix, is_slice and not math.isclose(*scales, rel_tol=CLOSE)


def compose(outer: Matrix, inner: Matrix) -> Matrix:
    """Return the matrix that does ``inner`` first and ``outer`` then."""
    a, b, c, d, e, f = outer
    p, q, r, s, t, u = inner
    return (a * p + c * q, b * p + d * q, a * r + c * s, b * r + d * s, a * t + c * u + e, b * t + d * u + f)


def invert(matrix: Matrix) -> Matrix:
    """Return the matrix that undoes ``matrix``.

    Raises:
        Refusal: nothing undoes it.
    """
    a, b, c, d, e, f = matrix
    area = a * d - b * c
    if abs(area) < CLOSE**2:
        raise Refusal("The image or a path is squeezed to nothing. Undo its transformation, then try again.")
    return (d / area, -b / area, -c / area, a / area, (c * f - d * e) / area, (b * e - a * f) / area)


def is_identity(matrix: Matrix) -> bool:
    """Return whether ``matrix`` leaves all where it is."""
    return all(abs(value - IDENTITY[index]) < CLOSE for index, value in enumerate(matrix))


def matrix_text(matrix: Matrix) -> str:
    """Return the attribute ``transform`` for ``matrix``."""
    return "matrix({})".format(" ".join(f"{value:.12g}" for value in matrix))
