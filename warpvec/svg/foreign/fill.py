"""Fills of an SVG as one colour each."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from xml.etree.ElementTree import Element

import numpy as np

from warpvec.geometry.loops import Color
from warpvec.svg.foreign.shapes import load_parser
from warpvec.svg.foreign.style import INHERITED, Properties, StyleSheet, local_name
from warpvec.svg.units import NUMBER

_TEMPLATES = 10
"""Gradients that refer to each other for their stops, at most; a loop of them ends so."""

_URL = re.compile(r"url\(\s*[\"']?#([^\"')\s]*)[\"']?\s*\)\s*(.*)", re.DOTALL)


# CSS lets spaces separate as well as commas, and a slash before the alpha; svgelements knows commas.
_FUNCTION = re.compile(r"(rgba?|hsla?)\(\s*([^()]*?)\s*\)")
_GAP = re.compile(r"[\s,/]+")
_UNKNOWN = [0.0, 0.0, 0.0, 1.0]
"""What svgelements makes of text that is no colour; what may say it is ``_BLACK``."""
_BLACK = re.compile(rf"black|#(?:0{{3}}){{1,2}}f{{0,2}}|(?:rgb|hsl)a?\((?:{NUMBER}(?:%|deg)?,){{2,3}}{NUMBER}%?\)")
_NO_PAINT = frozenset({"none", "transparent", ""})


@dataclass(frozen=True)
class Paint:
    """A flat fill: sRGB-encoded colour and opacity, in [0, 1]."""

    color: Color
    opacity: float


class Paints:
    """Fills of a document with the gradients ``by_id``."""

    def __init__(self, sheet: StyleSheet, by_id: Mapping[str, Element]) -> None:
        self._sheet = sheet
        self._by_id = by_id

    def fill(self, properties: Properties, omitted: Counter[str]) -> Paint | None:
        """The fill that ``properties`` state, None for none; what it is not is counted in ``omitted``."""
        url = _URL.fullmatch(properties["fill"])
        if url is None:
            paint = self._flat(properties["fill"], properties)
            omitted["fill of unknown colour"] += paint is None and properties["fill"] not in _NO_PAINT
            return _scaled(paint, properties["fill-opacity"])
        server = self._by_id.get(url[1])
        name = "" if server is None else local_name(server)
        if server is not None and name.endswith("Gradient"):
            omitted["gradient fill"] += 1
            return _scaled(self._mean(server), properties["fill-opacity"])
        omitted["pattern fill" if name == "pattern" else "reference to nothing"] += 1
        return _scaled(self._flat(url[2] or "none", properties), properties["fill-opacity"])

    def _flat(self, text: str, properties: Properties) -> Paint | None:
        if text in _NO_PAINT:
            return None
        return read_color(properties["color"] if text.lower() == "currentcolor" else text)

    def _mean(self, gradient: Element) -> Paint | None:
        """Over the length of the gradient vector, premultiplied."""
        stops = self._stops(gradient)
        if not stops:
            return None
        offsets = np.maximum.accumulate([offset for offset, _ in stops])
        values = np.array([[*(c * paint.opacity for c in paint.color), paint.opacity] for _, paint in stops])
        spans = np.diff(offsets, prepend=0.0, append=1.0)
        middles = (np.concatenate([values[:1], values]) + np.concatenate([values, values[-1:]])) / 2
        *color, opacity = (spans[:, None] * middles).sum(0).tolist()
        return Paint((color[0] / opacity, color[1] / opacity, color[2] / opacity), opacity) if opacity else None

    def _stops(self, gradient: Element) -> list[tuple[float, Paint]]:
        """Offset and paint of each stop, those of the gradient that it refers to if it has none."""
        for _ in range(_TEMPLATES):
            stops = [child for child in gradient if local_name(child) == "stop"]
            if stops:
                return [self._stop(stop) for stop in stops]
            href = next((v for key, v in gradient.attrib.items() if key.rpartition("}")[2] == "href"), "")
            template = self._by_id.get(href.strip()[1:])
            if template is None:
                break
            gradient = template
        return []

    def _stop(self, stop: Element) -> tuple[float, Paint]:
        properties = self._sheet.properties(stop, dict(INHERITED))
        paint = _scaled(self._flat(properties["stop-color"], properties), properties["stop-opacity"])
        return fraction(stop.get("offset", "0"), 0.0), paint or Paint((0.0, 0.0, 0.0), 0.0)


def fraction(text: str, default: float = 1.0) -> float:
    """A number or percentage, clamped to [0, 1]; ``default`` where it is neither."""
    match = re.fullmatch(rf"\s*({NUMBER})\s*(%?)\s*", text)
    if match is None:
        return default
    return min(max(float(match[1]) / (100 if match[2] else 1), 0.0), 1.0)


def read_color(text: str) -> Paint | None:
    """The colour that ``text`` stands for, None where it stands for none."""
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
    return Paint((red / 255, green / 255, blue / 255), min(opacity, 1.0))


def _scaled(paint: Paint | None, opacity: str) -> Paint | None:
    return None if paint is None else Paint(paint.color, paint.opacity * fraction(opacity))
