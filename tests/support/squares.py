"""A drawing of four squares on two levels, in the structure that warpvec writes."""

from __future__ import annotations

WIDTH, HEIGHT = 240, 160
INKSCAPE = "http://www.inkscape.org/namespaces/inkscape"
# Name: left, top, side, fill, opacity, level.
SQUARES = {
    "red": (20, 20, 60, "#c00", "1", 0),
    "green": (120, 20, 60, "#0a0", "1", 0),
    "blue": (60, 60, 40, "#00e", ".5", 1),
    "white": (200, 120, 20, "#fff", "1", 1),
}


def square(left: float, top: float, side: float, fill: str, opacity: str, _: int = 0) -> str:
    """Return a square as warpvec writes paths: closed, of cubics."""
    data = f"M{left} {top}c0 0 {side} 0 {side} 0 0 0 0 {side} 0 {side} 0 0 -{side} 0 -{side} 0 0 0 0 -{side} 0 -{side}z"
    paint = f'fill="{fill}"' + (f' fill-opacity="{opacity}"' if opacity != "1" else "")
    return f'<path {paint} d="{data}"/>'


def drawing(squares: dict[str, tuple] = SQUARES, levels: int = 2) -> str:
    """Return an SVG of ``squares`` with ``levels`` levels, in the structure of warpvec's files."""
    groups = [[square(*s) for s in squares.values() if s[-1] == level] for level in range(levels)]
    body = "".join(
        f'<g id="layer-{i + 1}-generation-{i}" inkscape:groupmode="layer">{"".join(paths)}</g>'
        for i, paths in enumerate(groups)
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" xmlns:inkscape="{INKSCAPE}" width="{WIDTH}" height="{HEIGHT}"'
        f' viewBox="0 0 {WIDTH} {HEIGHT}"><title>Squares</title>'
        '<metadata>{"generator": "warpvec", "seed": 7}</metadata>'
        f'<rect id="background" width="{WIDTH}" height="{HEIGHT}" fill="#888"/>{body}</svg>'
    )


def changed(**squares: tuple | None) -> str:
    """Return the drawing with some squares replaced, or removed (None)."""
    return drawing({name: value for name, value in {**SQUARES, **squares}.items() if value})
