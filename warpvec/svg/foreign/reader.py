"""Read the SVGs of other programs: as outlines where a scene can represent them, with a remark for everything else."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from dataclasses import replace
from itertools import islice
from types import SimpleNamespace
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from warpvec.errors import InputError
from warpvec.geometry.stops import STOPS_MAX
from warpvec.svg.document import layer_level, local_name
from warpvec.svg.foreign.blur import read_filter
from warpvec.svg.foreign.budget import ElementCounter, reference_of
from warpvec.svg.foreign.clip import Clips
from warpvec.svg.foreign.fill import Fills, fraction
from warpvec.svg.foreign.painter import Painter
from warpvec.svg.foreign.shapes import SHAPES, compose, load_parser, read_matrix
from warpvec.svg.foreign.state import State
from warpvec.svg.foreign.style import INHERITED, StyleSheet
from warpvec.svg.resvg_work import LANGUAGES
from warpvec.svg.units import NUMBER, parse_length, stated_size

MAX_ELEMENTS = 2**15
"""Largest number of drawn elements, counting each <use>: a few lines of <use> can draw any number of elements. Ellipses
take 0.3 ms each if they are equal, so that all take 10 s, and 0.6 ms if each is another; strokes and gradients take
about 1 ms more. What can take longer has a limit of its own for the file: `skia.MAX_EFFORT`, `bands.RAMP_EFFORT` and
`clip.CLIP_EFFORT`."""

MAX_NUMBERS = 2**20
"""Largest number of coordinates and commands of all drawn elements, counting each <use>. One takes 4 to 8
microseconds."""

_LETTERS_PER_NUMBER = 16
"""Letters of any attribute that take as long as a coordinate; matrices take the longest, 0.5 microseconds each."""

MAX_USE_DEPTH = 150
"""Deepest nesting of elements, through <use> as well. Each takes a few of the thousand calls that Python can nest."""

_NUMBER = re.compile(rf"{NUMBER}|[A-Za-z]")
_GROUPS = frozenset({"g", "a", "svg", "switch"})
_DRAWN = SHAPES | _GROUPS | {"use"}
_OMITTED_ELEMENTS = {
    "text": "text", "image": "image", "foreignObject": "foreign object", "video": "video", "audio": "audio",
    "canvas": "canvas", "iframe": "frame", "animate": "animation", "animateTransform": "animation",
    "animateMotion": "animation", "set": "animation",
}  # fmt: skip
_REMARKS = {
    "group opacity": "given to each of its paths, which shows where they overlap",
    "group blur": "given to each of its paths, which shows where they overlap",
    "uneven blur": "made as wide both ways",
    "blur beyond the limit": "made narrower",
    "self-crossing even-odd fill": "filled by the non-zero rule",
    "gradient of many stops": f"reduced to {STOPS_MAX}",
    "gradient beyond the limit of stops": "given its mean colour",
    "gradient part": f"drawn apart, because a path has at most {STOPS_MAX} stops",
    "steep radial gradient": "drawn in rings",
    "gradient out of reach": "its last colour was taken",
    "repeating gradient": "drawn once",
    "dashed stroke": "drawn as its outline",
    "unevenly scaled stroke": "drawn as its outline",
    "stroke with a gradient": "drawn as its outline",
    "non-scaling stroke": "scaled with the drawing",
    "stated length of a path": "ignored",
    "gradient with a focus": "centred",
    "nested drawing": "not cut off at its edges",
    "broken path": "kept as far as it can be read",
}
"""Kind of omission -> what was done instead. Everything else is left out."""

_HEAD = re.compile(r"(.*?)((?: (?:beyond|of|on|out|to|with) .*)?)")
"""The part of a kind of omission that takes the plural, and the rest."""


class ForeignReader:
    """A walk over the tree ``root`` in the order of renderers, which counts the content that is left out.

    Attributes:
        size: width and height of the canvas in pixels.
        painter: has the filled shapes and strokes, and the background.
        sources: for each outline of the painter the place of its shape among all that are drawn, from 0. A rectangle
            with the id "background" does not count.
        shape_count: number of those shapes; some draw nothing.

    Raises:
        InputError: svgelements is missing, or the file states no size or draws too many elements.
    """

    def __init__(self, root: Element) -> None:
        load_parser()
        self.size = stated_size(root.attrib)
        self._sheet = StyleSheet(root)
        self._by_id = {name: element for element in root.iter() if (name := element.get("id"))}
        self.painter = Painter(Fills(self._sheet, self._by_id), self.size)
        self._omitted = self.painter.omitted
        self._clips = Clips(self._by_id, self.size)
        self._in_use: set[str] = set()
        self.sources: list[int] = []
        self.shape_count = 0
        self._element_count = self._number_count = 0
        self._omitted["style rule"] += len(self._sheet.unknown)
        if self._sheet.is_empty:
            counter = ElementCounter(self._by_id, _DRAWN, MAX_USE_DEPTH)
            if sum(map(counter.count, root)) > MAX_ELEMENTS:
                raise _too_many_elements()
        self._walk_layers(root)

    @property
    def omitted(self) -> list[str]:
        """A remark for each kind of thing that the outlines do not show, such as "3 strokes: left out"."""
        return [_remark(what, count) for what, count in self._omitted.items() if count]

    def _walk_layers(self, root: Element) -> None:
        """Visit the children of the root; each group among them is a generation."""
        properties = self._sheet.properties(root, dict(INHERITED))
        if properties["display"] == "none":
            return
        matrix, viewport = self._view(root, *self.size)
        opacity = fraction(properties["opacity"])
        state = State(matrix, properties, opacity, 0, viewport)
        layer_index = 0
        for child in root:
            if local_name(child.tag) == "g":
                state = replace(state, generation=layer_level(child.get("id"), layer_index))
                layer_index += 1
            self._visit(child, state)

    def _visit(self, element: Element, above: State) -> None:
        name = local_name(element.tag)
        if name in _OMITTED_ELEMENTS:
            self._omitted[_OMITTED_ELEMENTS[name]] += 1
        if name not in _DRAWN or not _is_for_all(element):
            return
        self._count(element, above)
        properties = self._sheet.properties(element, above.properties)
        if properties["display"] == "none":
            return
        self._omitted["mask"] += properties["mask"] != "none"
        self._omitted["blend mode"] += properties["mix-blend-mode"] != "normal"
        state = replace(
            above,
            matrix=self._moved(above.matrix, properties["transform"]),
            properties=properties,
            opacity=above.opacity * fraction(properties["opacity"]),
            depth=above.depth + 1,
        )
        blur = read_filter(properties["filter"], state.matrix, self._by_id, self._omitted)
        state = replace(state, softness=math.hypot(above.softness, blur))
        painter = self.painter
        before, background = len(painter.outlines), painter.background
        if name in SHAPES:
            painter.draw(name, element.attrib, state)
            for index in range(before, len(painter.outlines)):
                painter.outlines[index] = replace(painter.outlines[index], softness=state.softness)
                self.sources.append(self.shape_count)
            self.shape_count += element.get("id") != "background"
        else:
            self._visit_group(element, name, state)
        covered = painter.background is not None and background is None
        drawn = painter.outlines[before:]
        self._omitted["clip path"] += self._clips.cut(properties["clip-path"], state, drawn, covered)

    def _visit_group(self, element: Element, name: str, state: State) -> None:
        before = len(self.painter.outlines)
        if name == "use":
            self._visit_target(element, state)
        else:
            if name == "svg":
                self._visit_placed(element, state)
            else:
                self._visit_children(element, name, state)
        translucent = 0 < fraction(state.properties["opacity"]) < 1
        is_blurred = state.properties["filter"] != "none" and state.softness > 0.0
        self._omitted["group blur"] += is_blurred and len(self.painter.outlines) > before + 1
        self._omitted["group opacity"] += translucent and len(self.painter.outlines) > before + 1

    def _visit_children(self, element: Element, name: str, state: State) -> None:
        if name == "switch":
            children: Iterable[Element] = islice(filter(_is_chosen, element), 1)
        else:
            children = element
        for child in children:
            self._visit(child, state)

    def _visit_target(self, use: Element, state: State) -> None:
        """Visit the element that <use> refers to, at the place of <use>; a symbol is drawn like an <svg>."""
        name = reference_of(use)
        target = self._by_id.get(name)
        if target is None or name in self._in_use:
            self._omitted["reference to nothing"] += 1
            return
        state = replace(state, matrix=compose(state.matrix, _shift(use, state)))
        self._in_use.add(name)
        if local_name(target.tag) in ("symbol", "svg"):
            state = replace(state, properties=self._sheet.properties(target, state.properties))
            self._visit_placed(target, state, use)
        else:
            self._visit(target, state)
        self._in_use.remove(name)

    def _moved(self, matrix: NDArray[np.float64], transform: str) -> NDArray[np.float64]:
        try:
            return compose(matrix, read_matrix(transform))
        except ValueError:
            self._omitted["broken transform"] += 1
            return matrix

    def _visit_placed(self, element: Element, state: State, use: Element | None = None) -> None:
        """Visit what is in a nested <svg>, or in a <symbol> of the size that its <use> states."""
        sizes = {**element.attrib, **({} if use is None else use.attrib)}
        across, down = state.viewport
        size = parse_length(sizes.get("width", "100%"), across), parse_length(sizes.get("height", "100%"), down)
        shift = _shift(element, state) if use is None else np.eye(2, 3)
        view, viewport = self._view(element, *size)
        place, painter = compose(state.matrix, shift), self.painter
        before, background = len(painter.outlines), painter.background
        self._visit_children(element, "g", replace(state, matrix=compose(place, view), viewport=viewport))
        if state.properties["overflow"] not in ("visible", "auto"):
            covered = painter.background is not None and background is None
            self._omitted["nested drawing"] += self._clips.cut_by_box(size, place, painter.outlines[before:], covered)

    def _view(self, element: Element, width: float, height: float) -> tuple[NDArray[np.float64], tuple[float, float]]:
        """Return the matrix from the view box of ``element`` to ``width`` x ``height``, and the size of the box."""
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

    def _count(self, element: Element, state: State) -> None:
        """Count the elements to draw before they are read, and raise InputError if there are too many.

        Elements that a <use> repeats count again.
        """
        self._element_count += 1
        if self._element_count > MAX_ELEMENTS or state.depth > MAX_USE_DEPTH:
            raise _too_many_elements()
        self._number_count += sum(map(len, element.attrib.values())) // _LETTERS_PER_NUMBER
        for name in ("d", "points"):
            self._number_count += sum(1 for _ in _NUMBER.finditer(element.get(name, "")))
        if self._number_count > MAX_NUMBERS:
            rule = f"must draw at most {MAX_NUMBERS} numbers, counting each <use>"
            raise InputError("SVG", rule, "more", "simplify it")


def _is_chosen(element: Element) -> bool:
    """Return whether a <switch> may choose an element."""
    return local_name(element.tag) in (*_DRAWN, "text", "image") and _is_for_all(element)


def _is_for_all(element: Element) -> bool:
    """Return whether an element is drawn by programs that have the languages of `warpvec.svg.resvg_work`."""
    languages = element.get("systemLanguage")
    is_spoken = languages is None or any(each.strip().split("-")[0] in LANGUAGES for each in languages.split(","))
    return is_spoken and element.get("requiredExtensions") is None


def _too_many_elements() -> InputError:
    rule = f"must draw at most {MAX_ELEMENTS} elements, {MAX_USE_DEPTH} deep, counting each <use>"
    return InputError("SVG", rule, "more", "simplify it")


def _shift(element: Element, state: State) -> NDArray[np.float64]:
    """Return the matrix [2, 3] that moves by the attributes x and y of ``element``."""
    x, y = (parse_length(element.get(key, ""), whole) for key, whole in zip("xy", state.viewport, strict=True))
    return np.array([[1.0, 0.0, x], [0.0, 1.0, y]])


def _remark(what: str, count: int) -> str:
    done = _REMARKS.get(what, "left out")
    if count == 1:
        return f"1 {what}: {done}"
    head, tail = _HEAD.fullmatch(what).groups()  # type: ignore[union-attr]
    plural = head + ("es" if head.endswith("x") else "s") + tail
    return f"{count} {plural}: {done.replace('its ', 'their ').replace('colour was', 'colours were')}"
