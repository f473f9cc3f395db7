"""Edges of a drawing, each once: their lengths against closed forms, strokes, and the command."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from commands import assert_refused, invoke

pytest.importorskip("shapely")
pytest.importorskip("ezdxf")
pytest.importorskip("pathops")

import ezdxf
import shapely
from PIL import Image

from warpvec.flat.cutting.edges_once import edges_once
from warpvec.making.parts import Circle, Outline, Sheet
from warpvec.making.regions import line_of

HEAD = '<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="60mm" viewBox="0 0 100 60">'
TWO = '<rect fill="#00f" x="10" y="10" width="20" height="20"/><rect fill="#f00" x="30" y="10" width="20" height="20"/>'
PAGE = '<rect width="100" height="60" fill="#fed"/>'


def _lines(sheet: Sheet) -> list[shapely.LineString]:
    lines = []
    for shape in (shape for part in sheet.parts for shape in part.shapes):
        points = line_of(shape)
        is_closed = isinstance(shape, Circle) or shape.is_closed  # type: ignore[union-attr]
        lines.append(shapely.LineString([*points, points[0]] if is_closed else points))
    return lines


@pytest.mark.parametrize("page", ["", PAGE])
def test_an_edge_of_two_parts_is_there_once_and_the_page_has_none(page: str) -> None:
    lines = _lines(edges_once(f'{HEAD}{page}{TWO}<circle fill="#0a0" cx="20" cy="20" r="5"/></svg>'))
    total = sum(line.length for line in lines)
    assert total == pytest.approx(7 * 20 + 10 * math.pi, rel=1e-3)
    assert shapely.union_all(lines).length == pytest.approx(total, rel=1e-3)
    assert len(lines) == 3  # around both, between them, and the circle


def test_a_shape_below_another_goes_on_along_what_shows() -> None:
    below = f'{HEAD}<rect fill="#00f" x="10" y="10" width="40" height="40"/>'
    sheet = edges_once(f'{below}<circle fill="#f00" cx="50" cy="30" r="10"/></svg>')
    (part,) = sheet.parts
    assert [type(shape) for shape in part.shapes].count(Circle) == 1  # whole, as it lies on top
    assert sum(line.length for line in _lines(sheet)) == pytest.approx(20 * math.pi + 160 - 20, rel=1e-3)


def test_strokes_are_outlined_or_stay_lines() -> None:
    svg = f'{HEAD}<path fill="none" stroke="#f00" stroke-width="4" d="M20 30h40"/></svg>'
    outlined, kept = edges_once(svg), edges_once(svg, keeps_lines=True)
    assert [sum(line.length for line in _lines(each)) for each in (outlined, kept)] == pytest.approx([88, 40], rel=1e-3)


def test_the_edges_of_a_ring_are_circles_and_arcs_stay_whole() -> None:
    ring = '<circle fill="none" stroke="#f00" stroke-width="4" cx="50" cy="30" r="20"/>'
    (part,) = edges_once(f"{HEAD}{ring}</svg>").parts
    radii = sorted(shape.radius for shape in part.shapes if isinstance(shape, Circle))
    assert radii == pytest.approx([18, 22], abs=0.005)
    notched = f'{HEAD}<circle fill="#00f" cx="50" cy="30" r="20"/><path fill="#f00" d="M50 26.3h40v8h-40z"/></svg>'
    shapes = [shape for part in edges_once(notched).parts for shape in part.shapes]
    pieces = [piece for shape in shapes if isinstance(shape, Outline) for piece in shape.pieces]
    assert sum(bool(piece.bulge) for piece in pieces) <= 3 and not any(piece.is_cubic for piece in pieces)


@pytest.mark.slow
def test_the_command_writes_the_edges_and_checks_the_name_first(tmp_path: Path) -> None:
    image = Image.new("RGB", (96, 67), "white")
    image.paste((200, 0, 0), (11, 13, 40, 50))
    image.paste((0, 0, 200), (40, 13, 83, 50))
    image.save(tmp_path / "flag.png")
    command = ("run", tmp_path / "flag.png", tmp_path / "flag.svg", "--size", "90mm", "--json", "--cut-once")
    assert_refused(invoke(*command, tmp_path / "cut.pdf"), "--cut-once must end in .dxf or .svg")
    result = invoke(*command, tmp_path / "cut.dxf")
    assert result.exit_code == 0, result.stderr
    assert json.loads(result.stdout)["cut_once"] == 2
    assert "2 lines, each edge once" in result.stderr
    space = ezdxf.readfile(tmp_path / "cut.dxf").modelspace()
    assert {entity.dxf.layer for entity in space} == {"cut"}
