"""The edges of a drawing, each once, for lasers: an edge that two parts share would be burnt twice."""

from __future__ import annotations

from dataclasses import replace
from functools import reduce

import numpy as np
import torch

from warpvec.flat.cutting.cut_lines import CutLine, cut_lines
from warpvec.geometry.loops import BLACK, make_scene
from warpvec.geometry.loops import Outline as Path
from warpvec.geometry.scene import Scene
from warpvec.making.arcs import with_arcs
from warpvec.making.parts import (
    Circle,
    Outline,
    Part,
    Shape,
    Sheet,
    Stroke,
    circle_of,
    millimeters_of_a_unit,
    parts_of,
    pieces_of,
    read_parts,
)  # fmt: skip
from warpvec.making.regions import stroke_edges
from warpvec.svg.read import read_svg
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
        InputError: as `warpvec.svg.read.read_svg`.
    """
    loaded = read_svg(svg)
    scale = millimeters_of_a_unit(svg, loaded.width, per_inch)
    width, height = loaded.width * scale, loaded.height * scale
    scene = loaded.scene.detach().cpu()
    lines = read_parts(svg, per_inch).parts if keeps_lines else ()
    if scene.strokes is not None:
        no_lines = scene.select(~scene.strokes.is_stroked)
        scene = no_lines if keeps_lines else _with_edges(scene, parts_of(scene, loaded.precision, scale), scale)
    # What is too thin to be cut is measured in pixels of 96 to an inch.
    scene = scene.outlined().scaled(scale / MM_PER_PIXEL)
    shapes = tuple(map(_shape, cut_lines(scene, width / MM_PER_PIXEL, height / MM_PER_PIXEL)))
    edges = (Part("#000000", shapes, _LINE, layer=LAYER),) if shapes else ()
    return Sheet((*edges, *(part for part in lines if part.stroke is not None)), width, height)


def _with_edges(scene: Scene, parts: list[Part], scale: float) -> Scene:
    """Return ``scene``, whose paths are ``parts``, with both edges of each stroke in place of its centre line."""
    found = [scene.select(torch.tensor([path])) for path in range(len(parts))]
    edged = [one if part.stroke is None else _filled(one, part, scale) for one, part in zip(found, parts, strict=True)]
    return replace(reduce(Scene.joined, edged), strokes=None)


def _filled(one: Scene, part: Part, scale: float) -> Scene:
    """Return the scene of one stroke, which is ``part``, with the stroke's area as its path."""
    shapes = [shape.outline if isinstance(shape, Circle) else shape for shape in stroke_edges(part).shapes]
    loops = [shape.pieces for shape in shapes if isinstance(shape, Outline)]
    rows = [[cubic for piece in loop for cubic in piece.cubics()] for loop in loops]
    is_line = [not piece.bulge for loop in loops for piece in loop for _ in piece.cubics()]
    points = np.concatenate([cubic[:3] for cubics in rows for cubic in cubics]) / scale
    drawn = make_scene([Path(points, BLACK, 1.0, 0, tuple(map(len, rows)), np.array(is_line))], None)
    values = {name: getattr(one, name) for name in ("color", "opacity", "background", "generation", "transparent")}
    return replace(drawn, **values, gradients=one.gradients)


def _shape(line: CutLine) -> Shape:
    cubics = np.stack([part.cubic for part in line.parts]) * MM_PER_PIXEL
    pieces = tuple(pieces_of(cubics, np.array([part.is_line for part in line.parts]), {}))
    whole = circle_of(pieces) if line.is_closed else None
    return whole or with_arcs(Outline(pieces, line.is_closed))
