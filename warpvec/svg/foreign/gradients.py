"""Read the gradients of an SVG as ramps of colours in pixels of the canvas."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import NamedTuple
from xml.etree.ElementTree import Element

import numpy as np
from numpy.typing import NDArray

from warpvec.geometry.loops import Color
from warpvec.geometry.paints.kind import Geometry
from warpvec.geometry.paints.registry import ELLIPTIC, LINEAR, RADIAL
from warpvec.svg.document import local_name
from warpvec.svg.foreign.color_ramps import ColorRamp
from warpvec.svg.foreign.shapes import compose, read_matrix
from warpvec.svg.units import parse_length

_TEMPLATES = 10
"""Longest chain of gradients that take stops and attributes from each other; ends a chain that is a loop."""

_SIMILAR = 1e-3
"""Relative difference of the two axes up to which an ellipse counts as a circle."""

Matrix = NDArray[np.float64]


class GradientStop(NamedTuple):
    """A stop of a gradient: offset in [0, 1], sRGB-encoded colour and opacity."""

    offset: float
    color: Color
    opacity: float


@dataclass(frozen=True)
class Space:
    """Where the gradients of a shape lie.

    Attributes:
        matrix: from user space to pixels [2, 3].
        box: left, top, right and bottom of the shape in user space, without its stroke.
        viewport: width and height that percentages refer to.
        size: width and height of the canvas in pixels.
    """

    matrix: Matrix
    box: tuple[float, float, float, float]
    viewport: tuple[float, float]
    size: tuple[float, float]


def attribute(gradient: Element, name: str, by_id: Mapping[str, Element]) -> str | None:
    """Return an attribute of a gradient, or else of the first gradient with it that it refers to."""
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


def lies_nowhere(gradient: Element, by_id: Mapping[str, Element], space: Space) -> bool:
    """Return whether a gradient depends on a box without width or height, so that SVG draws nothing."""
    left, top, right, bottom = space.box
    in_box = attribute(gradient, "gradientUnits", by_id) != "userSpaceOnUse"
    return in_box and not (right > left and bottom > top)


@np.errstate(all="ignore")
def read_gradient(
    gradient: Element, stops: list[GradientStop], by_id: Mapping[str, Element], space: Space, omitted: Counter[str]
) -> ColorRamp:
    """Return the colours of a gradient in pixels. Its ends may be anywhere, and not finite.

    Args:
        gradient: the element, with at least one stop.
        stops: its own stops, or the stops of the gradient it refers to.
        by_id: the elements that it may refer to.
        space: where it lies.
        omitted: counts what the result does not show.
    """

    def given(name: str) -> str | None:
        return attribute(gradient, name, by_id)

    matrix, (across, down) = space.matrix, space.viewport
    if given("gradientUnits") != "userSpaceOnUse":
        left, top, right, bottom = space.box
        matrix = compose(matrix, np.array([[right - left, 0.0, left], [0.0, bottom - top, top]]))
        across = down = 1.0
    try:
        matrix = compose(matrix, read_matrix(given("gradientTransform") or ""))
    except ValueError:
        omitted["broken transform"] += 1
    spread = given("spreadMethod") or "pad"
    offsets = np.maximum.accumulate([stop.offset for stop in stops])
    colors = np.array([stop.color for stop in stops])
    if len({stop.opacity for stop in stops}) > 1:
        colors = np.column_stack([colors, [stop.opacity for stop in stops]])

    def length(name: str, default: str, whole: float) -> float:
        return parse_length(given(name) or default, whole)

    kind, geometry = GRADIENT_ELEMENTS[local_name(gradient.tag)](length, (across, down), matrix, omitted)
    return ColorRamp(kind, geometry, offsets, colors, spread)


Length = Callable[[str, str, float], float]
"""Reads the attribute of a name, or a default, as a length; percentages are of the third argument."""


def _linear_geometry(
    length: Length, viewport: tuple[float, float], matrix: Matrix, omitted: Counter[str]
) -> tuple[int, Geometry]:
    """Return the kind and the ends of a linear gradient in pixels.

    The lines of equal colour stay straight under the matrix but may lean. The ends in pixels lie across them.
    """
    del omitted
    across, down = viewport
    sides = (("x1", "0%", across), ("y1", "0%", down), ("x2", "100%", across), ("y2", "0%", down))
    ends = np.array([length(*side) for side in sides]).reshape(2, 2)
    along = ends[1] - ends[0]
    first, last = (matrix[:, :2] @ point + matrix[:, 2] for point in ends)
    determinant = float(np.linalg.det(matrix[:, :2]))
    if determinant == 0.0 or not along.any():
        return LINEAR, (float(first[0]), float(first[1]), float(first[0]), float(first[1]))
    leaning = matrix[:, :2] @ np.array([-along[1], along[0]])
    normal = np.array([-leaning[1], leaning[0]])
    step = last - first
    end = first + normal * (step @ normal) / (normal @ normal)
    return LINEAR, (float(first[0]), float(first[1]), float(end[0]), float(end[1]))


def _radial_geometry(
    length: Length, viewport: tuple[float, float], matrix: Matrix, omitted: Counter[str]
) -> tuple[int, Geometry]:
    """Return the kind and the geometry of a radial gradient in pixels, which may be an ellipse there."""
    across, down = viewport
    diagonal = math.hypot(across, down) / math.sqrt(2)
    cx, cy, r = length("cx", "50%", across), length("cy", "50%", down), length("r", "50%", diagonal)
    focus = (length("fx", repr(cx), across), length("fy", repr(cy), down), length("fr", "0", diagonal))
    omitted["gradient with a focus"] += max(abs(focus[0] - cx), abs(focus[1] - cy), abs(focus[2])) > _SIMILAR * r
    center = matrix[:, :2] @ np.array([cx, cy]) + matrix[:, 2]
    x, y = center.tolist()
    if not np.isfinite(matrix).all():
        return RADIAL, (x, y, 0.0, 0.0)
    turn, axes, _ = np.linalg.svd(matrix[:, :2])
    if axes[0] - axes[1] <= _SIMILAR * axes[0]:
        return RADIAL, (x, y, r * math.sqrt(float(axes[0] * axes[1])), 0.0)
    axis = r * axes[0] * turn[:, 0]
    return ELLIPTIC, (x, y, float(axis[0]), float(axis[1]), r * float(axes[1]))


GRADIENT_ELEMENTS = {"linearGradient": _linear_geometry, "radialGradient": _radial_geometry}
"""Element of a gradient that is read -> the function that reads its kind and geometry."""
