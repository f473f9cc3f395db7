"""Draw scans and drawings of lines: each line is one stroke along its middle."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import torch

from warpvec.config.fit_config import FitConfig
from warpvec.drawing.drawing import Drawing
from warpvec.errors import InputError
from warpvec.fit.loop import single_torch_thread
from warpvec.flat.color_layers.layering import color_name
from warpvec.flat.constants.curves import CURVES
from warpvec.flat.lines.dots import dot
from warpvec.flat.lines.line import DrawnLine, scene_of
from warpvec.flat.lines.pen_travel import ordered, pen_travel
from warpvec.flat.lines.pens import find_pens, with_fewer_pens, with_pens_of
from warpvec.flat.lines.tracing import LineTracing, trace_lines
from warpvec.flat.lines.widths import by_width
from warpvec.modes.flat import drawn, reduced_settings
from warpvec.modes.request import Request


@dataclass(frozen=True)
class Lines:
    """The mode of drawings of lines."""

    def draw(self, request: Request) -> Drawing:
        """Return the drawing of lines. A goal decides the detail.

        Raises:
            InputError: the picture has no ink, or the file is to be trimmed, which would cut strokes open.
        """
        if request.encoding.options.trim:
            rule = "must not be given in the mode lines, whose strokes are not cut"
            raise InputError("trim", rule, remedy="leave it out, or give another mode")

        def draw(detail: float) -> Drawing:
            tolerance = None if detail == FitConfig.detail else CURVES.tolerance * detail / FitConfig.detail
            tracing = _traced(request, tolerance, detail)
            apart = request.thin_lines
            dashes = [] if apart is None else [dash for line in apart.dashed for dash in line]
            marks = with_pens_of(tracing.lines, dashes + _dots(request))
            lines = with_fewer_pens(tracing.lines + marks, request.settings.pens)
            tracing = replace(tracing, lines=lines)
            if not tracing.lines:
                raise InputError("IN", "must have lines darker than their paper", "none", "look at the picture")
            return _drawing(request, tracing, detail)

        with single_torch_thread(), torch.no_grad():
            return drawn(request, draw)


def _traced(request: Request, tolerance: float | None, detail: float) -> LineTracing:
    """Return the lines of all pens, from bottom to top, or those of black ink if the picture has no colours."""
    image, settings = request.picture.reduced, replace(reduced_settings(request), detail=detail)
    pens = find_pens(image)
    if not pens:
        return trace_lines(image, settings, tolerance, request.watch)
    found = LineTracing([], 0)
    for pen in pens:
        paper = np.repeat(1.0 - pen.coverage[..., None], 3, 2).astype(np.float32)
        own = trace_lines(paper, settings, tolerance, request.watch)
        red, green, blue = np.rint(255.0 * pen.color) / 255.0
        lines = [replace(line, color=(float(red), float(green), float(blue))) for line in own.lines]
        found = LineTracing(
            found.lines + lines, found.speck_count + own.speck_count, found.wide_count + own.wide_count,
            found.faint_count + own.faint_count,
        )  # fmt: skip
    return found


def _dots(request: Request) -> list[DrawnLine]:
    """Return the dots that the picture is without."""
    scene = None if request.thin_lines is None else request.thin_lines.dots
    if scene is None or scene.forms is None:
        return []
    x_y_radius, colors = scene.forms.parameters[:, :3].double().numpy(), scene.color.tolist()
    return [
        dot(each[:2], 2.0 * float(each[2]), (red, green, blue))
        for each, (red, green, blue) in zip(x_y_radius, colors, strict=True)
    ]


def _drawing(request: Request, tracing: LineTracing, detail: float) -> Drawing:
    """Return the drawing of traced lines, with a path for each line, and a layer for each colour and width."""
    colors = dict.fromkeys(line.color for line in tracing.lines)
    lines = _with_width(tracing.lines, request)
    pens = [ordered(pen) for color in colors for pen in _pens([line for line in lines if line.color == color])]
    scene = scene_of([[line] for pen in pens for line in pen])
    layer = torch.tensor([k for k, pen in enumerate(pens) for _ in pen], dtype=torch.int64)
    scale = 1.0 / _reduction(request)
    widths = [scale * pen[0].width for pen in pens]
    names = {k: f"lines of {width:.4g} px" for k, width in enumerate(widths)}
    if any(map(any, colors)):
        names = {k: f"{color_name(np.array(pen[0].color))}, {names[k]}" for k, pen in enumerate(pens)}
    encoding = replace(
        request.encoding.of_drawing(), settings=replace(request.settings, detail=detail), layer_names=names
    )
    facts: dict[str, Any] = {
        "lines": sum(map(len, pens)),
        "line_widths": [round(width, 2) for width in widths],
        "wide_areas": tracing.wide_count,
        "pen_up": round(scale * pen_travel([line for pen in pens for line in pen]), 1),
    }
    left_out = {"speck": tracing.speck_count, "faint line": tracing.faint_count}
    return Drawing.of(replace(scene, generation=layer), encoding, "cpu", left_out=left_out, line_facts=facts)


def _pens(lines: list[DrawnLine]) -> list[list[DrawnLine]]:
    """Return ``lines`` of a colour in groups of a width: dots have the exact ones, which are their tone."""
    dots = [line for line in lines if line.is_dot]
    widths = sorted({line.width for line in dots}, reverse=True)
    others = by_width([line for line in lines if not line.is_dot])
    return others + [[line for line in dots if line.width == width] for width in widths]


def _with_width(lines: list[DrawnLine], request: Request) -> list[DrawnLine]:
    """Return ``lines`` with the width that the settings ask for, if they do."""
    if request.settings.line_width == "auto":
        return lines
    width = float(request.settings.line_width) * _reduction(request)
    return [replace(line, width=width) for line in lines]


def _reduction(request: Request) -> float:
    """Return the length in the reduced picture of a pixel of the picture."""
    return math.sqrt(math.prod(request.picture.reduction))
