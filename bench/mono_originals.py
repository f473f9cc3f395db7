"""Five black drawings of our own making, and what a scanner makes of them."""

from __future__ import annotations

import io
import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from PIL import Image

SIDE = 600
"""Width and height of the drawings in pixels."""

BLUR = 0.6
"""Standard deviation in pixels of a scanner's optics, on top of the area of a pixel."""

INK, PAPER, NOISE = 28.0, 236.0, 5.0
"""Levels of ink and paper, and the standard deviation of the scanner's noise."""

JPEG_QUALITY = 85

_LETTERS = "Rag&2"


def scanned(coverage: NDArray[np.floating], seed: int) -> NDArray[np.uint8]:
    """Return the scan [h, w] of ink that covers each pixel by ``coverage`` [h, w]: blurred, noisy, and a JPEG."""
    pixels = Image.fromarray((255 * coverage).astype(np.float32))
    blurred = np.asarray(_blurred(pixels)) / 255.0
    noise = np.random.default_rng(seed).normal(0.0, NOISE, blurred.shape)
    levels = np.clip(PAPER + (INK - PAPER) * blurred + noise, 0, 255).astype(np.uint8)
    file = io.BytesIO()
    Image.fromarray(levels).save(file, "JPEG", quality=JPEG_QUALITY)
    return np.asarray(Image.open(file))


def _blurred(pixels: Image.Image) -> Image.Image:
    from scipy.ndimage import gaussian_filter

    return Image.fromarray(gaussian_filter(np.asarray(pixels), BLUR))


def letters() -> str:
    """Return large letters of DejaVu Serif, as matplotlib brings them."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import TextPath

    path = TextPath((0, 0), _LETTERS, size=100, prop=FontProperties(family="DejaVu Serif"))
    box = path.get_extents()
    factor = 0.9 * SIDE / box.width
    commands = {1: "M", 2: "L", 3: "Q", 4: "C", 79: "Z"}
    parts = []
    for points, code in path.iter_segments(curves=True, simplify=False):
        pairs = np.reshape(points, (-1, 2)) if code != 79 else np.zeros((0, 2))
        pairs = (pairs - [box.x0, box.y1]) * [factor, -factor] + [0.05 * SIDE, 0.25 * SIDE]
        parts.append(commands[int(code)] + " ".join(f"{x:.3f},{y:.3f}" for x, y in pairs))
    return f'<path d="{"".join(parts)}"/>'


def signature() -> str:
    """Return a signature of loops by a pen whose width follows its direction."""
    t = np.linspace(0, 1, 400)
    x = 60 + 480 * t + 42 * np.sin(2 * math.pi * 7 * t)
    y = 300 + (110 - 70 * t) * np.sin(2 * math.pi * 7 * t + 1.2) * np.exp(-0.6 * t) - 60 * t
    width = 3.0 + 2.5 * np.abs(np.sin(np.arctan2(np.gradient(y), np.gradient(x)) + 0.6))
    pieces = [
        f'<path d="M{x[k]:.2f},{y[k]:.2f}L{x[k + 1]:.2f},{y[k + 1]:.2f}" stroke-width="{width[k]:.2f}"/>'
        for k in range(len(t) - 1)
    ]
    underline = '<path d="M80,420C220,450 400,380 560,440" stroke-width="4"/>'
    return f'<g fill="none" stroke="#000" stroke-linecap="round">{"".join(pieces)}{underline}</g>'


def bicycle() -> str:
    """Return a line drawing of circles, spokes and a frame."""
    wheels = []
    for x in (150, 450):
        spokes = [
            f"M{x},380L{x + 108 * math.cos(a):.2f},{380 + 108 * math.sin(a):.2f}"
            for a in np.arange(12) * math.pi / 6 + 0.1
        ]
        wheels.append(f'<circle cx="{x}" cy="380" r="110" stroke-width="7"/><path d="{"".join(spokes)}"/>')
    frame = "M150,380L260,230L400,230L290,380ZM290,380L250,200M400,230L450,380M400,230L390,180L430,170"
    extra = '<path d="M220,200H285" stroke-width="9"/><circle cx="290" cy="380" r="24"/>'
    lines = f'{"".join(wheels)}<path d="{frame}" stroke-width="6" stroke-linejoin="round"/>{extra}'
    return f'<g fill="none" stroke="#000" stroke-width="2.5" stroke-linecap="round">{lines}</g>'


def emblem() -> str:
    """Return solid shapes with holes: a star in a ring, a shield's corner, and letters of lines and arcs."""
    angles = np.arange(10) * math.pi / 5 - math.pi / 2
    radii = np.where(np.arange(10) % 2, 70.0, 170.0)
    star = " ".join(
        f"{300 + r * math.cos(a):.2f},{290 + r * math.sin(a):.2f}" for r, a in zip(radii, angles, strict=True)
    )
    ring = '<circle cx="300" cy="290" r="230" fill="none" stroke="#000" stroke-width="34"/>'
    hole = '<circle cx="300" cy="290" r="34" fill="#fff"/>'
    ribbon = (
        '<path d="M70,500H530V570L500,545L470,570H130L100,545L70,570Z"/><path d="M150,522H450V540H150Z" fill="#fff"/>'
    )
    return f'{ring}<polygon points="{star}"/>{hole}{ribbon}'


def engraving() -> str:
    """Return a landscape of hatching: thin lines that swell, a sun, and mountains."""
    parts = ['<circle cx="420" cy="150" r="60" fill="none" stroke="#000" stroke-width="3"/>']
    for k in range(18):
        y, w = 300 + 15 * k, 1.4 + 0.12 * k
        parts.append(
            f'<path d="M{30 + 3 * k},{y}C180,{y - 26 + k} 330,{y + 30 - k} {570 - 4 * k},{y - 4}" '
            f'fill="none" stroke="#000" stroke-width="{w:.2f}" stroke-linecap="round"/>'
        )
    for k in range(14):
        parts.append(f'<path d="M{120 + 14 * k},{280 - 9 * k if k < 8 else 150 + 12 * k}l26,{-18 + k}l-20,30z"/>')
    ridge = "M30,285L150,150L205,205L290,95L390,240L440,210L570,285"
    parts.append(f'<path d="{ridge}" fill="none" stroke="#000" stroke-width="4" stroke-linejoin="miter"/>')
    return "".join(parts)


DRAWINGS: dict[str, Callable[[], str]] = {
    "letters": letters, "signature": signature, "bicycle": bicycle, "emblem": emblem, "engraving": engraving,
}  # fmt: skip
"""Each gives elements in black and white, over white."""


def drawing(name: str) -> str:
    """Return the SVG of a drawing."""
    head = f'<svg xmlns="http://www.w3.org/2000/svg" width="{SIDE}" height="{SIDE}" viewBox="0 0 {SIDE} {SIDE}">'
    return f"{head}{DRAWINGS[name]()}</svg>"
