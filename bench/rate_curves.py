"""The picture of `bench/rate.py`: curves of decibels and of SSIM over the bytes of a file, as an SVG."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from rate_report import Curve

WIDTH, HEIGHT, LEFT, BOTTOM, TOP, RIGHT = 430, 340, 44, 40, 30, 74
"""Size of a panel in pixels, and the room around its curves, where the words are."""

COLORS = ("#d22", "#e80", "#26c", "#292", "#737", "#555", "#0aa")

LABEL_GAP = 13.0
"""Least distance in pixels from one name beside the curves to the next."""

GRID_LINES = 5
"""Number of horizontal lines of a panel, about."""


class Panel(NamedTuple):
    """The curves of one value, by the names of the methods, its title, and the bytes that the axis names."""

    title: str
    curves: Mapping[str, Curve]
    sizes: Sequence[int]


class _Axes(NamedTuple):
    """The ranges of a panel: of the logarithm of the bytes, and of the value."""

    across: tuple[float, float]
    down: tuple[float, float]

    def place(self, size: float, value: float) -> tuple[float, float]:
        """Return the pixel of a file of ``size`` bytes with ``value``."""
        x = (math.log(size) - self.across[0]) / (self.across[1] - self.across[0])
        y = (value - self.down[0]) / (self.down[1] - self.down[0])
        return LEFT + x * (WIDTH - LEFT - RIGHT), HEIGHT - BOTTOM - y * (HEIGHT - BOTTOM - TOP)


def write_curves(panels: Sequence[Panel], path: Path) -> None:
    """Write an SVG with the ``panels`` side by side."""
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH * len(panels)}" height="{HEIGHT}"'
        ' font-family="sans-serif" font-size="11">',
        '<rect width="100%" height="100%" fill="#fff"/>',
    ]
    for index, panel in enumerate(panels):
        parts += [f'<g transform="translate({WIDTH * index})">', *_panel(panel), "</g>"]
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join([*parts, "</svg>"]) + "\n")


def _panel(panel: Panel) -> list[str]:
    points = [point for curve in panel.curves.values() for point in curve]
    if not points:
        return []
    sizes, values = [*panel.sizes, *(point[0] for point in points)], [point[1] for point in points]
    step = _step(max(values) - min(values))
    low, high = step * math.floor(min(values) / step), step * math.ceil(max(values) / step + 1e-9)
    axes = _Axes((math.log(min(sizes)), math.log(max(sizes) + 1)), (low, high))
    return [*_frame(panel, axes, step), *_curves(panel, axes)]


def _step(extent: float) -> float:
    """Return the distance of the horizontal lines: 1, 2 or 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(max(extent, 1e-6) / GRID_LINES))
    return next(power * factor for factor in (1, 2, 5, 10) if power * factor * GRID_LINES >= extent)


def _frame(panel: Panel, axes: _Axes, step: float) -> list[str]:
    right, bottom = WIDTH - RIGHT, HEIGHT - BOTTOM
    parts = [f'<text x="{LEFT}" y="{TOP - 12}" font-weight="bold">{panel.title}</text>']
    for index in range(round((axes.down[1] - axes.down[0]) / step) + 1):
        value = axes.down[0] + index * step
        y = axes.place(math.exp(axes.across[0]), value)[1]
        parts.append(f'<path d="M{LEFT} {y:.1f}H{right}" stroke="#ddd"/>')
        parts.append(f'<text x="{LEFT - 6}" y="{y + 4:.1f}" text-anchor="end">{value:.4g}</text>')
    for size in panel.sizes:
        x = axes.place(size, axes.down[0])[0]
        parts.append(f'<path d="M{x:.1f} {bottom}v4" stroke="#777"/>')
        parts.append(f'<text x="{x:.1f}" y="{bottom + 17}" text-anchor="middle">{size / 1000:g}</text>')
    parts.append(f'<text x="{(LEFT + right) / 2:.0f}" y="{bottom + 33}" text-anchor="middle">KB</text>')
    return parts


def _curves(panel: Panel, axes: _Axes) -> list[str]:
    parts, labels = [], []
    for index, (name, curve) in enumerate(panel.curves.items()):
        places = [axes.place(*point) for point in sorted(curve)]
        if not places:
            continue
        color = COLORS[index % len(COLORS)]
        line = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
        parts.append(f'<polyline points="{line}" fill="none" stroke="{color}" stroke-width="2"/>')
        parts += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="2.5" fill="{color}"/>' for x, y in places]
        labels.append((places[-1][1] + 4, name, color))
    lowest = -math.inf
    for y, name, color in sorted(labels):
        lowest = max(y, lowest + LABEL_GAP)
        parts.append(f'<text x="{WIDTH - RIGHT + 8}" y="{lowest:.1f}" fill="{color}">{name}</text>')
    return parts
