"""Write sheets as SVG: a unit is a millimetre, an element is an outline, a layer is named by number and colour."""

from __future__ import annotations

from itertools import groupby

from warpvec.arrays import Floats
from warpvec.making.parts import Circle, Ellipse, Part, Shape, Sheet

_DECIMALS = 3
"""Decimals of millimetres: a fifth of what chords may be off."""


def sheet_text(sheet: Sheet, pixels_per_inch: float | None = None) -> str:
    """Return the text of an SVG of ``sheet``.

    Args:
        sheet: its parts.
        pixels_per_inch: state the size in pixels of this many per inch, for programs that read no units.
    """
    scale, unit = (1.0, "mm") if pixels_per_inch is None else (pixels_per_inch / 25.4, "")
    width, height = (f"{_number(side * scale)}{unit}" for side in (sheet.width, sheet.height))
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape"'
        f' width="{width}" height="{height}" viewBox="0 0 {_number(sheet.width)} {_number(sheet.height)}">',
    ]
    for number, (name, parts) in enumerate(groupby(sheet.parts, key=lambda part: part.layer or part.color), 1):
        identifier = "c" + name[1:] if name[0] == "#" else name
        lines.append(f'<g id="{identifier}" inkscape:groupmode="layer" inkscape:label="{number} {name}">')
        lines += [_element(part) for part in parts]
        lines.append("</g>")
    return "\n".join([*lines, "</svg>"]) + "\n"


def _element(part: Part) -> str:
    data = "".join(map(_data, part.shapes))
    if part.stroke is None:
        return f'<path fill="{part.color}" fill-rule="evenodd" d="{data}"/>'
    width, cap, join, _ = part.stroke
    looks = f'stroke-width="{_number(width)}" stroke-linecap="{cap}" stroke-linejoin="{join}"'
    return f'<path fill="none" stroke="{part.color}" {looks} d="{data}"/>'


def _data(shape: Shape) -> str:
    """Return the path data of a shape; a circle and an ellipse are two arcs."""
    if isinstance(shape, Circle):
        return _two_arcs(shape.x - shape.radius, shape.y, 2.0 * shape.radius, 0.0, shape.radius, shape.radius, 0.0)
    if isinstance(shape, Ellipse):
        across, down = shape.axis
        x, y = shape.x - across, shape.y - down
        return _two_arcs(x, y, 2.0 * across, 2.0 * down, shape.first, shape.second, shape.degrees)
    words = [f"M{_point(shape.pieces[0].points[0])}"]
    for piece in shape.pieces:
        end = _point(piece.points[-1])
        if piece.is_cubic:
            words.append("C" + " ".join(map(_point, piece.points[1:])))
        elif piece.bulge:
            radius = _number(piece.circle[2])
            words.append(f"A{radius} {radius} 0 {int(abs(piece.bulge) > 1.0)} {int(piece.bulge > 0.0)} {end}")
        else:
            words.append(f"L{end}")
    return "".join(words) + ("Z" if shape.is_closed else "")


def _two_arcs(x: float, y: float, across: float, down: float, first: float, second: float, turn: float) -> str:
    head = f"{_number(first)} {_number(second)} {_number(turn)} 0 1 "
    there, back = f"{_number(across)} {_number(down)}", f"{_number(-across)} {_number(-down)}"
    return f"M{_number(x)} {_number(y)}a{head}{there}a{head}{back}z"


def _point(point: Floats) -> str:
    x, y = point.tolist()
    return f"{_number(x)} {_number(y)}"


def _number(value: float) -> str:
    text = f"{float(value):.{_DECIMALS}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text
