"""Numbers, lengths and sizes as an SVG states them."""

from __future__ import annotations

import re

from warpvec.errors import InputError

MAX_PIXELS = 2**27
"""Above the largest photo we take (100 megapixels); resvg aborts the process where it cannot allocate."""

# CSS pixels per unit of length (CSS 2.1, section 4.3.2); em and ex at resvg's font size of 16.
_PIXELS_PER_UNIT = {
    "": 1.0, "px": 1.0, "pt": 4 / 3, "pc": 16.0, "in": 96.0, "mm": 96 / 25.4, "cm": 96 / 2.54, "em": 16.0, "ex": 8.0,
}  # fmt: skip


def stated_size(root: dict[str, str]) -> tuple[float, float]:
    """Width and height in pixels: as stated, else of the view box. What resvg itself would take, or larger."""
    sides = view_box(root)[2:]
    width, height = (
        parse_length(root.get(name, ""), side) for name, side in zip(("width", "height"), sides, strict=True)
    )
    if any(sides):
        scale = max((width or sides[0]) / sides[0], (height or sides[1]) / sides[1])
        width, height = width or sides[0] * scale, height or sides[1] * scale
    if not width or not height:
        raise InputError("SVG must state its size as width and height or viewBox, this one does not; ask for a size")
    return width, height


def view_box(root: dict[str, str]) -> list[float]:
    """Left, top, width and height; zeros where there is none to speak of."""
    box = [float(number) for number in re.findall(NUMBER, root.get("viewBox", ""))]
    return box if len(box) == 4 and min(box[2:]) > 0 else [0.0] * 4


def parse_length(length: str, whole: float) -> float:
    """``length`` in pixels, per cent being of ``whole``; 0 where it states none."""
    match = re.fullmatch(rf"\s*({NUMBER})\s*(%|[a-z]*)\s*", length)
    return float(match[1]) * (_PIXELS_PER_UNIT | {"%": whole / 100}).get(match[2], 0.0) if match else 0.0


def check_pixels(width: float, height: float) -> None:
    if not (width > 0 and height > 0 and width * height <= MAX_PIXELS):
        raise InputError(f"SVG must be drawn at 1 to {MAX_PIXELS} pixels, got {width:g} x {height:g}; ask for a size")


NUMBER = r"(?>[-+]?(?>\d+\.?\d*|\.\d+)(?>[eE][-+]?\d+)?)"
"""A number of SVG, as a regular expression; atomic, since digits that could be split would cost exponential time."""
