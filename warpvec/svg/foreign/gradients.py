"""Read the gradients of an SVG as paints of a scene: two stops, in pixels of the canvas."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from typing import TYPE_CHECKING
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from warpvec.geometry.gradients import LINEAR, RADIAL
from warpvec.geometry.loops import Color, LinearOrRadial
from warpvec.svg.document import local_name
from warpvec.svg.foreign.shapes import compose, read_matrix
from warpvec.svg.units import parse_length

if TYPE_CHECKING:
    from warpvec.svg.foreign.fill import Fill

_TEMPLATES = 10
"""Longest chain of gradients that take stops and attributes from each other; ends a chain that is a loop."""

_FIT_POINTS = 65
"""Number of places along a gradient with other stops at which two stops are fitted to it."""

_SIMILAR = 1e-3
"""Relative difference of the two axes up to which an ellipse counts as a circle."""

Stop = tuple[float, "Fill"]
Matrix = NDArray[np.float64]


def attribute(gradient: Element, name: str, by_id: Mapping[str, Element]) -> str | None:
    """Return an attribute of a gradient, or of the first one it refers to that has it."""
    return next((value for each in chain(gradient, by_id) if (value := each.get(name)) is not None), None)


def chain(gradient: Element, by_id: Mapping[str, Element]) -> list[Element]:
    """Return a gradient and those it refers to."""
    found = [gradient]
    for _ in range(_TEMPLATES):
        href = next((v for key, v in found[-1].attrib.items() if key.rpartition("}")[2] == "href"), "")
        template = by_id.get(href.strip()[1:])
        if template is None:
            break
        found.append(template)
    return found


def read_gradient(
    gradient: Element,
    stops: list[Stop],
    by_id: Mapping[str, Element],
    matrix: Matrix,
    box: tuple[float, float, float, float],
    viewport: tuple[float, float],
    omitted: Counter[str],
) -> tuple[Color, LinearOrRadial]:
    """Return the first colour of a gradient, and the rest of it, in pixels.

    Args:
        gradient: the element, with at least one stop.
        stops: its offsets and fills.
        by_id: the elements that it may refer to.
        matrix: from user space to pixels [2, 3].
        box: left, top, right and bottom of the shape in user space.
        viewport: width and height that percentages refer to.
        omitted: counts what the result does not show.
    """

    def given(name: str) -> str | None:
        return attribute(gradient, name, by_id)

    in_box = given("gradientUnits") != "userSpaceOnUse"
    if in_box:
        width, height = box[2] - box[0], box[3] - box[1]
        matrix, viewport = compose(matrix, np.array([[width, 0.0, box[0]], [0.0, height, box[1]]])), (1.0, 1.0)
    try:
        matrix = compose(matrix, read_matrix(given("gradientTransform") or ""))
    except ValueError:
        omitted["broken transform"] += 1
    omitted["repeating gradient"] += (given("spreadMethod") or "pad") != "pad"
    omitted["translucent gradient stop"] += len({round(fill.opacity, 3) for _, fill in stops}) > 1

    def length(name: str, default: str, whole: float) -> float:
        return parse_length(given(name) or default, whole)

    across, down = viewport
    if local_name(gradient.tag) == "linearGradient":
        sides = (("x1", "0%", across), ("y1", "0%", down), ("x2", "100%", across), ("y2", "0%", down))
        ends = [length(*side) for side in sides]
        first, last, low, high = _two_stops(stops, omitted)
        return first, LinearOrRadial(LINEAR, _linear(np.array(ends).reshape(2, 2), matrix, low, high), last)
    diagonal = math.hypot(across, down) / math.sqrt(2)
    cx, cy, r = length("cx", "50%", across), length("cy", "50%", down), length("r", "50%", diagonal)
    focus = (length("fx", repr(cx), across), length("fy", repr(cy), down), length("fr", "0", diagonal))
    omitted["gradient with a focus"] += max(abs(focus[0] - cx), abs(focus[1] - cy), abs(focus[2])) > _SIMILAR * r
    first, last, low, high = _two_stops([(0.0, stops[0][1]), *stops] if stops[0][0] > 0.0 else stops, omitted)
    del low
    return first, LinearOrRadial(RADIAL, _radial(cx, cy, r * high, matrix, omitted), last)


def _linear(ends: Matrix, matrix: Matrix, low: float, high: float) -> tuple[float, float, float, float]:
    """Return the ends in pixels of a linear gradient with stops at ``low`` and ``high`` between ``ends`` [2, 2].

    The lines of equal colour stay straight under the matrix but may lean. The ends in pixels lie across them.
    """
    start, along = ends[0], ends[1] - ends[0]
    stops = (start + low * along, start + high * along)
    first, last = (matrix[:, :2] @ point + matrix[:, 2] for point in stops)
    determinant = float(np.linalg.det(matrix[:, :2]))
    if determinant == 0.0 or not along.any():
        return float(first[0]), float(first[1]), float(first[0]), float(first[1])
    across = matrix[:, :2] @ np.array([-along[1], along[0]])
    normal = np.array([-across[1], across[0]])
    step = last - first
    end = first + normal * (step @ normal) / (normal @ normal)
    return float(first[0]), float(first[1]), float(end[0]), float(end[1])


def _radial(cx: float, cy: float, r: float, matrix: Matrix, omitted: Counter[str]) -> tuple[float, float, float, float]:
    center = matrix[:, :2] @ np.array([cx, cy]) + matrix[:, 2]
    with np.errstate(all="ignore"):
        axes = np.linalg.svd(matrix[:, :2], compute_uv=False) if np.isfinite(matrix).all() else np.zeros(2)
    omitted["elliptic gradient"] += bool(axes[0] - axes[1] > _SIMILAR * axes[0])
    return float(center[0]), float(center[1]), r * math.sqrt(float(axes[0] * axes[1])), 0.0


def _two_stops(stops: list[Stop], omitted: Counter[str]) -> tuple[Color, Color, float, float]:
    """Return two colours and their offsets that show ``stops``, exactly if there are two."""
    offsets = np.maximum.accumulate([offset for offset, _ in stops])
    colors = np.array([fill.color for _, fill in stops])
    kept = _needed(offsets, colors)
    offsets, colors = offsets[kept], colors[kept]
    if len(offsets) == 1:
        return _color(colors[0]), _color(colors[0]), 0.0, 1.0
    if len(offsets) == 2 and offsets[1] > offsets[0]:
        return _color(colors[0]), _color(colors[1]), float(offsets[0]), float(offsets[1])
    omitted["gradient of several stops"] += 1
    t = np.linspace(0.0, 1.0, _FIT_POINTS)
    shown = np.stack([np.interp(t, offsets, channel) for channel in colors.T], 1)
    fitted, *_ = np.linalg.lstsq(np.stack([1.0 - t, t], 1), shown, rcond=None)
    first, last = np.clip(fitted, 0.0, 1.0)
    return _color(first), _color(last), 0.0, 1.0


def _needed(offsets: NDArray[np.float64], colors: NDArray[np.float64]) -> list[int]:
    """Return the stops without those that the ones beside them imply."""
    kept = list(range(len(offsets)))
    for middle in range(len(offsets) - 2, 0, -1):
        at = kept.index(middle)
        before, after = kept[at - 1], kept[at + 1]
        span = offsets[after] - offsets[before]
        share = (offsets[middle] - offsets[before]) / span if span > 0.0 else 0.0
        implied = (1.0 - share) * colors[before] + share * colors[after]
        if span > 0.0 and np.abs(implied - colors[middle]).max() < 0.5 / 255.0:
            kept.remove(middle)
    while len(kept) > 1 and (colors[kept[0]] == colors[kept[1]]).all():
        kept.pop(0)
    while len(kept) > 1 and (colors[kept[-1]] == colors[kept[-2]]).all():
        kept.pop()
    return kept


def _color(values: NDArray[np.float64]) -> Color:
    red, green, blue = values.tolist()
    return red, green, blue
