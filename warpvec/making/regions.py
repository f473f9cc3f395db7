"""The areas that parts cover, by shapely (BSD): what shows of each colour, and what is made of that for a machine."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Literal

import numpy as np
import shapely
from shapely.geometry import Polygon
from shapely.geometry.base import BaseGeometry

from warpvec.arrays import Floats
from warpvec.making.arcs import FINE_ERROR, closed_shape
from warpvec.making.parts import Circle, Outline, Part, Shape
from warpvec.making.strokes import stroke_region

EMPTY: BaseGeometry = Polygon()

_ROUND_STEPS = 32
"""Chords of a quarter of a circle in offsets: 0.003 mm off at a radius of 10 mm."""

_NARROW_LENGTH = 2.0
"""Length in widths from which a narrow place counts. The tips of all corners are narrow, but shorter."""

_SPECK = 1e-4
"""Area in square millimetres below which a region is rounding error."""


def region_of(part: Part, error: float = FINE_ERROR) -> BaseGeometry:
    """Return the area that a part covers: the inside of its outlines by the non-zero rule, or its stroke.

    Its chords are at most ``error`` off.
    """
    if part.stroke is not None:
        return areas_of(shapely.union_all([stroke_region(shape, part.stroke, error) for shape in part.shapes]))
    lines = [line_of(shape, error) for shape in part.shapes]
    rings = [Polygon(line) for line in lines if len(line) > 2]
    area, first = EMPTY, None
    # A smaller outline lies in larger ones or beside them: it is a hole if it runs the other way.
    for ring in sorted(rings, key=lambda each: -each.area):
        is_left = ring.exterior.is_ccw
        first = is_left if first is None else first
        whole = shapely.make_valid(ring)
        area = area.union(whole) if is_left == first else area.difference(whole)
    return areas_of(area)


def line_of(shape: Shape, error: float = FINE_ERROR) -> Floats:
    """Return points [K, 2] along a shape, whose chords are at most ``error`` off; an open line has its end."""
    if isinstance(shape, Outline):
        parts = [piece.chords(error) for piece in shape.pieces]
        return np.concatenate(parts if shape.is_closed else [*parts, shape.pieces[-1].points[-1:]])
    return shape.chords(error)


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
    """Return the outlines of ``region``: circles, or lines and arcs."""
    plain = shapely.orient_polygons(region)
    rings = [ring for each in _polygons(plain) for ring in (each.exterior, *each.interiors)]
    return tuple(closed_shape(np.asarray(ring.coords)[:-1]) for ring in rings)


def stroke_edges(part: Part) -> Part:
    """Return ``part`` with both edges of its stroke in place of the centre line; a filled part as it is."""
    if part.stroke is None:
        return part
    half, shape = part.stroke.width / 2.0, part.shapes[0]
    if isinstance(shape, Circle) and len(part.shapes) == 1:
        inner = (shape._replace(radius=shape.radius - half, turn=-shape.turn),) if shape.radius > half else ()
        return replace(part, shapes=(shape._replace(radius=shape.radius + half), *inner), stroke=None)
    return replace(part, shapes=outlines_of(region_of(part)), stroke=None)
