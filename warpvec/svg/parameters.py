"""Count the parameters of an element of SVG, the numbers that shape it: for files and for the icon gate alike."""

from __future__ import annotations

import re
from collections.abc import Mapping

from warpvec.svg.segments import count_path
from warpvec.svg.units import NUMBER

_NUMBER = re.compile(NUMBER)

_FORM_PARAMETERS = {"circle": 3, "ellipse": 4, "rect": 6, "line": 4, "use": 6}
"""Numbers that shape an element beside paths; those of a rectangle count with its corners."""

_POINT_LISTS = frozenset({"polyline", "polygon"})


def shape_parameters(name: str, attributes: Mapping[str, str]) -> int | None:
    """Return the parameters of a shape: the element ``name`` with its ``attributes``; None for one that is no shape.

    A line of a path has 2, a quadratic 4, a cubic 6, an arc 7, a circle 3, an ellipse 4, a rectangle 6, a line of its
    own 4, polylines and polygons 2 a point; moves and closes are free.
    """
    return count_path(attributes.get("d", "")).parameters if name == "path" else form_parameters(name, attributes)


def form_parameters(name: str, attributes: Mapping[str, str]) -> int | None:
    """Return the parameters of a shape that is no path, as `shape_parameters` does; None for anything else."""
    if name in _POINT_LISTS:
        return sum(1 for _ in _NUMBER.finditer(attributes.get("points", "")))
    return _FORM_PARAMETERS.get(name)
