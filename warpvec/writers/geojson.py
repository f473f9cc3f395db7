"""Write GeoJSON files (RFC 7946) of scanned maps: what shows of each colour is a feature, and none overlap.

Coordinates are pixels, or millimetres of a drawing with a size in real units; y is negative and points up, as QGIS
places pictures without a world file, so that both lie on each other. With a world file, coordinates are those of its
map, whatever they are: RFC 7946 wants longitude and latitude, and programs ask for other systems.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from warpvec.writers.writer import Target, Writer, check_package

if TYPE_CHECKING:  # NumPy, which the help does without
    from warpvec.arrays import Floats

_PER_INCH = 25.4
"""Pixels in an inch: a pixel is a millimetre."""

STEP = 0.001
"""Distance of coordinates in pixels: what outlines are checked to."""


def _check(path: str, name: str) -> None:
    check_package("shapely", path, name)


def _encode(svg: str, target: Target) -> bytes:
    _check("drawing.geojson", "path")
    import shapely  # not above: it is not needed for other files

    from warpvec.making.parts import read_parts
    from warpvec.making.polygons import regions_by_color

    sheet = read_parts(svg, _PER_INCH)

    def placed(places: Floats) -> Floats:
        return places * (1.0, -1.0) if target.world is None else _on_map(places, sheet.width, target)

    features = [
        {
            "type": "Feature",
            "properties": {"fill": color},
            "geometry": json.loads(shapely.to_geojson(shapely.orient_polygons(shapely.transform(region, placed)))),
        }
        for color, region in regions_by_color(sheet, STEP).items()
    ]
    return json.dumps({"type": "FeatureCollection", "features": features}).encode()


def _on_map(places: Floats, width: float, target: Target) -> Floats:
    """Return ``places`` [N, 2] of a drawing of this ``width`` as places on the map of a world file."""
    import numpy as np  # not above: the help does without

    assert target.world is not None
    a, d, b, e, c, f = target.world
    per_unit = 1.0 if target.canvas is None else target.canvas.width / width
    x, y = (per_unit * places - 0.5).T  # a world file places the centres of pixels
    return np.stack([a * x + b * y + c, d * x + e * y + f], 1)


WRITER = Writer(".geojson", "application/geo+json", _encode, _check, draws_blur=False)
