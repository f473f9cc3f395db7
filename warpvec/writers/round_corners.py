"""Write rectangles with round corners as paths, for CairoSVG, whose own corners are no circles.

CairoSVG 2.9 places the second handle of each corner as if it were seen from the other end, so that a corner lies up to
4 % of its radius beside the circle.
"""

from __future__ import annotations

import re
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from warpvec.geometry.quarter import QUARTER_HANDLE
from warpvec.svg.document import local_name, parse_svg
from warpvec.svg.units import NUMBER

_PLAIN = re.compile(NUMBER)

_SIDES = ("x", "y", "width", "height", "rx", "ry")


def with_round_paths(svg: str) -> str:
    """Return the text of an SVG with paths in place of rectangles with round corners; their paint is kept.

    Raises:
        InputError: ``svg`` is not an SVG, or is refused as unsafe.
    """
    if not re.search(r"<(?:\w+:)?rect\b[^>]*\br[xy]\s*=", svg):
        return svg
    builder = ElementTree.TreeBuilder()
    parse_svg(svg, builder)
    root = builder.close()
    for element in root.iter():
        if local_name(element.tag) == "rect":
            _make_path(element)
    return ElementTree.tostring(root, encoding="unicode")


def _make_path(rect: Element) -> None:
    """Make a path of a rectangle with round corners, unless it states lengths with units."""
    stated = {side: rect.attrib[side] for side in _SIDES if side in rect.attrib}
    if not all(_PLAIN.fullmatch(text.strip()) for text in stated.values()):
        return
    sides = {side: float(text) for side, text in stated.items()}
    x, y, width, height = (sides.get(side, 0.0) for side in _SIDES[:4])
    rx = min(sides.get("rx", sides.get("ry", 0.0)), width / 2)
    ry = min(sides.get("ry", sides.get("rx", 0.0)), height / 2)
    if min(rx, ry) <= 0.0:
        return
    for side in stated:
        del rect.attrib[side]
    rect.tag = rect.tag.removesuffix("rect") + "path"
    rect.set("d", _path_data(x, y, width, height, rx, ry))


def _path_data(x: float, y: float, width: float, height: float, rx: float, ry: float) -> str:
    across, down = width - 2 * rx, height - 2 * ry

    def corner(first: tuple[float, float], second: tuple[float, float]) -> str:
        """Return a quarter of an ellipse from its start along ``first``, and then along ``second``."""
        near = [QUARTER_HANDLE * side for side in first]
        far = [a + (1.0 - QUARTER_HANDLE) * b for a, b in zip(first, second, strict=True)]
        end = [a + b for a, b in zip(first, second, strict=True)]
        return "c" + " ".join(f"{number:.6f}" for number in (*near, *far, *end))

    return (
        f"M{x + rx:.6f} {y:.6f}h{across:.6f}{corner((rx, 0.0), (0.0, ry))}v{down:.6f}{corner((0.0, ry), (-rx, 0.0))}"
        f"h{-across:.6f}{corner((-rx, 0.0), (0.0, -ry))}v{-down:.6f}{corner((0.0, -ry), (rx, 0.0))}z"
    )
