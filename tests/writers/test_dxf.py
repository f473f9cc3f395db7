"""DXF files for cutters, read back by ezdxf and compared with the SVG as svgelements reads it."""

from __future__ import annotations

import math
import sys
from io import StringIO
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from inkscape_runs import opened_dxf, why_no_scripts
from logo import logo
from numpy.typing import NDArray
from scipy.spatial import cKDTree  # type: ignore[import-untyped]
from svgelements import SVG, Shape
from svgelements import Path as SvgPath

import warpvec
from warpvec.errors import InputError
from warpvec.writers.registry import encode
from warpvec.writers.writer import Target

ezdxf = pytest.importorskip("ezdxf")

HEAD = '<svg xmlns="http://www.w3.org/2000/svg" width="300mm" height="200mm" viewBox="0 0 240 160">'
FORMS = """<circle fill="#182" cx="60" cy="60" r="50"/>
<ellipse fill="#27c" cx="170" cy="40" rx="20" ry="30" transform="rotate(30 170 40)"/>
<rect fill="#b3b" x="130" y="90" width="90" height="60" rx="25" transform="rotate(-10 175 120)"/>
<rect fill="#b3b" x="10" y="120" width="40" height="30"/>"""
PATHS = """<path fill="#c22" d="M20.02 20h80a30 30 0 0 1 0 60h-80zm40 30a10 10 0 0 0-20 0a10 10 0 0 0 20 0z"/>
<path fill="#128" d="M120 20c40-30 90 20 60 60c-30 30-70 10-70-20z"/>
<path fill="none" stroke="#c22" stroke-width="5" stroke-linecap="round" d="M20 100c30-20 50 30 90 10l10 30"/>
<path fill="none" stroke="#000" stroke-width="3" d="M130 110h60v30z"/>"""
PAGE = '<rect width="240" height="160" fill="#fff"/><path fill="#eee" d="M-1-1h242v162h-242z"/>'


def svg(shapes: str) -> str:
    return f"{HEAD}\n{shapes}\n</svg>"


def read(data: bytes, folder: Path) -> Any:
    path = folder / "drawing.dxf"
    path.write_bytes(data)
    document = ezdxf.readfile(path)
    auditor = document.audit()
    assert not auditor.errors and not auditor.fixes
    return document


def points_of_dxf(document: Any) -> NDArray[np.float64]:
    """Return points every 0.01 mm along all entities, with y down."""
    entities = [
        part
        for each in document.modelspace()
        for part in (each.virtual_entities() if each.dxftype() == "LWPOLYLINE" else [each])
    ]
    return np.concatenate([dense(line_of(each)) for each in entities]) * (1, -1) + (0, 200)


def line_of(entity: Any) -> NDArray[np.float64]:
    if entity.dxftype() == "LINE":
        points = [entity.dxf.start, entity.dxf.end]
    else:
        points = list(entity.flattening(0.0005))
    return np.array([tuple(point)[:2] for point in points])


def points_of_svg(text: str) -> NDArray[np.float64]:
    """Return points along all shapes but the page, in millimetres, without any code of warpvec."""
    lines = []
    for element in SVG.parse(StringIO(text.replace(PAGE, "")), reify=True, ppi=25.4).elements():
        if isinstance(element, Shape):
            for part in SvgPath(element).reify().as_subpaths():
                steps = [segment.npoint(np.linspace(0, 1, 400)) for segment in SvgPath(part) if segment.length() > 0]
                lines += [dense(np.asarray(step).reshape(-1, 2)) for step in steps]
    return np.concatenate(lines)


def dense(line: NDArray[np.float64]) -> NDArray[np.float64]:
    parts = []
    for start, end in pairwise(line):
        count = 2 + int(np.hypot(*(end - start)) / 0.01)
        parts.append(start + np.linspace(0, 1, count)[:, None] * (end - start))
    return np.concatenate(parts)


def farthest(first: NDArray[np.float64], second: NDArray[np.float64]) -> float:
    """Return the Hausdorff distance of two sets of points."""
    distances = (cKDTree(a).query(b)[0].max() for a, b in ((first, second), (second, first)))
    return float(max(distances))


@pytest.mark.parametrize("splines", [False, True])
def test_a_dxf_file_is_the_svg_within_a_fiftieth_of_a_millimetre(splines: bool, tmp_path: Path) -> None:
    text = svg(PAGE + FORMS + PATHS)
    document = read(encode(text, "a.dxf", Target(splines=splines, center_lines=True)), tmp_path)
    assert document.units == ezdxf.units.MM
    # Programs place a drawing by its extents, such as Inkscape.
    assert [tuple(document.header[name])[:2] for name in ("$EXTMIN", "$EXTMAX")] == [(0, 0), (300, 200)]
    assert farthest(points_of_dxf(document), points_of_svg(text)) < 0.02


def test_circles_and_arcs_are_true_ones(tmp_path: Path) -> None:
    data = encode(svg(PAGE + FORMS + PATHS), "a.dxf", Target(center_lines=True))
    space = read(data, tmp_path).modelspace()
    kinds = [each.dxftype() for each in space]
    assert kinds == [
        *("CIRCLE", "LWPOLYLINE", "LWPOLYLINE", "LWPOLYLINE"),
        *("LWPOLYLINE", "CIRCLE", "LWPOLYLINE", "LWPOLYLINE", "LWPOLYLINE"),
    ]
    circle, _, round_rect, rect, flag, hole, blob, line, triangle = space
    assert (round(circle.dxf.radius, 3), round(hole.dxf.radius, 3)) == (62.5, 12.5)
    assert [len(each) for each in (round_rect, rect, flag, triangle)] == [8, 4, 4, 3]
    assert sum(abs(bulge) > 0.99 for *_, bulge in flag.get_points("xyb")) == 1
    assert [each.closed for each in (round_rect, rect, flag, blob, line, triangle)] == [
        True,
        True,
        True,
        True,
        False,
        True,
    ]


def test_a_layer_holds_a_colour_and_the_page_is_not_a_part(tmp_path: Path) -> None:
    document = read(encode(svg(PAGE + FORMS + PATHS), "a.dxf"), tmp_path)
    of_shapes = {each.dxf.layer for each in document.modelspace()}
    assert of_shapes == {"#118822", "#2277cc", "#bb33bb", "#cc2222", "#112288", "#000000"}
    assert {name: document.layers.get(name).rgb for name in ("#cc2222",)} == {"#cc2222": (0xCC, 0x22, 0x22)}


@pytest.mark.parametrize(
    ("data", "kind"),
    [
        ("M20 20h80", "LINE"),
        ("M20.02 20a30 30 0 0 1 60 0", "ARC"),
        ("M20.02 20a30 30 0 0 0 60 0", "ARC"),
        ("M20 20h0", "POINT"),
    ],
)
def test_a_stroke_of_one_piece_is_a_single_entity(data: str, kind: str, tmp_path: Path) -> None:
    text = svg(f'<path fill="none" stroke="#000" stroke-width="2" stroke-linecap="round" d="{data}"/>')
    document = read(encode(text, "a.dxf", Target(center_lines=True)), tmp_path)
    (entity,) = document.modelspace()
    assert entity.dxftype() == kind
    if kind != "POINT":
        assert farthest(points_of_dxf(document), points_of_svg(text)) < 0.02


@pytest.mark.parametrize(
    ("element", "style"),
    [
        ('<circle cx="120" cy="80" r="50"', {}),
        ('<path stroke-linecap="round" stroke-linejoin="round" d="M20.02 20h60a30 30 0 0 1 30 30v30"', {}),
        ('<path stroke-linecap="square" d="M20.02 20h60v70"', {"cap_style": "square", "join_style": "mitre"}),
        ('<path stroke-linejoin="bevel" d="M20.02 20h60l-50 30z"', {"join_style": "bevel"}),
        ('<path stroke-linejoin="round" d="M20.02 100c30-60 50 30 90 10"', {"cap_style": "flat"}),
    ],
)
def test_a_stroke_has_both_its_edges(element: str, style: dict[str, Any], tmp_path: Path) -> None:
    text = svg(f'{element} fill="none" stroke="#000" stroke-width="6"/>')
    document = read(encode(text, "a.dxf"), tmp_path)
    points = points_of_svg(text)[::4]
    is_ring = "z" in element or "circle" in element
    line = shapely.LinearRing(points) if is_ring else shapely.LineString(points)
    expected = line.buffer(3.75, quad_segs=100, **style).segmentize(0.02).boundary
    assert farthest(points_of_dxf(document), shapely.get_coordinates(expected)) < 0.05  # buffers are 0.04 mm off


def test_the_edges_of_a_ring_are_true_circles_and_a_cap_is_an_arc(tmp_path: Path) -> None:
    ring = '<circle cx="120" cy="80" r="60" fill="none" stroke="#000" stroke-width="10"/>'
    looks = 'fill="none" stroke="#000" stroke-width="6" stroke-linecap="round"'
    text = svg(f'{ring}<path {looks} d="M20.02 20h60a30 30 0 0 1 30 30"/>')
    outer, inner, edge = read(encode(text, "a.dxf"), tmp_path).modelspace()
    assert [outer.dxf.radius, inner.dxf.radius] == pytest.approx([81.25, 68.75])
    bulges = sorted(abs(bulge) for *_, bulge in edge.get_points("xyb"))
    assert bulges == pytest.approx([0, 0, math.tan(math.pi / 8), math.tan(math.pi / 8), 1, 1], abs=2e-3)


@pytest.mark.parametrize(
    ("options", "has_edges"),
    [
        ({"mode": "lines"}, False),
        ({"mode": "lines", "dxf_strokes": "edges"}, True),
        ({"mode": "flat", "strokes": "all"}, True),
        ({"mode": "flat", "strokes": "all", "purpose": "pen"}, False),
    ],
)
def test_pens_get_the_lines_and_cutters_both_edges(options: dict[str, Any], has_edges: bool, tmp_path: Path) -> None:
    pixels = np.full((48, 64, 3), 255, np.uint8)
    pixels[20:24, 8:56] = 0
    result = warpvec.vectorize(pixels, **options, threads=1, iterations=4)
    assert result.scene.strokes is not None
    (entity,) = read(result.encoded("a.dxf"), tmp_path).modelspace()
    assert (entity.dxftype() == "LWPOLYLINE") == has_edges
    if "dxf_strokes" not in options and "purpose" not in options:  # the page has the text alone
        assert encode(result.svg(), "a.dxf") == result.encoded("a.dxf")


def test_a_curve_is_arcs_and_few(tmp_path: Path) -> None:
    text = svg('<path fill="#128" d="M120.02 20c40-30 90 20 60 60c-30 30-70 10-70-20z"/>')
    document = read(encode(text, "a.dxf"), tmp_path)
    (outline,) = document.modelspace()
    assert len(outline) < 40 and sum(bulge != 0 for *_, bulge in outline.get_points("xyb")) > len(outline) / 2
    assert farthest(points_of_dxf(document), points_of_svg(text)) < 0.02


def test_a_saved_drawing_has_true_circles_and_the_same_bytes_each_time(tmp_path: Path) -> None:
    pixels, options = logo(has_shadow=False), {"background": "white", "cutout": True, "size": "90mm"}
    result = warpvec.vectorize(pixels, **options, threads=1, iterations=4)
    for name in ("a.dxf", "b.DXF"):
        result.save(tmp_path / name)
    data = (tmp_path / "a.dxf").read_bytes()
    assert data == (tmp_path / "b.DXF").read_bytes()
    circles = read(data, tmp_path).modelspace().query("CIRCLE")
    assert 23 in [round(each.dxf.radius) for each in circles]


def test_without_ezdxf_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ezdxf", None)
    with pytest.raises(InputError, match=r"unless ezdxf is installed, which writes .dxf.*warpvec\[cut\]"):
        encode(svg(FORMS), tmp_path / "out.dxf")


def test_ellipses_are_true_ones_on_request(tmp_path: Path) -> None:
    space = read(encode(svg(FORMS), "a.dxf", Target(splines=True)), tmp_path).modelspace()
    (ellipse,) = space.query("ELLIPSE")
    assert (round(ellipse.dxf.major_axis.magnitude, 3), round(ellipse.dxf.ratio, 4)) == (37.5, 0.6667)


@pytest.mark.slow
@pytest.mark.skipif(bool(why_no_scripts()), reason=why_no_scripts())
@pytest.mark.parametrize(("shapes", "splines"), [(FORMS + PATHS, False), (PATHS, True)])
def test_inkscape_opens_the_file_as_the_svg(shapes: str, splines: bool, tmp_path: Path) -> None:
    text = svg(shapes)
    path = tmp_path / "drawing.dxf"
    path.write_bytes(encode(text, path, Target(splines=splines, center_lines=True)))
    opened = opened_dxf(path, tmp_path / "opened.svg")
    # Its page is an upright A4 sheet in pixels. The drawing, 200 mm high, is in the lower left corner.
    points = points_of_svg(opened) * 25.4 / 96 - (0, 297 - 200)
    assert farthest(points, points_of_svg(text)) < 0.02
