"""Reduce each fill of an SVG to one colour and opacity."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np

from warpvec.geometry.loops import Color
from warpvec.svg.document import local_name
from warpvec.svg.foreign.shapes import load_parser
from warpvec.svg.foreign.style import INHERITED, Properties, StyleSheet
from warpvec.svg.units import NUMBER

_TEMPLATES = 10
"""Longest chain of gradients that take their stops from each other; ends a chain that is a loop."""

_URL = re.compile(r"url\(\s*[\"']?#([^\"')\s]*)[\"']?\s*\)\s*(.*)", re.DOTALL)

# CSS separates values by commas or by spaces, with a slash before the alpha; svgelements knows commas only.
_FUNCTION = re.compile(r"(rgba?|hsla?)\(\s*([^()]*?)\s*\)")
_GAP = re.compile(r"[\s,/]+")
_UNKNOWN = [0.0, 0.0, 0.0, 1.0]
"""The result of svgelements for text that is not a colour. Only text that matches ``_BLACK`` may have it."""
_BLACK = re.compile(rf"black|#(?:0{{3}}){{1,2}}f{{0,2}}|(?:rgb|hsl)a?\((?:{NUMBER}(?:%|deg)?,){{2,3}}{NUMBER}%?\)")
_NO_FILL = frozenset({"none", "transparent", ""})


@dataclass(frozen=True)
class Fill:
    """A flat fill: sRGB-encoded colour and opacity, in [0, 1]."""

    color: Color
    opacity: float


class Fills:
    """Reader of the fills of a document, with its style sheet and its elements by their ``id``."""

    def __init__(self, sheet: StyleSheet, by_id: Mapping[str, Element]) -> None:
        self._sheet = sheet
        self._by_id = by_id
        # Thousands of paths may share a gradient of thousands of stops.
        self._own_stops: dict[Element, list[Element]] = {}
        self._means: dict[Element, Fill | None] = {}

    def read(self, properties: Properties, omitted: Counter[str]) -> Fill | None:
        """Return the fill that ``properties`` state, None without one; count in ``omitted`` what it does not show."""
        url = _URL.fullmatch(properties["fill"])
        if url is None:
            fill = self._flat(properties["fill"], properties)
            omitted["fill of unknown colour"] += fill is None and properties["fill"] not in _NO_FILL
            return _scaled(fill, properties["fill-opacity"])
        server = self._by_id.get(url[1])
        name = "" if server is None else local_name(server.tag)
        if server is not None and name.endswith("Gradient"):
            omitted["gradient fill"] += 1
            return _scaled(self._mean(server), properties["fill-opacity"])
        omitted["pattern fill" if name == "pattern" else "reference to nothing"] += 1
        return _scaled(self._flat(url[2] or "none", properties), properties["fill-opacity"])

    def _flat(self, text: str, properties: Properties) -> Fill | None:
        if text in _NO_FILL:
            return None
        return read_color(properties["color"] if text.lower() == "currentcolor" else text)

    def _mean(self, gradient: Element) -> Fill | None:
        """Return the mean over the length of the gradient vector; without stops, that of the gradient referred to."""
        for _ in range(_TEMPLATES):
            if gradient not in self._own_stops:
                self._own_stops[gradient] = [child for child in gradient if local_name(child.tag) == "stop"]
            if self._own_stops[gradient]:
                if gradient not in self._means:
                    self._means[gradient] = self._mean_of_stops(self._own_stops[gradient])
                return self._means[gradient]
            href = next((v for key, v in gradient.attrib.items() if key.rpartition("}")[2] == "href"), "")
            template = self._by_id.get(href.strip()[1:])
            if template is None:
                break
            gradient = template
        return None

    def _mean_of_stops(self, elements: Sequence[Element]) -> Fill | None:
        """Return the mean of one stop or more, taken of premultiplied colours."""
        stops = [self._stop(element) for element in elements]
        offsets = np.maximum.accumulate([offset for offset, _ in stops])
        values = np.array([[*(c * fill.opacity for c in fill.color), fill.opacity] for _, fill in stops])
        spans = np.diff(offsets, prepend=0.0, append=1.0)
        middles = (np.concatenate([values[:1], values]) + np.concatenate([values, values[-1:]])) / 2
        *color, opacity = (spans[:, None] * middles).sum(0).tolist()
        return Fill((color[0] / opacity, color[1] / opacity, color[2] / opacity), opacity) if opacity else None

    def _stop(self, stop: Element) -> tuple[float, Fill]:
        properties = self._sheet.properties(stop, dict(INHERITED))
        fill = _scaled(self._flat(properties["stop-color"], properties), properties["stop-opacity"])
        return fraction(stop.get("offset", "0"), 0.0), fill or Fill((0.0, 0.0, 0.0), 0.0)


def fraction(text: str, default: float = 1.0) -> float:
    """Return a number or percentage, clamped to [0, 1]; ``default`` if ``text`` is neither."""
    match = re.fullmatch(rf"\s*({NUMBER})\s*(%?)\s*", text)
    if match is None:
        return default
    return min(max(float(match[1]) / (100 if match[2] else 1), 0.0), 1.0)


def read_color(text: str) -> Fill | None:
    """Return the colour that ``text`` stands for, None if it is not a colour."""
    function = _FUNCTION.fullmatch(text.lower())
    if function is not None:
        text = f"{function[1]}({','.join(re.split(_GAP, function[2]))})"
    try:
        color = load_parser().Color(text)
        values = [float(v) for v in (color.red, color.green, color.blue, color.opacity)]
    except Exception:
        return None
    if values == _UNKNOWN and not _BLACK.fullmatch(text.lower()):
        return None
    red, green, blue, opacity = (min(max(value, 0.0), 255.0) if math.isfinite(value) else 0.0 for value in values)
    return Fill((red / 255, green / 255, blue / 255), min(opacity, 1.0))


def _scaled(fill: Fill | None, opacity: str) -> Fill | None:
    return None if fill is None else Fill(fill.color, fill.opacity * fraction(opacity))
