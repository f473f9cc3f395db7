"""Read the paints of fills and strokes of an SVG: one colour and opacity, or a gradient."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace
from xml.etree.ElementTree import Element

import numpy as np

from warpvec.errors import InputError
from warpvec.geometry.loops import Color
from warpvec.svg.document import local_name
from warpvec.svg.foreign.bands import RAMP_EFFORT, Painted, painted
from warpvec.svg.foreign.budget import WorkBudget
from warpvec.svg.foreign.gradients import GRADIENT_ELEMENTS, GradientStop, Space, chain, lies_nowhere, read_gradient
from warpvec.svg.foreign.shapes import Loop, load_parser
from warpvec.svg.foreign.skia import Combiner
from warpvec.svg.foreign.style import INHERITED, Properties, StyleSheet
from warpvec.svg.units import NUMBER

_URL = re.compile(r"url\(\s*[\"']?#([^\"')\s]*)[\"']?\s*\)\s*(.*)", re.DOTALL)

MAX_STOPS = 256
"""Most stops of a gradient; editors make some tens. Each path reads all stops of its gradient."""

# CSS separates values by commas or by spaces, with a slash before the alpha; svgelements knows commas only.
_FUNCTION = re.compile(r"(rgba?|hsla?)\(\s*([^()]*?)\s*\)")
_GAP = re.compile(r"[\s,/]+")
_UNKNOWN = [0.0, 0.0, 0.0, 1.0]
"""The result of svgelements for text that is not a colour. Only text that matches ``_BLACK`` may have it."""
_BLACK = re.compile(rf"black|#(?:0{{3}}){{1,2}}f{{0,2}}|(?:rgb|hsl)a?\((?:{NUMBER}(?:%|deg)?,){{2,3}}{NUMBER}%?\)")
_NO_FILL = frozenset({"none", "transparent", ""})


@dataclass(frozen=True)
class Fill:
    """A fill.

    Attributes:
        color: sRGB-encoded, in [0, 1]; of a gradient its mean.
        opacity: in [0, 1]; of a gradient its mean.
        scale: opacity without that of the stops of a gradient.
        gradient: the element of a gradient that shows more than one colour.
        stops: its stops.
    """

    color: Color
    opacity: float
    gradient: Element | None = None
    stops: tuple[GradientStop, ...] = ()
    scale: float = 1.0


class Fills:
    """Reader of the fills of a document, with its style sheet and its elements by their ``id``."""

    def __init__(self, sheet: StyleSheet, by_id: Mapping[str, Element]) -> None:
        self._sheet = sheet
        self._by_id = by_id
        # Thousands of paths may share a gradient.
        self._stops_of: dict[Element, list[GradientStop]] = {}
        self._gradients: dict[Element, Fill | None] = {}
        self._budget = WorkBudget(RAMP_EFFORT)

    def read(self, properties: Properties, omitted: Counter[str], role: str = "fill") -> Fill | None:
        """Return the paint that ``properties`` state for ``role``, "fill" or "stroke"; None without one.

        ``omitted`` counts what it does not show.
        """
        text, opacity = properties[role], properties[f"{role}-opacity"]
        url = _URL.fullmatch(text)
        if url is None:
            fill = self._flat(text, properties)
            omitted[f"{role} of unknown colour"] += fill is None and text not in _NO_FILL
            return _scaled(fill, opacity)
        server = self._by_id.get(url[1])
        name = "" if server is None else local_name(server.tag)
        if server is not None and name in GRADIENT_ELEMENTS:
            return _scaled(self._gradient(server), opacity)
        omitted[f"pattern {role}" if name == "pattern" else "reference to nothing"] += 1
        return _scaled(self._flat(url[2] or "none", properties), opacity)

    def _flat(self, text: str, properties: Properties) -> Fill | None:
        if text in _NO_FILL:
            return None
        return read_color(properties["color"] if text.lower() == "currentcolor" else text)

    def placed(
        self, fill: Fill, loops: list[Loop], is_opaque: bool, space: Space, combiner: Combiner, omitted: Counter[str]
    ) -> list[Painted]:
        """Return the parts of a shape, with paint and opacity of each: one part unless a gradient needs several.

        Args:
            fill: the paint of the shape.
            loops: its loops in pixels.
            is_opaque: whether parts may overlap.
            space: where gradients lie.
            combiner: cuts discs.
            omitted: counts what the result does not show.
        """
        if fill.gradient is None:
            return [Painted(loops, fill.color, None, fill.opacity)]
        if lies_nowhere(fill.gradient, self._by_id, space):
            omitted["gradient on a box without area"] += 1
            return []
        ramp = read_gradient(fill.gradient, list(fill.stops), self._by_id, space, omitted)
        parts = painted(loops, ramp, is_opaque, space.size, combiner, self._budget, omitted)
        if parts is None:
            omitted["gradient beyond the limit of stops"] += 1
            return [Painted(loops, fill.color, None, fill.opacity)]
        opacity = fill.scale * (1.0 if ramp.colors.shape[1] > 3 else fill.stops[0].opacity)
        return [part._replace(opacity=part.opacity * opacity) for part in parts]

    def _gradient(self, gradient: Element) -> Fill | None:
        """Return a gradient, which is kept because thousands of shapes may have it."""
        if gradient not in self._gradients:
            self._gradients[gradient] = _mean(gradient, self._stops(gradient))
        return self._gradients[gradient]

    def _stops(self, gradient: Element) -> list[GradientStop]:
        """Return the stops of a gradient, or of the gradient it refers to if it has none."""
        for element in chain(gradient, self._by_id):
            stops = [child for child in element if local_name(child.tag) == "stop"]
            if len(stops) > MAX_STOPS:
                rule = f"must have at most {MAX_STOPS} stops a gradient"
                raise InputError("SVG", rule, str(len(stops)), "simplify it")
            if stops:
                if element not in self._stops_of:
                    self._stops_of[element] = [self._stop(stop) for stop in stops]
                return self._stops_of[element]
        return []

    def _stop(self, stop: Element) -> GradientStop:
        properties = self._sheet.properties(stop, dict(INHERITED))
        fill = _scaled(self._flat(properties["stop-color"], properties), properties["stop-opacity"])
        fill = fill or Fill((0.0, 0.0, 0.0), 0.0)
        return GradientStop(fraction(stop.get("offset", "0"), 0.0), fill.color, fill.opacity)


def _mean(gradient: Element, stops: list[GradientStop]) -> Fill | None:
    """Return a gradient with the mean over the length of its vector, taken of premultiplied colours."""
    if not stops:
        return None
    shown = gradient if len({stop[1:] for stop in stops}) > 1 else None
    offsets = np.maximum.accumulate([stop.offset for stop in stops])
    values = np.array([[*(c * stop.opacity for c in stop.color), stop.opacity] for stop in stops])
    spans = np.diff(offsets, prepend=0.0, append=1.0)
    middles = (np.concatenate([values[:1], values]) + np.concatenate([values, values[-1:]])) / 2
    *color, opacity = (spans[:, None] * middles).sum(0).tolist()
    if not opacity:
        return None
    mean = (color[0] / opacity, color[1] / opacity, color[2] / opacity)
    return Fill(mean, opacity, shown, tuple(stops))


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
    if fill is None:
        return None
    share = fraction(opacity)
    return replace(fill, opacity=fill.opacity * share, scale=fill.scale * share)
