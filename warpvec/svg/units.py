"""Read the numbers, lengths and sizes of an SVG, and state its size in units of length."""

from __future__ import annotations

import math
import re

from warpvec.checks import show
from warpvec.errors import InputError

NUMBER = r"(?>[-+]?(?>\d+\.?\d*|\.\d+)(?>[eE][-+]?\d+)?)"
"""Regular expression of an SVG number. It is atomic, because digits that could be split would cost exponential time."""

MAX_PIXELS = 2**27
"""Largest rendering, above the largest image. resvg aborts the process if it cannot allocate."""

MAX_SIDE = 1e6
"""Largest width in pixels that a drawing may be given, 264 metres. Programs that show it reach their limits before."""

SHEET_MM = 1189.0
"""Longest side of the largest sheet of paper, A0 (ISO 216)."""

SIZE_UNITS = ("mm", "cm", "in", "pt", "px", "%")
"""Units of the size of a drawing; % is of its pixels."""

_STATED_LENGTH = re.compile(rf"\s*{NUMBER}\s*(?:mm|cm|in|pt|pc)\s*")

_SIZE = re.compile(rf"(\d{{1,9}}(?:\.\d{{0,9}})?|\.\d{{1,9}})\s*({'|'.join(SIZE_UNITS)})?", re.ASCII)

# CSS pixels per unit of length (CSS 2.1, section 4.3.2); em and ex at resvg's font size of 16.
_PIXELS_PER_UNIT = {
    "": 1.0, "px": 1.0, "pt": 4 / 3, "pc": 16.0, "in": 96.0, "mm": 96 / 25.4, "cm": 96 / 2.54, "em": 16.0, "ex": 8.0,
}  # fmt: skip


def more_decimals(unit: float) -> int:
    """Return the decimals that numbers in units of so many pixels need more than those in pixels."""
    return max(0, math.ceil(math.log10(unit) - 1e-9))


def world_size(meters: float) -> str | None:
    """Return the size of a drawing that is ``meters`` wide; None if it is too large for one."""
    size = f"{meters * 1000.0:.6g}mm"
    try:
        return check_size(size)
    except InputError:
        return None


def scaled_size(meters: float) -> tuple[int, str]:
    """Return the first scale 1 : 1, 1 : 10 ... at which ``meters`` are at most ``SHEET_MM`` wide, and that size."""
    scale = 1
    while meters * 1000.0 / scale > SHEET_MM:
        scale *= 10
    return scale, f"{meters * 1000.0 / scale:.6g}mm"


def stated_size(root: dict[str, str]) -> tuple[float, float]:
    """Return width and height of an SVG in pixels: as its root states them, otherwise from the view box.

    The result is what resvg itself would use, or larger.

    Raises:
        InputError: the root states no size.
    """
    sides = view_box(root)[2:]
    width, height = parse_length(root.get("width", ""), sides[0]), parse_length(root.get("height", ""), sides[1])
    if any(sides):
        scale = max((width or sides[0]) / sides[0], (height or sides[1]) / sides[1])
        width, height = width or sides[0] * scale, height or sides[1] * scale
    if not width or not height:
        raise InputError("SVG", "must state its size as width and height or viewBox", "none", "add a viewBox")
    return width, height


def view_box(root: dict[str, str]) -> list[float]:
    """Return left, top, width and height of the view box; zeros without a valid one."""
    box = [float(number) for number in re.findall(NUMBER, root.get("viewBox", ""))]
    return box if len(box) == 4 and min(box[2:]) > 0 else [0.0] * 4


def parse_length(length: str, whole: float) -> float:
    """Return ``length`` in pixels, with percentages of ``whole``; 0 if it is not a length."""
    match = re.fullmatch(rf"\s*({NUMBER})\s*(%|[a-z]*)\s*", length)
    return float(match[1]) * (_PIXELS_PER_UNIT | {"%": whole / 100}).get(match[2], 0.0) if match else 0.0


def check_size(text: object) -> str:
    """Return the size of a drawing, such as "90mm", without spaces.

    Raises:
        InputError: it is not a positive number with a unit of ``SIZE_UNITS``, or too large.
    """
    match = _SIZE.fullmatch(text.strip().lower()) if isinstance(text, str) else None
    if match is not None and not match[2]:
        rule = "must have a unit, so that a number is not taken for millimetres or for pixels"
        raise InputError("size", rule, show(text), f"give {match[1]}mm or {match[1]}px")
    number = 0.0 if match is None else float(match[1])
    unit = "px" if match is None else match[2]
    pixels = number * _PIXELS_PER_UNIT.get(unit, 1.0)
    if not 0.0 < pixels <= MAX_SIDE:
        units = ", ".join(SIZE_UNITS[:-1])
        rule = f"must be a width above 0 in {units} or {SIZE_UNITS[-1]}, and at most {MAX_SIDE:.0e} pixels"
        raise InputError("size", rule, show(text), "give one such as 90mm")
    return f"{_decimal(number)}{unit}"


def parse_millimeters(name: str, text: str) -> float:
    """Return the millimetres of a length such as "0.2mm"; also in cm and in.

    Raises:
        InputError: it is none; messages call it ``name``.
    """
    match = _SIZE.fullmatch(text.strip().lower())
    unit = "" if match is None else match[2] or ""
    if match is None or unit not in ("mm", "cm", "in"):
        raise InputError(name, "must be a length in mm, cm or in", show(text), "give one such as 0.2mm")
    return float(match[1]) * _PIXELS_PER_UNIT[unit] * MM_PER_PIXEL


def in_pixels_of(sides: tuple[str, str], pixels_per_inch: float) -> tuple[str, str]:
    """Return ``sides`` with lengths as pixels, of which there are so many per inch; those in pixels stay."""
    found = [re.fullmatch(r"([\d.]+)(mm|cm|in|pt)", side) for side in sides]
    if not all(found):
        return sides
    inches = (float(match[1]) * _PIXELS_PER_UNIT[match[2]] / 96.0 for match in found if match)
    across, down = (_decimal(pixels_per_inch * side) for side in inches)
    return across, down


def sides_of(size: str, width: float, height: float) -> tuple[str, str]:
    """Return the attributes width and height of a drawing of ``width`` x ``height`` pixels that is ``size`` wide.

    Args:
        size: as `check_size` returns it; a percentage is of the pixels.
        width, height: sides of the drawing in pixels.
    """
    number, unit = float(size.rstrip("%abcdefghijklmnopqrstuvwxyz")), size.lstrip("0123456789.")
    if unit == "%":
        number, unit = number / 100 * width, "px"
    suffix = "" if unit == "px" else unit
    return f"{_decimal(number)}{suffix}", f"{_decimal(number * height / width)}{suffix}"


def _decimal(number: float) -> str:
    """Return ``number`` with enough digits for a thousandth of a pixel, and no needless ones."""
    text = f"{number:.4f}".rstrip("0").rstrip(".")
    return text if float(text) > 0 else f"{number:.9f}".rstrip("0")


MM_PER_PIXEL = 25.4 / 96.0
"""A CSS pixel in millimetres."""


def physical_size(root: dict[str, str]) -> tuple[float, float] | None:
    """Return width and height of an SVG in millimetres if its root states them in a unit of length, not in pixels."""
    found = [_STATED_LENGTH.fullmatch(root.get(side, "")) for side in ("width", "height")]
    if not all(found):
        return None
    across, down = stated_size(root)
    return across * MM_PER_PIXEL, down * MM_PER_PIXEL


def check_pixels(width: float, height: float) -> None:
    """Raise an `InputError` unless a rendering of ``width`` x ``height`` has 1 to ``MAX_PIXELS`` pixels."""
    if not (width > 0 and height > 0 and width * height <= MAX_PIXELS):
        found = f"{width:g} x {height:g}"
        raise InputError("SVG", f"must have a size of 1 to {MAX_PIXELS} pixels", found, "choose another size")
