"""Coverage by a path of Gaussians in plain Python, one number at a time, to check the splat reference."""

from __future__ import annotations

import math

import torch
from torch import Tensor

from reference.splatting import Settings

Point = tuple[float, float]


def literal_coverage(points: list[Point], opacity: float, settings: Settings, height: int, width: int) -> Tensor:
    """Return the coverage [h, w] of one path, exactly as it is defined."""
    rows = literal_rows(points, settings)
    image = torch.empty(height, width, dtype=torch.float64)
    for i in range(height):
        for j in range(width):
            clear = 1.0
            for r, k in [(r, k) for r in range(settings.lines + 2) for k in range(settings.samples)]:
                clear *= 1.0 - literal_alpha(rows, r, k, settings, (j + 0.5, i + 0.5), opacity)
            image[i, j] = 1.0 - clear
    return image


def literal_rows(points: list[Point], settings: Settings) -> list[list[Point]]:
    """Return the positions row by row, from Bernstein polynomials."""
    loop = [*points, points[0]]
    middle = settings.degree * (len(points) // settings.degree // 2)
    rows = []
    for w in literal_weights(settings.lines):
        row = []
        for k in range(settings.samples):
            u = 0.007 + 0.986 * k / (settings.samples - 1)
            a = literal_curve(loop[: middle + 1], settings.degree, u)
            b = literal_curve(loop[middle:][::-1], settings.degree, u)
            row.append(((1 - w) * a[0] + w * b[0], (1 - w) * a[1] + w * b[1]))
        rows.append(row)
    return rows


def literal_weights(lines: int) -> list[float]:
    x = [0.0] if lines == 1 else [-2.0 + 4.0 * line / (lines - 1) for line in range(lines)]
    return [0.0, *(0.5 + 0.5 * math.erf(value / (0.85 * math.sqrt(2.0))) for value in x), 1.0]


def literal_curve(chain: list[Point], degree: int, u: float) -> Point:
    count = (len(chain) - 1) // degree
    piece = min(int(u * count), count - 1)
    t = u * count - piece
    weight = [math.comb(degree, j) * t**j * (1 - t) ** (degree - j) for j in range(degree + 1)]
    control = chain[degree * piece : degree * piece + degree + 1]
    return sum(w * p[0] for w, p in zip(weight, control, strict=True)), sum(
        w * p[1] for w, p in zip(weight, control, strict=True)
    )


def literal_alpha(rows: list[list[Point]], r: int, k: int, settings: Settings, pixel: Point, opacity: float) -> float:
    row, last = rows[r], settings.samples - 1
    sx = 2 / 3 * (math.dist(row[k + 1], row[k]) if k < last else math.dist(row[last], row[last - 1]))
    sx *= 0.4 if k in (0, last) else 0.9 if k in (1, last - 1) else 1.0
    weights = literal_weights(settings.lines)
    at_boundary = r in (0, settings.lines + 1)
    gap = weights[1] if at_boundary else weights[r + 1] - weights[r]
    sy = 2 / 3 * gap * math.dist(rows[0][k], rows[-1][k])
    if at_boundary:
        sx, sy = max(sx, 0.3), min(max(sy, 0.75), 1.0)
    elif sy < 0.1:
        sx, sy = min(sx, 3.0 * sy), min(sy, 3.0 * sx)
    sx, sy = max(sx, 0.01), max(sy, 0.01)
    middle = min(max(k, 1), last - 1)
    before, after = (row[0], row[last]) if last < 2 else (row[middle - 1], row[middle + 1])
    tx, ty = after[0] - before[0], after[1] - before[1]
    length = math.hypot(tx, ty)
    tx, ty = (1.0, 0.0) if length < 1e-6 else (tx / length, ty / length)
    dx, dy = pixel[0] - row[k][0], pixel[1] - row[k][1]
    along, across = (dx * tx + dy * ty) / sx, (dy * tx - dx * ty) / sy
    alpha = min(opacity * math.exp(-(along**2 + across**2) / 2), 0.999)
    return alpha if alpha >= 1 / 255 else 0.0
