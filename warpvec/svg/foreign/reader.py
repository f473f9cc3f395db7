"""SVGs of other programs: what a scene can say of them, and the names of what it cannot."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from types import SimpleNamespace
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from warpvec.errors import InputError
from warpvec.geometry.loops import Color, Outline
from warpvec.svg.foreign.fill import Paints, fraction
from warpvec.svg.foreign.shapes import SHAPES, apply, compose, join, load_parser, read_loops, read_matrix, shape_data
from warpvec.svg.foreign.style import INHERITED, Properties, StyleSheet, local_name
from warpvec.svg.layers import layer_level
from warpvec.svg.units import parse_length, stated_size

MAX_ELEMENTS = 2**18
"""Elements drawn, each time that <use> draws them counted: a few lines of <use> can ask for any number."""

MAX_REACH = 2.0**24
"""Pixels that a point may be from the origin, where float32 still tells a pixel from the next."""

MAX_USE_DEPTH = 150
"""Elements inside each other, through <use> as well: a few calls each, of the thousand that Python has."""

_GROUPS = frozenset({"g", "a", "svg", "switch"})
_OMITTED_ELEMENTS = {
    "text": "text", "image": "image", "foreignObject": "foreign object", "video": "video", "audio": "audio",
    "canvas": "canvas", "iframe": "frame", "animate": "animation", "animateTransform": "animation",
    "animateMotion": "animation", "set": "animation",
}  # fmt: skip
_EFFECTS = {"clip-path": "clip path", "mask": "mask", "filter": "filter"}
_REMARKS = {
    "group opacity": "given to each of its paths, which shows where they overlap",
    "gradient fill": "its mean colour was taken",
    "compound path": "its parts were joined by lines of no width",
    "even-odd fill": "filled by the non-zero rule",
    "broken path": "kept as far as it can be read",
}
"""What was done about it; all else is left out."""


@dataclass(frozen=True)
class _State:
    """What an element has from its ancestors."""

    matrix: NDArray[np.float64]
    properties: Properties
    opacity: float
    generation: int
    viewport: tuple[float, float]
    depth: int = 0


class ForeignReader:
    """Walks over the tree ``root`` as a renderer does, and notes what it leaves out.

    Attributes:
        outlines: what is filled, from bottom to top.
        background: colour of the rectangle that covers the canvas, None without one.

    Raises:
        InputError: svgelements is missing, the file states no size, or draws more than ``MAX_ELEMENTS``.
    """

    def __init__(self, root: Element) -> None:
        load_parser()
        self.outlines: list[Outline] = []
        self.background: Color | None = None
        self._omitted: Counter[str] = Counter()
        self._sheet = StyleSheet(root)
        self._by_id = {name: element for element in root.iter() if (name := element.get("id"))}
        self._paints = Paints(self._sheet, self._by_id)
        self._in_use: set[str] = set()
        self._element_count = 0
        self._omitted["style rule"] += len(self._sheet.unknown)
        self.size = stated_size(root.attrib)
        self._walk_layers(root)

    @property
    def omitted(self) -> list[str]:
        """Everything that the outlines do not show, with its count: "3 strokes: left out"."""
        return [_remark(what, count) for what, count in self._omitted.items() if count]

    def _walk_layers(self, root: Element) -> None:
        """The root and its children: each group there is a generation."""
        properties = self._sheet.properties(root, dict(INHERITED))
        if properties["display"] == "none":
            return
        matrix, viewport = self._view(root, *self.size)
        opacity = fraction(properties["opacity"])
        state = _State(matrix, properties, opacity, 0, viewport)
        layer_index = 0
        for child in root:
            if local_name(child) == "g":
                state = replace(state, generation=layer_level(child.get("id"), layer_index))
                layer_index += 1
            self._visit(child, state)

    def _visit(self, element: Element, above: _State) -> None:
        name = local_name(element)
        if name in _OMITTED_ELEMENTS:
            self._omitted[_OMITTED_ELEMENTS[name]] += 1
        if name not in SHAPES and name not in _GROUPS and name != "use":
            return
        self._count(above)
        properties = self._sheet.properties(element, above.properties)
        if properties["display"] == "none":
            return
        self._note_effects(properties)
        state = replace(
            above,
            matrix=self._moved(above.matrix, properties["transform"]),
            properties=properties,
            opacity=above.opacity * fraction(properties["opacity"]),
            depth=above.depth + 1,
        )
        if name in SHAPES:
            self._fill(element, name, state)
        else:
            self._visit_group(element, name, state)

    def _visit_group(self, element: Element, name: str, state: _State) -> None:
        before = len(self.outlines)
        if name == "use":
            self._visit_target(element, state)
        else:
            state = self._placed(element, state) if name == "svg" else state
            self._visit_children(element, name, state)
        translucent = 0 < fraction(state.properties["opacity"]) < 1
        self._omitted["group opacity"] += translucent and len(self.outlines) > before + 1

    def _visit_children(self, element: Element, name: str, state: _State) -> None:
        for child in element:
            drawn = local_name(child) in SHAPES or local_name(child) in _GROUPS or local_name(child) == "use"
            self._visit(child, state)
            if name == "switch" and drawn:
                return

    def _visit_target(self, use: Element, state: _State) -> None:
        """What <use> refers to, in its place; a symbol is drawn as an <svg> would be."""
        href = next((value for key, value in use.attrib.items() if key.rpartition("}")[2] == "href"), "").strip()
        target = self._by_id.get(href[1:])
        if target is None or href in self._in_use:
            self._omitted["reference to nothing"] += 1
            return
        shift = np.eye(2, 3)
        shift[:, 2] = [parse_length(use.get(key, ""), whole) for key, whole in zip("xy", state.viewport, strict=True)]
        state = replace(state, matrix=compose(state.matrix, shift))
        self._in_use.add(href)
        if local_name(target) in ("symbol", "svg"):
            state = replace(state, properties=self._sheet.properties(target, state.properties))
            self._visit_children(target, "g", self._placed(target, state, use))
        else:
            self._visit(target, state)
        self._in_use.remove(href)

    def _fill(self, element: Element, name: str, state: _State) -> None:
        properties = state.properties
        if properties["visibility"] != "visible":
            return
        self._note_strokes(properties)
        paint = self._paints.fill(properties, self._omitted)
        opacity = 0.0 if paint is None else paint.opacity * state.opacity
        loops, whole = read_loops(shape_data(name, element.attrib, *state.viewport)) if opacity > 0 else ([], True)
        self._omitted["broken path"] += not whole
        if paint is None or not loops:
            return
        points = apply(state.matrix, join(loops))
        if not (np.abs(points) <= MAX_REACH).all():
            self._omitted[f"path beyond {MAX_REACH:.0f} pixels"] += 1
        elif self._is_canvas(name, points, opacity):
            self.background = paint.color
        else:
            self._omitted["compound path"] += len(loops) > 1
            self._omitted["even-odd fill"] += properties["fill-rule"] == "evenodd"
            self.outlines.append(Outline(points, paint.color, opacity, state.generation))

    def _is_canvas(self, name: str, points: NDArray[np.float64], opacity: float) -> bool:
        """Whether a shape at the bottom covers the canvas, so that it is the background and no path."""
        if self.outlines or name != "rect" or opacity < 1 or len(points) != 12:
            return False
        corners = points[::3]
        upright = (np.sort(corners, 0)[[0, 2]] == np.sort(corners, 0)[[1, 3]]).all()
        return bool(upright and (corners.min(0) <= 0).all() and (corners.max(0) >= self.size).all())

    def _note_strokes(self, properties: Properties) -> None:
        width = properties["stroke-width"]
        drawn = properties["stroke"] != "none" and fraction(properties["stroke-opacity"]) > 0
        self._omitted["stroke"] += drawn and (parse_length(width, 1.0) > 0 or not width[:1].isdigit())
        self._omitted["marker"] += any(properties[f"marker-{place}"] != "none" for place in ("start", "mid", "end"))

    def _note_effects(self, properties: Properties) -> None:
        for name, what in _EFFECTS.items():
            self._omitted[what] += properties[name] != "none"
        self._omitted["blend mode"] += properties["mix-blend-mode"] != "normal"

    def _moved(self, matrix: NDArray[np.float64], transform: str) -> NDArray[np.float64]:
        try:
            return compose(matrix, read_matrix(transform))
        except ValueError:
            self._omitted["broken transform"] += 1
            return matrix

    def _placed(self, element: Element, state: _State, use: Element | None = None) -> _State:
        """Inside a nested <svg>, or a <symbol> of the size that its <use> has."""
        sizes = {**element.attrib, **({} if use is None else use.attrib)}
        width, height = (
            parse_length(sizes.get(key, "100%"), whole)
            for key, whole in zip(("width", "height"), state.viewport, strict=True)
        )
        shift = np.eye(2, 3)
        if use is None:
            shift[:, 2] = [
                parse_length(element.get(key, ""), whole) for key, whole in zip("xy", state.viewport, strict=True)
            ]
        view, viewport = self._view(element, width, height)
        return replace(state, matrix=compose(state.matrix, compose(shift, view)), viewport=viewport)

    def _view(self, element: Element, width: float, height: float) -> tuple[NDArray[np.float64], tuple[float, float]]:
        """From the view box of ``element`` to ``width`` x ``height``, and the size of the box."""
        box = element.get("viewBox")
        if not box:
            return np.eye(2, 3), (width, height)
        try:
            view = load_parser().Viewbox(box, element.get("preserveAspectRatio"))
            place = SimpleNamespace(x=0, y=0, width=width, height=height)
            return read_matrix(view.transform(place)), (float(view.width), float(view.height))
        except Exception:
            self._omitted["broken view box"] += 1
            return np.eye(2, 3), (width, height)

    def _count(self, state: _State) -> None:
        self._element_count += 1
        if self._element_count > MAX_ELEMENTS or state.depth > MAX_USE_DEPTH:
            raise InputError(
                f"SVG must draw at most {MAX_ELEMENTS} elements, {MAX_USE_DEPTH} deep, counting each <use>,"
                " this one draws more; simplify it"
            )


def _remark(what: str, count: int) -> str:
    done = _REMARKS.get(what, "left out")
    if count == 1:
        return f"1 {what}: {done}"
    plural = what + ("es" if what.endswith("x") else "s")
    return f"{count} {plural}: {done.replace('its ', 'their ').replace('colour was', 'colours were')}"
