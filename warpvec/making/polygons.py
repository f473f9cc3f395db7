"""Make valid polygons of what shows of each colour of a drawing, for programs that know no curves."""

from __future__ import annotations

from collections.abc import Iterator

import shapely
from shapely.geometry import Polygon, box
from shapely.geometry.base import BaseGeometry

from warpvec.making.curves import CHORD_ERROR
from warpvec.making.parts import Sheet
from warpvec.making.regions import EMPTY, areas_of
from warpvec.making.sheets import visible_parts


def regions_by_color(sheet: Sheet, step: float) -> dict[str, BaseGeometry]:
    """Return what shows of each colour of ``sheet``, without overlaps, at multiples of ``step`` millimetres."""
    found: dict[str, list[BaseGeometry]] = {}
    for part, region in visible_parts(sheet.parts, keeps_lines=False, error=CHORD_ERROR):
        found.setdefault(part.color, []).append(region)
    rounded = ((color, areas_of(shapely.set_precision(shapely.union_all(own), step))) for color, own in found.items())
    return {color: region for color, region in rounded if region != EMPTY}


def without_holes(region: BaseGeometry, step: float) -> Iterator[Polygon]:
    """Yield polygons without holes, at multiples of ``step``, that cover ``region``: it is cut through its holes."""
    for area in shapely.get_parts(region):
        if not area.interiors:
            yield area
            continue
        left, top, right, bottom = area.bounds
        across = Polygon(area.interiors[0]).centroid.x
        for side in (box(left, top, across, bottom), box(across, top, right, bottom)):
            yield from without_holes(areas_of(shapely.set_precision(area.intersection(side), step)), step)
