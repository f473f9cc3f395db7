"""Draw the shapes of an SVG: fills and strokes become outlines in pixels."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from warpvec.errors import InputError
from warpvec.geometry import loops as loop_limits
from warpvec.geometry.loops import Color, Outline, OutlineForm, OutlineStroke
from warpvec.svg.foreign.fill import Fill, Fills, fraction
from warpvec.svg.foreign.fill_rule import to_nonzero
from warpvec.svg.foreign.forms import shape_form
from warpvec.svg.foreign.gradients import Space
from warpvec.svg.foreign.shapes import (
    Loop,
    Subpath,
    apply,
    bounding_box,
    closed_loops,
    moved,
    open_curves,
    read_subpaths,
    shape_data,
)
from warpvec.svg.foreign.skia import Combiner
from warpvec.svg.foreign.state import State
from warpvec.svg.foreign.stroke import (
    MAX_DASHES,
    RESOLUTION,
    Stroke,
    dash_count,
    outline,
    read_stroke,
    similarity_scale,
    stroked_loop,
)

MAX_REACH = 2.0**24
"""Largest distance of a point from the origin in pixels; up to it float32 tells neighbouring pixels apart."""

_STEEPEST = 1e6
"""Largest ratio of the two scales of a transform under which strokes are made."""


class Painter:
    """Draws shapes one upon the other.

    Attributes:
        outlines: what it has drawn, from bottom to top.
        background: colour of the rectangle that covers the canvas, None without one.
        omitted: counts what the outlines do not show.

    Raises:
        InputError: the outlines have too many curves.
    """

    def __init__(self, fills: Fills, size: tuple[float, float]) -> None:
        self.outlines: list[Outline] = []
        self.background: Color | None = None
        self.omitted: Counter[str] = Counter()
        self._fills = fills
        self._size = size
        self._combiner = Combiner()
        self._curve_count = 0
        self._dash_count = 0.0
        self._read: dict[str, tuple[list[Subpath], bool]] = {}

    def draw(self, name: str, attributes: Mapping[str, str], state: State) -> None:
        """Draw the shape ``name``."""
        properties = state.properties
        if properties["visibility"] != "visible":
            return
        self.omitted["marker"] += any(properties[f"marker-{place}"] != "none" for place in ("start", "mid", "end"))
        fill = self._visible(self._fills.read(properties, self.omitted), state)
        stroke = self._stroke(attributes, state)
        subpaths = self._subpaths(shape_data(name, attributes, *state.viewport)) if fill or stroke else []
        if not subpaths:
            return
        box = bounding_box(np.concatenate([open_curves(subpath) for subpath in subpaths]))
        space = Space(state.matrix, box, state.viewport, self._size)
        form = shape_form(name, attributes, state.viewport, state.matrix)
        is_below = properties["paint-order"].partition("fill")[0].strip().startswith("stroke")
        drawn = 0
        for role in ("stroke", "fill") if is_below else ("fill", "stroke"):
            before = len(self.outlines)
            if role == "fill" and fill is not None:
                self._add_fill(name, subpaths, form, fill, space, state)
            elif role == "stroke" and stroke is not None:
                self._add_stroke(subpaths, form, *stroke, space, state)
            drawn += len(self.outlines) > before
        self.omitted["group opacity"] += drawn > 1 and 0 < fraction(properties["opacity"]) < 1

    def _visible(self, paint: Fill | None, state: State) -> Fill | None:
        return paint if paint is not None and paint.opacity * state.opacity > 0 else None

    def _stroke(self, attributes: Mapping[str, str], state: State) -> tuple[Stroke, Fill] | None:
        if state.properties["stroke"] in ("none", ""):
            return None
        stroke = read_stroke(state.properties, state.viewport)
        paint = self._fills.read(state.properties, self.omitted, "stroke") if stroke is not None else None
        paint = self._visible(paint, state)
        if stroke is None or paint is None:
            return None
        self.omitted["non-scaling stroke"] += state.properties["vector-effect"] == "non-scaling-stroke"
        self.omitted["stated length of a path"] += "pathLength" in attributes and bool(stroke.dashes)
        return stroke, paint

    def _subpaths(self, data: str) -> list[Subpath]:
        """Return the subpaths of ``data``, which are kept because <use> may draw them again and again."""
        if data not in self._read:
            self._read[data] = read_subpaths(data)
        subpaths, complete = self._read[data]
        self.omitted["broken path"] += not complete
        self._count(sum(len(subpath.is_line) for subpath in subpaths))
        return subpaths

    def _add_fill(
        self, name: str, subpaths: list[Subpath], form: OutlineForm | None, fill: Fill, space: Space, state: State
    ) -> None:
        loops = closed_loops(subpaths)
        points = apply(state.matrix, np.concatenate([np.zeros((0, 2)), *(loop.points for loop in loops)]))
        opacity = fill.opacity * state.opacity
        if not (np.abs(points) <= MAX_REACH).all():
            self.omitted[f"path beyond {MAX_REACH:.0f} pixels"] += 1
        elif loops and fill.gradient is None and self._is_canvas(name, points, opacity):
            self.background = fill.color
        elif loops:
            if state.properties["fill-rule"] == "evenodd":
                loops, is_same = to_nonzero(loops, self._combiner)
                self.omitted["self-crossing even-odd fill"] += not is_same
            self._add(moved(loops, state.matrix), fill, space, state, form)

    def _add_stroke(
        self, subpaths: list[Subpath], form: OutlineForm | None, stroke: Stroke, paint: Fill, space: Space, state: State
    ) -> None:
        scale = similarity_scale(state.matrix)
        if stroke.dashes:
            self._add_stroke_outline("dashed stroke", subpaths, stroke, paint, space, state)
        elif scale is None:
            self._add_stroke_outline("unevenly scaled stroke", subpaths, stroke, paint, space, state)
        elif paint.gradient is not None:
            self._add_stroke_outline("stroke with a gradient", subpaths, stroke, paint, space, state)
        else:
            self._keep_stroke(subpaths, form, stroke, scale, paint, state)

    def _keep_stroke(
        self, subpaths: list[Subpath], form: OutlineForm | None, stroke: Stroke, scale: float, paint: Fill, state: State
    ) -> None:
        """Add a stroke that a scene can have."""
        loops = [stroked_loop(subpath) for subpath in subpaths]
        points = apply(state.matrix, np.concatenate([loop.points for loop in loops]))
        if not ((np.abs(points) <= MAX_REACH).all() and scale * stroke.width <= MAX_REACH):
            self.omitted["stroke out of reach"] += 1
            return
        is_line = np.concatenate([loop.is_line for loop in loops])
        self._count(len(is_line))
        opacity = paint.opacity * state.opacity
        look = OutlineStroke(scale * stroke.width, stroke.cap, stroke.join, stroke.miter_limit)
        if form is not None:
            self.outlines.append(replace(Outline.of_form(form, paint.color, opacity, state.generation), stroke=look))
            return
        counts, is_open = tuple(len(loop.is_line) for loop in loops), tuple(not s.is_closed for s in subpaths)
        line = Outline(points, paint.color, opacity, state.generation, counts, is_line, stroke=look, is_open=is_open)
        self.outlines.append(line)

    def _add_stroke_outline(
        self, kind: str, subpaths: list[Subpath], stroke: Stroke, paint: Fill, space: Space, state: State
    ) -> None:
        """Add the outline of a stroke as a fill, and count its ``kind``."""
        if self._combiner.skia is None:
            self.omitted["stroke"] += 1
            return
        dashes = dash_count(subpaths, stroke)
        self._dash_count += dashes if dashes <= MAX_DASHES else 0.0
        if not (dashes <= MAX_DASHES and self._dash_count <= MAX_DASHES):
            self.omitted["too finely dashed stroke"] += 1
            return
        try:
            loops = moved(outline(subpaths, stroke, self._resolution(state.matrix), self._combiner.skia), state.matrix)
        except ValueError:
            self.omitted["stroke out of reach"] += 1
            return
        if not all(bool((np.abs(loop.points) <= MAX_REACH).all()) for loop in loops):
            self.omitted["stroke out of reach"] += 1
        elif loops:
            before = len(self.outlines)
            self._add(loops, paint, space, state)
            self.omitted[kind] += len(self.outlines) > before

    def _resolution(self, matrix: NDArray[np.float64]) -> float:
        """Return the units in which strokes are made per unit of user space.

        Raises:
            ValueError: the matrix flattens everything.
        """
        if not np.isfinite(matrix).all():
            raise ValueError("matrix is not finite")
        large, small = np.linalg.svd(matrix[:, :2], compute_uv=False).tolist()
        if not 0.0 < large <= _STEEPEST * small:
            raise ValueError("matrix is flat")
        return float(large * RESOLUTION / max(self._size))

    def _add(self, loops: list[Loop], paint: Fill, space: Space, state: State, form: OutlineForm | None = None) -> None:
        is_opaque = paint.opacity * state.opacity >= 1.0
        for part in self._fills.placed(paint, loops, is_opaque, space, self._combiner, self.omitted):
            opacity = part.opacity * state.opacity
            points = np.concatenate([loop.points for loop in part.loops])
            is_line = np.concatenate([loop.is_line for loop in part.loops])
            counts = tuple(len(loop.is_line) for loop in part.loops)
            self._count(len(is_line))
            outline = Outline(points, part.color, opacity, state.generation, counts, is_line, part.gradient)
            if form is not None and part.loops is loops:
                outline = replace(Outline.of_form(form, part.color, opacity, state.generation), gradient=part.gradient)
            self.outlines.append(outline)

    def _count(self, curves: int) -> None:
        """Count curves that are read and curves that are drawn.

        Raises:
            InputError: they are more than twice as many as a scene may have.
        """
        self._curve_count += curves
        if self._curve_count > 2 * loop_limits.MAX_CUBICS:
            rule = f"must have at most {loop_limits.MAX_CUBICS} curves"
            raise InputError("SVG", rule, "more", "simplify it")

    def _is_canvas(self, name: str, points: NDArray[np.float64], opacity: float) -> bool:
        """Return whether a shape is the lowest and covers the canvas, so that it is the background and not a path."""
        if self.outlines or name != "rect" or opacity < 1 or len(points) != 12:
            return False
        corners = points[::3]
        upright = (np.sort(corners, 0)[[0, 2]] == np.sort(corners, 0)[[1, 3]]).all()
        return bool(upright and (corners.min(0) <= 0).all() and (corners.max(0) >= self._size).all())
