"""The areas that parts cover, by shapely (BSD): what shows of each colour, and what is made of that for a machine."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np
import shapely
from shapely.geometry import LineString, Polygon
from shapely.geometry.base import BaseGeometry

from warpvec.arrays import Floats
from warpvec.making.curves import CHORD_ERROR, Piece
from warpvec.making.parts import Circle, Outline, Part, Shape

EMPTY: BaseGeometry = Polygon()

_CAPS: dict[str, Literal["round", "square", "flat"]] = {"round": "round", "square": "square", "butt": "flat"}
"""Cap in SVG -> its name in shapely."""

_JOINS: dict[str, Literal["round", "mitre", "bevel"]] = {"round": "round", "miter": "mitre", "bevel": "bevel"}

_ROUND_STEPS = 32
"""Chords of a quarter of a circle in round caps, joins and offsets: 0.003 mm off at a radius of 10 mm."""

_CIRCLE_POINTS = 12
"""Fewest points of an outline that may be a circle: a square's lie on one too."""

_STRAIGHT = 0.002
"""Distance in millimetres within which points of an outline are left out: offsets make many."""

_NARROW_LENGTH = 2.0
"""Length in widths from which a narrow place counts. The tips of all corners are narrow, but shorter."""

_SPECK = 1e-4
"""Area in square millimetres below which a region is rounding error."""


def region_of(part: Part) -> BaseGeometry:
    """Return the area that a part covers: the inside of its outlines by the non-zero rule, or its stroke."""
    if part.stroke is not None:
        return _stroke_region(part)
    rings = [Polygon(line) for line in map(line_of, part.shapes) if len(line) > 2]
    area, first = EMPTY, None
    # A smaller outline lies in larger ones or beside them: it is a hole if it runs the other way.
    for ring in sorted(rings, key=lambda each: -each.area):
        is_left = ring.exterior.is_ccw
        first = is_left if first is None else first
        whole = shapely.make_valid(ring)
        area = area.union(whole) if is_left == first else area.difference(whole)
    return areas_of(area)


def _stroke_region(part: Part) -> BaseGeometry:
    assert part.stroke is not None
    width, cap, join, limit = part.stroke
    found = []
    for shape in part.shapes:
        line = line_of(shape)
        is_closed = not isinstance(shape, Outline) or shape.is_closed
        line = np.concatenate([line, line[:1]]) if is_closed else line
        if len(line) < 2 or not np.ptp(line, axis=0).any():
            dot = shapely.Point(line[0])
            found.append(
                dot.buffer(width / 2, quad_segs=_ROUND_STEPS, cap_style="square" if cap == "square" else "round")
            )
            continue
        style = {"cap_style": _CAPS[cap], "join_style": _JOINS[join], "mitre_limit": limit}
        found.append(LineString(line).buffer(width / 2, quad_segs=_ROUND_STEPS, **style))
    return areas_of(shapely.union_all(found))


def line_of(shape: Shape) -> Floats:
    """Return points [K, 2] along a shape, whose chords are at most ``CHORD_ERROR`` off; an open line has its end."""
    if isinstance(shape, Outline):
        parts = [piece.chords() for piece in shape.pieces]
        return np.concatenate(parts if shape.is_closed else [*parts, shape.pieces[-1].points[-1:]])
    return shape.chords()


def areas_of(geometry: BaseGeometry) -> BaseGeometry:
    """Return the polygons of ``geometry``, without lines, points and specks of rounding."""
    found = [each for each in shapely.get_parts(geometry, return_index=False) for each in _polygons(each)]
    return shapely.union_all([each for each in found if each.area > _SPECK]) if found else EMPTY


def _polygons(geometry: BaseGeometry) -> Iterator[BaseGeometry]:
    if isinstance(geometry, Polygon):
        yield geometry
    elif hasattr(geometry, "geoms"):
        for each in geometry.geoms:
            yield from _polygons(each)


def grown(region: BaseGeometry, distance: float, *, is_sharp: bool) -> BaseGeometry:
    """Return ``region`` with its outline moved outwards by ``distance``; corners stay sharp, or become round."""
    style: Literal["mitre", "round"] = "mitre" if is_sharp else "round"
    return areas_of(region.buffer(distance, quad_segs=_ROUND_STEPS, join_style=style, mitre_limit=4.0))


def narrow_places(region: BaseGeometry, width: float) -> list[BaseGeometry]:
    """Return the places of ``region`` that a disk of the diameter ``width`` does not reach, but for tips of corners."""
    half = width / 2.0
    reached = region.buffer(-half, quad_segs=_ROUND_STEPS).buffer(half * 1.02, quad_segs=_ROUND_STEPS)
    left = [each for each in _polygons(region.difference(reached)) if each.area > _SPECK]
    return [each for each in left if _length(each) >= _NARROW_LENGTH * width]


def _length(polygon: BaseGeometry) -> float:
    """Return the longer side of the smallest rectangle around a polygon."""
    corners = np.asarray(polygon.minimum_rotated_rectangle.exterior.coords)
    return float(np.hypot(*np.diff(corners, axis=0).T).max())


def outlines_of(region: BaseGeometry) -> tuple[Shape, ...]:
    """Return the outlines of ``region``, of lines but for circles."""
    plain = shapely.orient_polygons(region.simplify(_STRAIGHT))
    rings = [ring for each in _polygons(plain) for ring in (each.exterior, *each.interiors)]
    return tuple(_outline(np.asarray(ring.coords)) for ring in rings)


def _outline(points: Floats) -> Shape:
    center = (points[:-1].min(0) + points[:-1].max(0)) / 2.0
    radii = np.hypot(*(points[:-1] - center).T)
    if len(points) > _CIRCLE_POINTS and np.ptp(radii) <= CHORD_ERROR:
        turn = 1 if shapely.LinearRing(points).is_ccw else -1
        return Circle(float(center[0]), float(center[1]), float(radii.mean()), turn)
    return Outline(tuple(Piece(points[k : k + 2]) for k in range(len(points) - 1)), True)
