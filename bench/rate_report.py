"""The table, the curves and the Bjontegaard gains of `bench/rate.py`."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from harness import markdown_table
from PIL import Image, ImageDraw
from scipy.interpolate import PchipInterpolator

from warpvec.svg.measure import draw

Curve = Sequence[tuple[float, float]]
"""Points (bytes, value), such as decibels."""

WIDTH, HEIGHT, LEFT, BOTTOM, TOP, RIGHT = 900, 560, 60, 40, 20, 170

COLORS = ("#d22", "#e80", "#26c", "#292", "#737", "#555", "#0aa")


def gain(before: Curve, after: Curve) -> float:
    """Return the Bjontegaard gain: the mean of ``after`` above ``before`` over the logarithm of the bytes.

    Both curves are interpolated by monotone cubics, and compared over the bytes that both reach. NaN if these are none.
    """
    curves = [sorted((math.log(size), value) for size, value in curve) for curve in (before, after)]
    low, high = max(curve[0][0] for curve in curves), min(curve[-1][0] for curve in curves)
    if min(map(len, curves)) < 2 or high <= low:
        return math.nan
    integrals = [float(PchipInterpolator(*zip(*curve, strict=True)).integrate(low, high)) for curve in curves]
    return (integrals[1] - integrals[0]) / (high - low)


def table(curves: Mapping[str, Mapping[int, tuple[float, float]]], sizes: Sequence[int], name: str) -> str:
    """Return a Markdown table with a row a method and a column a size; ``curves`` has (bytes, value) by size."""
    digits = 2 if name == "PSNR" else 3
    rows = [
        [method, *(f"{curve[size][1]:.{digits}f}" if size in curve else "-" for size in sizes)]
        for method, curve in curves.items()
    ]
    return markdown_table([f"{name} at bytes", *(f"{size:,}" for size in sizes)], rows)


def draw_curves(curves: Mapping[str, Curve], path: Path, unit: str) -> None:
    """Write a PNG with the ``curves``, the bytes on a logarithmic axis, and the names beside their ends."""
    points = [point for curve in curves.values() for point in curve]
    if not points:
        return
    across = (min(point[0] for point in points), max(point[0] for point in points) * 1.0001)
    down = (min(point[1] for point in points), max(point[1] for point in points) + 1e-6)

    def at(size: float, value: float) -> tuple[float, float]:
        x = LEFT + (WIDTH - LEFT - RIGHT) * math.log(size / across[0]) / math.log(across[1] / across[0])
        y = HEIGHT - BOTTOM - (HEIGHT - BOTTOM - TOP) * (value - down[0]) / (down[1] - down[0])
        return x, y

    lines = [f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#fff"/>', _axes()]
    labels = []
    for index, (name, curve) in enumerate(curves.items()):
        places = [at(*point) for point in sorted(curve)]
        if not places:
            continue
        color = COLORS[index % len(COLORS)]
        text = " ".join(f"{x:.1f},{y:.1f}" for x, y in places)
        lines.append(f'<polyline points="{text}" fill="none" stroke="{color}" stroke-width="2"/>')
        lines += [f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3" fill="{color}"/>' for x, y in places]
        labels.append((places[-1][0] + 8, places[-1][1] - 6, name, color))
    svg = f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}">{"".join(lines)}</svg>'
    picture = Image.fromarray(draw(svg, WIDTH, HEIGHT))
    _write_labels(ImageDraw.Draw(picture), labels, across, down, unit)
    path.parent.mkdir(parents=True, exist_ok=True)
    picture.save(path)


def _axes() -> str:
    bottom, right = HEIGHT - BOTTOM, WIDTH - RIGHT
    return f'<path d="M{LEFT} {TOP}V{bottom}H{right}" fill="none" stroke="#999"/>'


def _write_labels(
    pen: ImageDraw.ImageDraw,
    labels: list[tuple[float, float, str, str]],
    across: tuple[float, float],
    down: tuple[float, float],
    unit: str,
) -> None:
    for x, y, name, color in labels:
        pen.text((x, y), name, fill=color)
    bottom = HEIGHT - BOTTOM
    for value, y in ((down[0], bottom - 12), (down[1], TOP)):
        pen.text((4, y), f"{value:.3g} {unit}", fill="black")
    for size, x in ((across[0], LEFT), (across[1], WIDTH - RIGHT - 40)):
        pen.text((x, bottom + 8), f"{size / 1000:,.1f} KB", fill="black")


def means(
    found: Mapping[str, Mapping[int, Sequence[tuple[float, float]]]],
) -> dict[str, dict[int, tuple[float, float]]]:
    """Return the mean (bytes, value) of each method and size over the photos."""
    return {
        method: {size: (float(pair[0]), float(pair[1])) for size, pair in _mean_pairs(sizes)}
        for method, sizes in found.items()
    }


def _mean_pairs(sizes: Mapping[int, Sequence[tuple[float, float]]]) -> list[tuple[int, np.ndarray]]:
    return [(size, np.mean(pairs, axis=0)) for size, pairs in sorted(sizes.items()) if pairs]
