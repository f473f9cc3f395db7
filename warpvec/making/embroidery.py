"""Say what will go wrong when a drawing is embroidered: satin and fill stitches need some width, and gaps close."""

from __future__ import annotations

from collections.abc import Iterator

import shapely
from shapely.geometry.base import BaseGeometry

from warpvec.making.parts import Sheet
from warpvec.making.regions import line_of, narrow_places, region_of
from warpvec.making.sheets import SheetOptions, sheets_of

WIDTH_MIN, GAP_MIN = 1.0, 0.4
"""Least width of a shape and of a gap in millimetres. A satin column of less than 1 mm sinks into the cloth, and a
thread is 0.4 mm thick."""


def embroidery_warnings(drawing: Sheet) -> list[str]:
    """Return what will go wrong, a line for each place, in millimetres from the upper left corner."""
    filled = [(part.color, shape) for part in drawing.parts if part.stroke is None for shape in part.shapes]
    lines = [(color, line_of(shape)) for color, shape in filled]
    loops = [(color, shapely.Polygon(line)) for color, line in lines if len(line) > 2]
    found = [f"{color}: an outline crosses itself {_at(loop)}" for color, loop in loops if not loop.is_valid]
    regions = []
    for color, sheet in sheets_of(drawing, SheetOptions()).items():
        regions.append(shapely.union_all([region_of(part) for part in sheet.parts]))
        found += [f"{color}: narrower than {WIDTH_MIN:g} mm {_at(place)}" for place in _narrow(regions[-1], WIDTH_MIN)]
    shown = shapely.union_all(regions)
    if not shown.is_empty:
        around = shapely.box(*shown.bounds).buffer(2.0 * GAP_MIN).difference(shown)
        found += [f"a gap below {GAP_MIN:g} mm {_at(place)}" for place in _narrow(around, GAP_MIN)]
    return found


def _narrow(region: BaseGeometry, width: float) -> Iterator[BaseGeometry]:
    """Yield the narrow places of a ``region``, the largest first."""
    yield from sorted(narrow_places(region, width), key=lambda place: -place.area)


def _at(place: BaseGeometry) -> str:
    point = place.representative_point()
    return f"at {point.x:.1f}, {point.y:.1f} mm"
