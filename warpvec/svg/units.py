"""Read the numbers, lengths and sizes of an SVG."""

from __future__ import annotations

import re

from warpvec.errors import InputError

NUMBER = r"(?>[-+]?(?>\d+\.?\d*|\.\d+)(?>[eE][-+]?\d+)?)"
"""Regular expression of an SVG number. It is atomic, because digits that could be split would cost exponential time."""

MAX_PIXELS = 2**27
"""Largest rendering, above the largest image. resvg aborts the process if it cannot allocate."""

# CSS pixels per unit of length (CSS 2.1, section 4.3.2); em and ex at resvg's font size of 16.
_PIXELS_PER_UNIT = {
    "": 1.0, "px": 1.0, "pt": 4 / 3, "pc": 16.0, "in": 96.0, "mm": 96 / 25.4, "cm": 96 / 2.54, "em": 16.0, "ex": 8.0,
}  # fmt: skip


def stated_size(root: dict[str, str]) -> tuple[float, float]:
    """Return width and height of an SVG in pixels: as its root states them, otherwise from the view box.

    The result is what resvg itself would use, or larger.

    Raises:
        InputError: the root states no size.
    """
    sides = view_box(root)[2:]
    width, height = (
        parse_length(root.get(name, ""), side) for name, side in zip(("width", "height"), sides, strict=True)
    )
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


def check_pixels(width: float, height: float) -> None:
    """Raise an `InputError` unless a rendering of ``width`` x ``height`` has 1 to ``MAX_PIXELS`` pixels."""
    if not (width > 0 and height > 0 and width * height <= MAX_PIXELS):
        found = f"{width:g} x {height:g}"
        raise InputError("SVG", f"must have a size of 1 to {MAX_PIXELS} pixels", found, "choose another size")
