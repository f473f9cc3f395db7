"""Draw a soft path by rings: sharp paths on each other, each at a level of what the soft path covers."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import torch
from contourpy import contour_generator

from warpvec.arrays import Floats
from warpvec.geometry.bezier import path_boxes
from warpvec.geometry.loops import make_scene
from warpvec.geometry.scene import Scene
from warpvec.purposes.levels import CLOSE, STEP, opacities
from warpvec.purposes.loops import outline_of, short_numbers
from warpvec.purposes.smooth_curves import smooth_curve
from warpvec.rendering.draw import draw_exactly

_CELLS = 4.0
"""Cells of the grid in a standard deviation: a Gaussian edge is then interpolated within 1 % of its height."""

_SIDE_MAX = 2048
"""Longest side of the grid in cells."""

_REACH = 3.5
"""Standard deviations from a path beyond which nothing of it shows."""

_EDGE = 2.5
"""Width of a blurred edge in standard deviations, if it rose evenly: the root of two pi."""

_APART = 1.25
"""Least distance of rings in units: the edge of a path, as it is drawn, rises over one pixel by itself."""

_FLAT, _BINS = 0.01, 49
"""Share of the height of an edge within which it is level, as ``_CELLS`` shows no less, and bins of twice that."""

_POINTS_MIN = 8
"""Fewest points of a ring: smaller ones are specks of a few cells."""


def rings_of(one: Scene, width: float, height: float, threads: int | None = None) -> Scene:
    """Return the rings of the soft path that ``one`` has, on a canvas of ``width`` x ``height`` units, without a blur.

    They have its colour or gradient. There are none if nothing of it shows on the canvas.
    """
    assert one.softness is not None
    sigma, total = float(one.softness.sigma), float(one.opacity)
    field, left, top, scale = _coverage(one, sigma, width, height, threads)
    peak = float(field.max(initial=0.0))
    covered = peak * _covered(field[field > 0.0] / peak, total * peak * _contrast(one), _EDGE * sigma / _APART)
    levels, shown = (covered[:-1] + covered[1:]) / 2.0, opacities((total * covered[1:]).tolist())
    count, lines = len(levels), contour_generator(z=np.pad(field, 1))
    red, green, blue = one.color[0].tolist()
    color, outlines = (red, green, blue), []
    for level, opacity in zip(levels, shown, strict=True):
        tolerance = CLOSE * _EDGE * sigma / count
        closed = _closed(lines.lines(level))
        loops = [smooth_curve(line / scale + (left, top), tolerance) for line in closed]
        loops = [loop._replace(points=short_numbers(loop.points, tolerance)) for loop in loops]
        if loops and opacity > 0.0:
            outlines.append(outline_of(loops, color, opacity, int(one.generation)))
    made = make_scene(outlines, None)
    same = torch.zeros(len(made), dtype=torch.long)
    paints = None if one.gradients is None else one.gradients.map(lambda values: values[same])
    return replace(made, background=one.background, transparent=one.transparent, gradients=paints)


def _contrast(one: Scene) -> float:
    """Return how far the colour of a path is from black or white, whichever is farther; 1 for a gradient."""
    if one.gradients is not None:
        return 1.0
    color = one.color[0].double()
    return max(float((color - ground).square().mean().sqrt()) for ground in (0.0, 1.0))


def _covered(shares: Floats, change: float, most: float) -> Floats:
    """Return what rings on each other cover [rings + 1], from 0 for none to 1 for all of them.

    The steps are small where much is shaded alike, so that all err alike: the density of codes of least squared error
    goes with the cube root of that of the values (P. F. Panter, W. Dite, "Quantization distortion in pulse-count
    modulation with nonuniform spacing of levels", Proc. IRE, 1951). As many rings err as even steps of ``STEP`` would.

    Args:
        shares: what the soft path covers of each cell that it reaches, as shares of the most [K].
        change: of the colour from none to all.
        most: most rings.
    """
    density, edges = np.histogram(shares, _BINS, (_FLAT, 1.0 - _FLAT))
    codes = np.append(0.0, np.cbrt(density / max(1, density.sum()) * _BINS).cumsum() / _BINS)
    count = max(1, math.ceil(min(change / STEP * codes[-1] ** 1.5, most)))
    covered: Floats = np.interp(np.linspace(0.0, codes[-1], count + 1), codes, edges)
    covered[0], covered[-1] = 0.0, 1.0
    return covered


def _coverage(
    one: Scene, sigma: float, width: float, height: float, threads: int | None
) -> tuple[Floats, float, float, float]:
    """Return what a soft path covers [h, w], the place of its corner, and the cells in a unit."""
    reach = _REACH * sigma + (0.0 if one.strokes is None else float(one.strokes.reach.max()))
    box = path_boxes(one).double()[0]
    low = torch.maximum(box[:2] - reach, torch.full((2,), -reach))
    high = torch.minimum(box[2:] + reach, torch.tensor([width, height], dtype=torch.float64) + reach)
    if bool((high <= low).any()):
        return np.zeros((2, 2)), 0.0, 0.0, 1.0
    scale = min(_CELLS / sigma, _SIDE_MAX / float((high - low).max()))
    columns, rows = (max(2, math.ceil(side)) for side in ((high - low) * scale).tolist())
    black = replace(one, color=torch.zeros(1, 3), opacity=torch.ones(1), gradients=None)
    black = replace(black, background=torch.ones(3), transparent=False)
    moved = black.moved(-float(low[0]), -float(low[1])).scaled(scale, scale)
    field = 1.0 - draw_exactly(moved, rows, columns, threads)[..., 0].astype(np.float64)
    return field, float(low[0]), float(low[1]), scale


def _closed(lines: Any) -> list[Floats]:
    """Return closed lines [K, 2] without their last point, in cells from the corner of the grid."""
    return [line[:-1] - 0.5 for line in lines if len(line) > _POINTS_MIN]
