"""Count the elements of an SVG that paint something."""

from __future__ import annotations

from collections import Counter

from warpvec.svg.found import shape_kind
from warpvec.svg.looks import Look
from warpvec.svg.parameters import form_parameters

_PAINTED = frozenset(
    {"path", "rect", "circle", "ellipse", "line", "polyline", "polygon", "text", "image", "use", "foreignObject"}
)

_FORM_SIZES = {"circle": "r", "ellipse": "rx", "rect": "width"}
"""The attribute without which a form is nothing."""

_FORM_SEGMENTS = 4
"""Lines or arcs of a form; the corners of a round rectangle count beside."""

_DEFINITIONS = frozenset(
    {"defs", "symbol", "clipPath", "mask", "pattern", "marker", "filter", "linearGradient", "radialGradient"}
)
"""Elements whose contents paint nothing where they stand."""

_BACKGROUND_ID = "background"
"""The ``id`` of the rectangle that is the canvas in warpvec's own files, and does not count."""


class PaintedCounter:
    """Counts shapes, texts, images and copies outside of definitions, clip paths and masks.

    Attributes:
        count: the elements so far.
        gradient_count: those of them whose own fill refers to a gradient or a pattern.
        stroke_count: those of them with a stroke, their own or that of a group.
        soft_count: those of them whose own attributes refer to a filter.
        form_segment_count: lines and arcs of all circles, ellipses and rectangles among them.
        form_parameter_count: numbers that shape the elements among them that are no paths.
        names: how many of each element there are.
        shapes: how many there are of each kind of `warpvec.svg.found` and each look.
    """

    def __init__(self) -> None:
        self.stroke_count = self.soft_count = 0
        self.count = self.gradient_count = self.form_segment_count = self.form_parameter_count = self._depth = 0
        self.names: Counter[str] = Counter()
        self.shapes: Counter[tuple[str, Look]] = Counter()
        self._looks = [Look()]
        self._view_box = ""

    def start(self, name: str, attributes: dict[str, str]) -> None:
        """Take the start of the SVG element ``name``."""
        self._depth += name in _DEFINITIONS
        look = self._looks[-1].of(attributes)
        self._looks.append(look)
        if name == "svg" and not self._view_box:
            self._view_box = attributes.get("viewBox", "")
        if name in _PAINTED and not self._depth and not self._is_canvas(name, attributes):
            self.count += 1
            self.gradient_count += _has_gradient(attributes)
            self.stroke_count += look.is_stroked
            self.soft_count += "url(" in attributes.get("filter", "")
            self.names[name] += 1
            self.shapes[shape_kind(name, look), look] += 1
            self.form_parameter_count += form_parameters(name, attributes) or 0
            has_corners = name == "rect" and ("rx" in attributes or "ry" in attributes)
            if _FORM_SIZES.get(name) in attributes:
                self.form_segment_count += _FORM_SEGMENTS * (1 + has_corners)

    def _is_canvas(self, name: str, attributes: dict[str, str]) -> bool:
        """Return whether an element is the canvas of a file of warpvec, whose short form has no names."""
        if name != "rect" or self.count:
            return name == "rect" and attributes.get("id") == _BACKGROUND_ID
        is_plain = attributes.keys() == {"width", "height", "fill"}
        covers = is_plain and self._view_box == f"0 0 {attributes['width']} {attributes['height']}"
        return covers or attributes.get("id") == _BACKGROUND_ID

    def end(self, name: str) -> None:
        """Take the end of the SVG element ``name``."""
        self._depth -= name in _DEFINITIONS
        self._looks.pop()


def _has_gradient(attributes: dict[str, str]) -> bool:
    return "url(" in attributes.get("fill", "") or "fill:url(" in "".join(attributes.get("style", "").split())
