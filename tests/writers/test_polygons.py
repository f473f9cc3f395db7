"""GeoJSON files and footprints for KiCad, read back as shapely and KiCad's format have them."""

from __future__ import annotations

import json
import re

import pytest

pytest.importorskip("shapely")

import shapely

from warpvec.writers.registry import encode
from warpvec.writers.writer import Target

SVG = """<svg xmlns="http://www.w3.org/2000/svg" width="80" height="60" viewBox="0 0 80 60">
<path fill="#3a7" d="M5 5h50v50h-50zm20 20a5 5 0 0 0 10 0a5 5 0 0 0-10 0z"/>
<path fill="#c22" d="M40 20c10-20 40 0 30 20s-40 10-30-20z"/><path fill="#fff" d="M10 10h5v5h-5z"/></svg>"""
RING = 2500.0 - 25 * 3.14159


def test_features_are_valid_and_none_overlap() -> None:
    found = json.loads(encode(SVG, "map.geojson"))
    shapes = {each["properties"]["fill"]: shapely.geometry.shape(each["geometry"]) for each in found["features"]}
    assert list(shapes) == ["#33aa77", "#cc2222", "#ffffff"]
    assert all(shape.is_valid for shape in shapes.values())
    assert shapes["#33aa77"].intersection(shapes["#cc2222"]).area == pytest.approx(0.0, abs=1e-6)
    both = shapely.union_all(list(shapes.values()))
    assert both.area == pytest.approx(RING + shapes["#cc2222"].difference(shapely.box(5, -55, 55, -5)).area, rel=1e-3)
    assert shapes["#ffffff"].bounds == (10.0, -15.0, 15.0, -10.0)


def test_a_footprint_has_simple_polygons_about_the_middle_without_white() -> None:
    text = encode(SVG, 'logo".kicad_mod', Target(per_inch=25.4)).decode()
    assert text.count("(") == text.count(")")
    polygons = [
        shapely.Polygon([(float(x), float(y)) for x, y in re.findall(r"\(xy (\S+) (\S+?)\)", line)])
        for line in text.splitlines()
        if "fp_poly" in line
    ]
    assert len(polygons) >= 2
    assert all(polygon.is_valid for polygon in polygons)
    whole = shapely.union_all(polygons)
    assert whole.area == pytest.approx(sum(polygon.area for polygon in polygons), rel=1e-6)
    assert not whole.covers(shapely.Point(-10, -5))  # the hole
    assert not whole.covers(shapely.Point(-27.5, -17.5))  # white
    assert whole.bounds[:2] == (-35.0, -25.0)
