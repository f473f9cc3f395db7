"""Count the shapes, segments and colours of an SVG as a designer sees them, for originals and tracings alike.

Shapes are painted elements after each ``use`` is followed. Their segments are those of their outlines in absolute
coordinates: a rectangle has four, a circle or an ellipse four, a line that is only stroked one. A line that closes a
fill counts if it has a length.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray
from PIL import ImageColor

from warpvec.svg.document import local_name
from warpvec.svg.foreign.shapes import SHAPES, closed_loops, read_subpaths, shape_data
from warpvec.svg.foreign.style import INHERITED, Properties, StyleSheet
from warpvec.svg.units import stated_size

_GROUPS = frozenset({"g", "a", "svg", "switch", "symbol"})
_LENGTH_MIN = 1e-6
"""Least length of a segment, as a share of the largest coordinate."""

_UNPAINTED = frozenset({"none", "transparent", ""})


class Counts(NamedTuple):
    """Counts of one SVG. Colours are those of flat paints; ``stops`` are the colours of all gradients used."""

    shapes: int
    segments: int
    colors: int
    stops: int

    @property
    def has_gradients(self) -> bool:
        """Whether the drawing has gradients."""
        return self.stops > 0


def count(svg: str) -> Counts:
    """Count what ``svg`` draws."""
    root = ElementTree.fromstring(svg)
    counter = _Counter(root)
    counter.visit(root, dict(INHERITED))
    return Counts(counter.shapes, counter.segments, len(counter.colors), len(counter.stops))


class _Counter:
    """A walk over the tree as a renderer does it."""

    def __init__(self, root: Element) -> None:
        self.shapes = self.segments = 0
        self.colors: set[tuple[int, ...]] = set()
        self.stops: set[tuple[int, ...]] = set()
        self._sheet = StyleSheet(root)
        self._by_id = {name: element for element in root.iter() if (name := element.get("id"))}
        self._size = stated_size(root.attrib)

    def visit(self, element: Element, inherited: Properties) -> None:
        name = local_name(element.tag)
        properties = self._sheet.properties(element, inherited)
        if properties["display"] == "none" or float(properties["opacity"].rstrip("%") or 1) == 0:
            return
        if name == "use":
            self._visit_target(element, properties)
        elif name in _GROUPS:
            for child in element:
                self.visit(child, properties)
        elif name in SHAPES:
            self._add(name, element, properties)

    def _visit_target(self, use: Element, properties: Properties) -> None:
        href = next((value for key, value in use.attrib.items() if key.rpartition("}")[2] == "href"), "")
        target = self._by_id.get(href.strip()[1:])
        if target is not None:
            self.visit(target, properties)

    def _add(self, name: str, element: Element, properties: Properties) -> None:
        subpaths, _ = read_subpaths(shape_data(name, element.attrib, *self._size))
        loops = closed_loops(subpaths) if properties["fill"] not in _UNPAINTED else []
        is_stroked = properties["stroke"] not in _UNPAINTED
        parts = loops or (subpaths if is_stroked else [])
        if not parts:
            return
        self.shapes += 1
        self.segments += sum(_segment_count(part.points) for part in parts)
        for role, is_painted in (("fill", bool(loops)), ("stroke", is_stroked)):
            if is_painted:
                self._add_paint(properties[role])

    def _add_paint(self, paint: str) -> None:
        if not paint.startswith("url("):
            self.colors.add(_color(paint))
            return
        server = self._by_id.get(paint[4:].partition(")")[0].strip("\"'# "))
        for stop in self._stops(server):
            self.stops.add(_color(self._sheet.properties(stop, dict(INHERITED))["stop-color"]))

    def _stops(self, server: Element | None) -> Iterator[Element]:
        """Yield the stops of a gradient, or of the one that it refers to."""
        while server is not None:
            stops = [child for child in server if local_name(child.tag) == "stop"]
            if stops:
                yield from stops
                return
            href = next((value for key, value in server.attrib.items() if key.rpartition("}")[2] == "href"), "")
            server = self._by_id.get(href[1:])


def _segment_count(points: NDArray[np.float64]) -> int:
    """Return how many of the cubics with ``points`` [3 k (+ 1), 2] have a length.

    The line that closes a path of relative numbers may have one by rounding.
    """
    curves = np.concatenate([points, points[:1]])[: len(points) // 3 * 3 + 1]
    starts = curves[:-1].reshape(-1, 3, 2)
    reach = np.abs(np.concatenate([starts[:, 1:], curves[3::3, None]], 1) - starts[:, :1]).max((1, 2))
    return int((reach > _LENGTH_MIN * np.abs(points).max()).sum())


def _color(text: str) -> tuple[int, ...]:
    """Return red, green and blue of a CSS colour."""
    return ImageColor.getrgb(text)[:3]
