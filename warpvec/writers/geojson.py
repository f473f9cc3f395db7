"""Write GeoJSON files (RFC 7946) of scanned maps: what shows of each colour is a feature, and none overlap.

Coordinates are pixels, or millimetres of a drawing with a size in real units; y is negative and points up, as QGIS
places pictures without a world file, so that both lie on each other.
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from warpvec.writers.writer import Target, Writer, check_package

if TYPE_CHECKING:  # NumPy, which the help does without
    from warpvec.arrays import Floats

STEP = 0.001
"""Distance of coordinates in pixels: what outlines are checked to."""


def _check(path: str, name: str) -> None:
    check_package("shapely", path, name)


def _encode(svg: str, target: Target) -> bytes:
    _check("drawing.geojson", "path")
    del target
    import shapely  # not above: it is not needed for other files

    from warpvec.making.parts import read_parts
    from warpvec.making.polygons import regions_by_color

    # A pixel is a millimetre: so many are in an inch.
    features = [
        {
            "type": "Feature",
            "properties": {"fill": color},
            "geometry": json.loads(shapely.to_geojson(shapely.orient_polygons(shapely.transform(region, _upwards)))),
        }
        for color, region in regions_by_color(read_parts(svg, 25.4), STEP).items()
    ]
    return json.dumps({"type": "FeatureCollection", "features": features}).encode()


def _upwards(places: Floats) -> Floats:
    return places * (1.0, -1.0)


WRITER = Writer(".geojson", "application/geo+json", _encode, _check, draws_blur=False)
