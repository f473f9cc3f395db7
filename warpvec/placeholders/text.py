"""The text of a placeholder in few bytes, and its data URI."""

from __future__ import annotations

import math
from itertools import pairwise

from torch import Tensor

from warpvec.placeholders.canvas import MARGIN_DEVIATIONS, Shapes, rounded

PREFIX = "data:image/svg+xml,"

_Corner = tuple[int, int]


def placeholder_svg(shapes: Shapes, width: int, height: int, deviation: float) -> str:
    """Return the SVG of ``shapes`` in ``width`` x ``height`` units, blurred by ``deviation`` units.

    Corners are whole numbers and colours #rgb. Attributes are in single quotes, so that double quotes can enclose the
    data URI. Shapes without an area are left out. The background reaches beyond the canvas, so that the blur does not
    mix its edges with nothing.
    """
    whole = rounded(shapes)
    paths = map(_path, whole.corners.tolist(), whole.color)
    margin = math.ceil(MARGIN_DEVIATIONS * deviation)
    start = f"{-margin}{-margin}" if margin else "0 0"
    ground = f"m{start}h{width + 2 * margin}v{height + 2 * margin}h{-width - 2 * margin}"
    drawn = f"<path fill='{_hex(whole.background)}' d='{ground}'/>{''.join(paths)}"
    if deviation:
        blur = f"<filter id='b'><feGaussianBlur stdDeviation='{deviation:g}'/></filter>".replace("'0.", "'.")
        drawn = f"{blur}<g filter='url(#b)'>{drawn}</g>"
    return f"<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {width} {height}'>{drawn}</svg>"


def data_uri(svg: str) -> str:
    """Return ``svg`` as a data URI that is safe in double quotes, in CSS and in HTML.

    Only # and % are encoded: a # would start a fragment. Chromium and Firefox take the rest as it is.
    """
    return PREFIX + svg.replace("%", "%25").replace("#", "%23")


def _path(corners: list[list[float]], color: Tensor) -> str:
    """Return the path of a polygon with whole ``corners``, without repeated ones; nothing if fewer than three stay."""
    found: list[_Corner] = []
    for x, y in corners:
        if not found or (int(x), int(y)) != found[-1]:
            found.append((int(x), int(y)))
    if found[-1] == found[0]:
        found.pop()
    if len(found) < 3:
        return ""
    steps = [(after[0] - before[0], after[1] - before[1]) for before, after in pairwise(found)]
    # The pairs after that of a relative move are relative lines.
    return f"<path fill='{_hex(color)}' d='m{_joined([found[0], *steps])}'/>"


def _joined(pairs: list[_Corner]) -> str:
    """Return the numbers with a space only where the next one has no sign."""
    numbers = [str(number) for pair in pairs for number in pair]
    return numbers[0] + "".join(number if number[0] == "-" else f" {number}" for number in numbers[1:])


def _hex(color: Tensor) -> str:
    return "#" + "".join(f"{round(15 * level):x}" for level in color.tolist())
