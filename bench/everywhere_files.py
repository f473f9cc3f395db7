"""Small drawings in all that warpvec writes, spelled by its own writers, for `bench/everywhere.py`."""

# ruff: noqa: E501
# Drawings stand in lines of their own length.

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import replace

import torch

from warpvec.svg.minify import write_minified
from warpvec.svg.on_pages import as_symbol
from warpvec.svg.read import read_svg
from warpvec.svg.write import hex_colors, write_svg

SIDE = 256
"""Sides of the drawings in pixels."""

_UNITS = 10
"""Units of a short file in a pixel."""

_HEAD = f'<svg xmlns="http://www.w3.org/2000/svg" width="{SIDE}" height="{SIDE}" viewBox="0 0 {SIDE} {SIDE}">'
_GROUND = f'<rect width="{SIDE}" height="{SIDE}" fill="#eee"/>'
_PLACED = 'gradientUnits="userSpaceOnUse"'

_PATHS = """<path fill="#c22" d="M20 20h90a20 20 0 0 1 20 20v60h-110z"/>
<path fill="#06c" d="M150 60a40 40 0 0 1 80 0a40 40 0 0 1-80 0zm20 0a20 20 0 0 0 40 0a20 20 0 0 0-40 0z"/>
<path fill="#0a6" d="M30 140c40-40 60 60 100 10l-10 80c-50 20-60-30-100 10z"/>
<path fill="#fc0" d="M150 130l90 20l-40 80l-60-30z"/>"""

_FORMS = """<circle fill="#c22" cx="50" cy="50" r="36"/><ellipse fill="#06c" cx="150" cy="50" rx="40" ry="20"/>
<ellipse fill="#0a6" cx="210" cy="110" rx="40" ry="15" transform="rotate(30 210 110)"/>
<rect fill="#fc0" x="20" y="110" width="90" height="50" rx="16"/>
<rect fill="#639" x="130" y="150" width="90" height="60" rx="20" transform="rotate(-20 175 180)"/>
<rect fill="#333" x="30" y="180" width="60" height="50" transform="rotate(45 60 205)"/>"""

_STROKES = """<g fill="none"><path stroke="#c22" stroke-width="10" d="M20 30h80l20 40"/>
<path stroke="#06c" stroke-width="8" stroke-linecap="round" stroke-linejoin="round" d="M140 30c30 60 60-40 90 20l-30 30"/>
<path stroke="#0a6" stroke-width="6" stroke-linecap="square" stroke-linejoin="bevel" d="M20 110l60 20l-50 30l60 10"/>
<path stroke="#fc0" stroke-width="12" stroke-linejoin="round" d="M130 110c40-30 100 0 100 40s-80 30-100-40z"/>
<path stroke="#639" stroke-width="16" stroke-linecap="round" d="M60 210h0"/>
<path stroke="#333" stroke-width="3" stroke-opacity=".6" d="M100 200c40 60 80-60 130 30"/></g>"""

_STOPS = "".join(
    f'<stop offset="{number / 7:.2f}" stop-color="{color}"/>'
    for number, color in enumerate(("#c22", "#e71", "#fc0", "#8b2", "#0a6", "#0bb", "#06c", "#639"))
)
_GRADIENTS = f"""<defs><linearGradient id="a" {_PLACED} x1="20" y1="20" x2="120" y2="60">{_STOPS}</linearGradient>
<radialGradient id="b" {_PLACED} cx="190" cy="60" r="50"><stop offset="0" stop-color="#fff"/>
<stop offset="1" stop-color="#036"/></radialGradient>
<radialGradient id="c" {_PLACED} cx="0" cy="0" r="1" gradientTransform="matrix(60 30 -20 40 70 190)">
<stop offset="0" stop-color="#0a6" stop-opacity=".8"/><stop offset="1" stop-color="#0a6" stop-opacity="0"/></radialGradient>
<linearGradient id="d" {_PLACED} x1="150" y1="0" x2="240" y2="0"><stop offset="0" stop-color="#c0c" stop-opacity=".2"/>
<stop offset="1" stop-color="#333" stop-opacity=".9"/></linearGradient></defs>{_GROUND}
<path fill="url(#a)" d="M10 10h120v60l-50 40h-70z"/><circle fill="url(#b)" cx="190" cy="60" r="50"/>
<ellipse fill="url(#c)" cx="70" cy="190" rx="60" ry="50"/>
<path fill="url(#d)" fill-opacity=".9" d="M150 140h90v90h-90z"/>"""

_STROKED_GRADIENTS = f"""<defs><linearGradient id="a" {_PLACED} x1="20" y1="40" x2="120" y2="90">
<stop offset="0" stop-color="#c22"/><stop offset="1" stop-color="#06c"/></linearGradient>
<linearGradient id="b" {_PLACED} x1="140" y1="0" x2="240" y2="0"><stop offset="0" stop-color="#fc0"/>
<stop offset="1" stop-color="#639"/></linearGradient>
<radialGradient id="c" {_PLACED} cx="120" cy="190" r="100"><stop offset="0" stop-color="#0a6"/>
<stop offset="1" stop-color="#036"/></radialGradient></defs>{_GROUND}
<rect fill="url(#a)" x="20" y="30" width="90" height="60" rx="10" transform="rotate(25 65 60)"/>
<path fill="none" stroke="url(#b)" stroke-width="16" d="M140 40c40 60 60-40 100 40"/>
<path fill="none" stroke="url(#c)" stroke-width="20" stroke-linecap="round" d="M30 160c60 80 120-60 200 50"/>"""

_SOFT = f"""<defs><filter id="b1" x="-30%" y="-40%" width="160%" height="180%" color-interpolation-filters="sRGB">
<feGaussianBlur stdDeviation="8"/></filter>
<filter id="b2" x="-90%" y="-90%" width="280%" height="280%" color-interpolation-filters="sRGB">
<feGaussianBlur stdDeviation="4"/></filter></defs>{_GROUND}
<path fill="#000" fill-opacity=".5" filter="url(#b1)" d="M30 40h100v50l-40 30h-60z"/><path fill="#fc0" d="M40 30h60v60h-60z"/>
<circle fill="#c22" filter="url(#b2)" cx="190" cy="60" r="34"/>
<ellipse fill="#06c" filter="url(#b2)" cx="80" cy="190" rx="50" ry="20" transform="rotate(30 80 190)"/>
<path fill="none" stroke="#639" stroke-width="12" filter="url(#b2)" d="M150 220c20-60 50 40 80-60"/>"""


_CARD = f"""<defs><filter id="b" x="-30%" y="-40%" width="160%" height="180%" color-interpolation-filters="sRGB">
<feGaussianBlur stdDeviation="6"/></filter></defs>{_GROUND}
<path fill="#000" fill-opacity=".5" filter="url(#b)" d="M48 60h172v144h-172z"/>
<rect fill="#fff" x="40" y="48" width="176" height="144" rx="16"/><circle fill="#06c" cx="80" cy="92" r="20"/>
<path fill="#333" d="M112 80h80v8h-80zm0 20h60v8h-60z"/><path fill="#c22" d="M60 140h136v28h-136z"/>"""

_GRID = 24
"""Units of the grid of an icon, along its side."""

_ICON = """<rect width="24" height="24" fill="#eee"/><rect fill="#06c" x="2" y="4" width="20" height="17" rx="3"/><circle fill="#fff" cx="12" cy="13" r="5"/>
<path fill="#c22" d="M12 9.5a3.5 3.5 0 0 1 3.5 3.5h-2a1.5 1.5 0 0 0-1.5-1.5z"/><path fill="#333" d="M8 2h8l2 4h-12z"/>
<ellipse fill="#fc0" cx="19" cy="7.5" rx="1.5" ry=".75"/>"""

_LINE_ICON = """<rect width="24" height="24" fill="#eee"/><g fill="none" stroke="#333" stroke-width="2" stroke-linecap="round" stroke-linejoin="round">
<path d="M3 7h4l2-3h6l2 3h4v13h-18z"/><circle cx="12" cy="13" r="4"/><path d="M16 20c2-3 4-2 5-6"/></g>"""


def _on_grid(body: str) -> str:
    """Return the file of an icon that was found to lie on a grid of ``_GRID`` units."""
    loaded = read_svg(f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_GRID} {_GRID}">{body}</svg>')
    sides = (str(SIDE), str(SIDE))
    return write_svg(loaded.scene, _GRID, _GRID, precision=4, title="drawing", sides=sides)


def _photo() -> str:
    """Return what a photo has: translucent blobs from large to small, every fifth one soft, over a sky and a ground."""
    rng = random.Random(1)
    blobs = []
    for number in range(60):
        x, y, r = rng.uniform(0, SIDE), rng.uniform(0, SIDE), 70.0 * 0.96**number
        turn, color = rng.uniform(0.0, 6.28), rng.choice(("69c", "9bd", "cde", "473", "684", "352", "863"))
        nodes = [(x + r * math.cos(turn + a) * rng.uniform(0.6, 1.3), y + r * math.sin(turn + a)) for a in range(6)]
        data = "M{:.1f} {:.1f}C{:.1f} {:.1f} {:.1f} {:.1f} {:.1f} {:.1f}S{:.1f} {:.1f} {:.1f} {:.1f}z".format(
            *(value for node in nodes for value in node)
        )
        blur = ' filter="url(#b)"' if number % 5 == 0 else ""
        blobs.append(f'<path fill="#{color}" fill-opacity=".7"{blur} d="{data}"/>')
    head = '<filter id="b" x="-90%" y="-90%" width="280%" height="280%" color-interpolation-filters="sRGB">'
    return f'<defs>{head}<feGaussianBlur stdDeviation="5"/></filter></defs>{_GROUND}{"".join(blobs)}'


def _layered(body: str, sides: tuple[str, str] | None = None) -> str:
    loaded = read_svg(f"{_HEAD}{body}</svg>")
    return write_svg(loaded.scene, SIDE, SIDE, title="drawing", sides=sides)


def _short(body: str) -> str:
    scene = read_svg(f"{_HEAD}{body}</svg>").scene.scaled(_UNITS, _UNITS)
    return write_minified(scene, _UNITS * SIDE, _UNITS * SIDE, (str(SIDE), str(SIDE)))


def by_color() -> str:
    """Return a drawing with a layer for each colour, as flat art has, for programs that import shapes."""
    scene = read_svg(f"{_HEAD}{_GROUND}{_FORMS}{_PATHS}</svg>").scene
    names = list(dict.fromkeys(hex_colors(scene.color)))
    levels = torch.tensor([names.index(color) for color in hex_colors(scene.color)])
    scene = scene.select(levels.argsort(stable=True))
    scene = replace(scene, generation=levels.sort().values)
    return write_svg(
        scene, SIDE, SIDE, title="drawing", layer_names={level: f"pen {name}" for level, name in enumerate(names)}
    )


def _translucent() -> str:
    return _PATHS.replace('fill="#', 'fill-opacity=".7" fill="#')


FILES: dict[str, Callable[[], str]] = {
    "paths": lambda: _layered(_GROUND + _PATHS),
    "short": lambda: _short(_GROUND + _translucent()),
    "forms": lambda: _layered(_GROUND + _FORMS),
    "short forms": lambda: _short(_GROUND + _FORMS),
    "strokes": lambda: _layered(_GROUND + _STROKES),
    "gradients": lambda: _layered(_GRADIENTS),
    "gradients on strokes": lambda: _layered(_STROKED_GRADIENTS),
    "grid": lambda: _on_grid(_ICON),
    "grid strokes": lambda: _on_grid(_LINE_ICON),
    "soft": lambda: _layered(_SOFT),
    "card": lambda: _layered(_CARD),
    "photo": lambda: _short(_photo()),
    "127 mm": lambda: _layered(_GROUND + _PATHS, ("127mm", "127mm")),
    "symbol": lambda: as_symbol(_layered(_GROUND + _PATHS), "drawing"),
}
"""Name -> what makes the text of the file."""

SHARP = ("paths", "short", "forms", "short forms", "strokes", "gradients", "gradients on strokes")
"""The files without a blur that the bar of programs is about."""
