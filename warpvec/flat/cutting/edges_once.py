"""The edges of a drawing, each once, for lasers: an edge that two parts share would be burnt twice."""

from __future__ import annotations

import numpy as np

from warpvec.flat.cutting.cut_lines import CutLine, cut_lines
from warpvec.making.parts import (
    Outline,
    Part,
    Shape,
    Sheet,
    Stroke,
    circle_of,
    millimeters_of_a_unit,
    pieces_of,
    read_parts,
)  # fmt: skip
from warpvec.svg.read import read_svg
from warpvec.svg.stroke_outlines import without_strokes
from warpvec.svg.units import MM_PER_PIXEL

LAYER = "cut"
"""Name of the layer of the edges."""

_LINE = Stroke(0.1, "round", "round", 4.0)


def edges_once(svg: str, per_inch: float = 96.0, *, keeps_lines: bool = False) -> Sheet:
    """Return the edges between what shows of the drawing ``svg``, as lines in its stated size, each edge once.

    The page is not cut out.

    Args:
        svg: SVG text of this program.
        per_inch: pixels of a drawing without a size in real units that make an inch.
        keeps_lines: keep strokes as their centre lines; otherwise their outlines are edges.

    Raises:
        InputError: as `warpvec.svg.read.read_svg`, or there are strokes and skia-pathops is not installed.
    """
    loaded = read_svg(svg)
    scale = millimeters_of_a_unit(svg, loaded.width, per_inch)
    width, height = loaded.width * scale, loaded.height * scale
    scene = loaded.scene.detach().cpu()
    lines = read_parts(svg, per_inch).parts if keeps_lines else ()
    scene = scene.select(~scene.strokes.is_stroked) if keeps_lines and scene.strokes is not None else scene
    # What is too thin to be cut is measured in pixels of 96 to an inch.
    scene = without_strokes(scene.outlined(), "the drawing").scaled(scale / MM_PER_PIXEL)
    shapes = tuple(map(_shape, cut_lines(scene, width / MM_PER_PIXEL, height / MM_PER_PIXEL)))
    edges = (Part("#000000", shapes, _LINE, layer=LAYER),) if shapes else ()
    return Sheet((*edges, *(part for part in lines if part.stroke is not None)), width, height)


def _shape(line: CutLine) -> Shape:
    cubics = np.stack([part.cubic for part in line.parts]) * MM_PER_PIXEL
    pieces = tuple(pieces_of(cubics, np.array([part.is_line for part in line.parts]), {}))
    whole = circle_of(pieces) if line.is_closed else None
    return whole or Outline(pieces, line.is_closed)
