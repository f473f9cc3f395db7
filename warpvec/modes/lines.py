"""Draw scans and drawings of lines: each line is one stroke along its middle."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import torch

from warpvec.config.fit_config import FitConfig
from warpvec.drawing.drawing import Drawing
from warpvec.errors import InputError
from warpvec.fit.loop import single_torch_thread
from warpvec.flat.constants.curves import CURVES
from warpvec.flat.lines.line import DrawnLine, scene_of
from warpvec.flat.lines.pen_travel import ordered, pen_travel
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
            tracing = trace_lines(request.picture.reduced, reduced_settings(request), tolerance, request.watch)
            if not tracing.lines:
                raise InputError("IN", "must have lines darker than their paper", "none", "look at the picture")
            return _drawing(request, tracing, detail)

        with single_torch_thread(), torch.no_grad():
            return drawn(request, draw)


def _drawing(request: Request, tracing: LineTracing, detail: float) -> Drawing:
    """Return the drawing of traced lines, with a path for each line, and a layer for each width."""
    pens = [ordered(pen) for pen in by_width(_with_width(tracing.lines, request))]
    scene = scene_of([[line] for pen in pens for line in pen])
    layer = torch.tensor([k for k, pen in enumerate(pens) for _ in pen], dtype=torch.int64)
    scale = 1.0 / _reduction(request)
    widths = [scale * pen[0].width for pen in pens]
    names = {k: f"lines of {width:.4g} px" for k, width in enumerate(widths)}
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


def _with_width(lines: list[DrawnLine], request: Request) -> list[DrawnLine]:
    """Return ``lines`` with the width that the settings ask for, if they do."""
    if request.settings.line_width == "auto":
        return lines
    width = float(request.settings.line_width) * _reduction(request)
    return [replace(line, width=width) for line in lines]


def _reduction(request: Request) -> float:
    """Return the length in the reduced picture of a pixel of the picture."""
    return math.sqrt(math.prod(request.picture.reduction))
