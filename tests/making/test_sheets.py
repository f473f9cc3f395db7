"""Sheets for each colour: areas against closed forms, marks, and what is said to go wrong."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import pytest
from commands import assert_refused, invoke

pytest.importorskip("shapely")
pytest.importorskip("ezdxf")

import shapely
from PIL import Image, ImageDraw

from warpvec.cli.cutting import CUT_OPTIONS, check_cutting
from warpvec.errors import InputError
from warpvec.making.checks import cut_warnings
from warpvec.making.parts import Circle, Sheet, read_parts
from warpvec.making.regions import region_of
from warpvec.making.sheet_svg import sheet_text
from warpvec.making.sheets import SheetOptions, sheets_of
from warpvec.svg.units import stated_size

HEAD = '<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="60mm" viewBox="0 0 100 60">'
DRAWING = (
    f'{HEAD}<rect width="100" height="60" fill="#fff"/><rect fill="#00f" x="10" y="10" width="40" height="40"/>'
    '<circle fill="#f00" cx="50" cy="30" r="10"/><circle fill="#0a0" cx="80" cy="30" r="8"/>'
    '<path fill="none" stroke="#f00" stroke-width="4" d="M70 55h20.01"/></svg>'
)
PLAIN = SheetOptions()


def area(sheet: Sheet) -> float:
    return float(whole(sheet).area)


def whole(sheet: Sheet) -> shapely.Geometry:
    return shapely.union_all([region_of(part) for part in sheet.parts if part.layer is None])


def union(sheets: Iterable[Sheet]) -> shapely.Geometry:
    return shapely.union_all([whole(sheet) for sheet in sheets])


def test_a_sheet_has_what_shows_of_its_colour_and_the_page_has_none() -> None:
    sheets = sheets_of(read_parts(DRAWING), PLAIN)
    assert list(sheets) == ["#0000ff", "#ff0000", "#00aa00"]
    expected = {"#0000ff": 1600 - 50 * math.pi, "#ff0000": 100 * math.pi + 4 * 20.01, "#00aa00": 64 * math.pi}
    assert {color: area(sheet) for color, sheet in sheets.items()} == pytest.approx(expected, rel=2e-3)
    assert [type(shape) for part in sheets["#00aa00"].parts for shape in part.shapes] == [Circle]


def test_a_bleed_reaches_below_the_colours_on_top_and_nowhere_else() -> None:
    plain, bled = (sheets_of(read_parts(DRAWING), SheetOptions(bleed=bleed)) for bleed in (0.0, 1.0))
    assert area(bled["#0000ff"]) - area(plain["#0000ff"]) == pytest.approx(9.5 * math.pi, rel=0.1)
    assert area(bled["#ff0000"]) == pytest.approx(area(plain["#ff0000"]), rel=1e-4)
    assert union(bled.values()).symmetric_difference(union(plain.values())).area < 0.5  # of chords


def test_a_kerf_is_made_up_for_at_outlines_and_holes() -> None:
    circles = "M30 30a20 20 0 1 0 40 0a20 20 0 1 0-40 0zM40 30a10 10 0 1 0 20 0a10 10 0 1 0-20 0z"
    ring = f'{HEAD}<path fill="#000" fill-rule="evenodd" d="{circles}"/></svg>'
    (sheet,) = sheets_of(read_parts(ring), SheetOptions(kerf=0.4)).values()
    radii = sorted(shape.radius for part in sheet.parts for shape in part.shapes if isinstance(shape, Circle))
    assert radii == pytest.approx([9.8, 20.2], abs=0.02)
    square = f'{HEAD}<rect fill="#000" x="10" y="10" width="20" height="20"/></svg>'
    (sheet,) = sheets_of(read_parts(square), SheetOptions(kerf=0.4)).values()
    assert area(sheet) == pytest.approx(20.4**2, rel=1e-4)  # corners stay sharp


def test_a_mirrored_sheet_is_turned_over_with_its_marks() -> None:
    options = SheetOptions(registration=True, weeding=True, size_check=True)
    drawing = read_parts(DRAWING)
    plain, turned = (sheets_of(drawing, each)["#00aa00"] for each in (options, replace(options, mirror=True)))
    assert turned.parts[0].shapes[0].x == pytest.approx(plain.width - plain.parts[0].shapes[0].x)
    boxes = [[shapely.bounds(region_of(part)) for part in sheet.parts] for sheet in (plain, turned)]
    for (left, top, right, bottom), found in zip(*boxes, strict=True):
        assert found.tolist() == pytest.approx([plain.width - right, top, plain.width - left, bottom], abs=0.02)


def test_all_sheets_have_the_same_marks_and_a_square_of_twenty_millimetres() -> None:
    options = SheetOptions(registration=True, size_check=True)
    sheets = sheets_of(read_parts(DRAWING), options)
    marks = [next(part for part in sheet.parts if part.layer == "marks") for sheet in sheets.values()]
    assert len({sheet_text(Sheet((each,), 1, 1)) for each in marks}) == 1
    assert len({(sheet.width, sheet.height) for sheet in sheets.values()}) == 1
    square = marks[0].shapes[-1]
    assert [piece.length for piece in square.pieces] == pytest.approx([20.0] * 4)
    for sheet in sheets.values():
        inside = shapely.box(0, 0, sheet.width, sheet.height)
        assert all(inside.covers(region_of(part)) for part in sheet.parts)


HAIRS = f"""{HEAD}<defs><linearGradient id="g1" gradientUnits="userSpaceOnUse" x1="0" y1="0" x2="9" y2="0">
<stop stop-color="#000"/><stop offset="1" stop-color="#00f"/></linearGradient></defs>
<path fill="#000" d="M10 10h20v9.9h20v.2h-20v9.9h-20z"/><circle fill="#000" cx="80" cy="40" r="1"/>
<rect fill="url(#g1)" x="60" y="2" width="20" height="9"/><rect fill="#f00" fill-opacity=".5" x="5" y="40" width="20" height="9"/></svg>"""  # noqa: E501


def test_what_will_go_wrong_is_named() -> None:
    found = "\n".join(cut_warnings(read_parts(HAIRS), 0.5, PLAIN))
    assert "1 gradient will be cut in one colour" in found and "1 translucent path will be opaque" in found
    assert "#000000: 1 place narrower than 0.5 mm may tear; the largest at 40, 20 mm" in found
    assert "#000000: 1 piece below 4 mm² may get lost; the first at 80, 40 mm" in found
    assert len(found.splitlines()) == 4
    assert not cut_warnings(read_parts(DRAWING), 0.5, PLAIN)


def test_the_blur_of_a_soft_path_is_named() -> None:
    blur = '<defs><filter id="b"><feGaussianBlur stdDeviation="2"/></filter></defs>'
    head = '<svg xmlns="http://www.w3.org/2000/svg" width="40" height="40">'
    soft = f'{head}{blur}<path filter="url(#b)" d="M9 9h20v20z"/></svg>'
    assert "1 soft path will be cut along the outline, without the blur" in cut_warnings(read_parts(soft), 0.5, PLAIN)


def test_narrow_places_are_removed_by_choice() -> None:
    plain, wide = (sheets_of(read_parts(HAIRS), SheetOptions(min_width=width))["#000000"] for width in (0.0, 0.5))
    assert area(plain) - area(wide) == pytest.approx(20 * 0.2, rel=0.05)


@pytest.mark.parametrize(
    ("pixels", "size"), [(None, (100.0, 60.0)), (96, (377.953, 226.772)), (72, (283.465, 170.079))]
)
def test_a_sheet_states_its_size_for_programs_that_read_pixels(pixels: float | None, size: tuple[float, float]) -> None:
    text = sheet_text(sheets_of(read_parts(DRAWING), PLAIN)["#0000ff"], pixels)
    assert 'viewBox="0 0 100 60"' in text
    scale = 96 / 25.4 if pixels is None else 1.0
    assert stated_size(dict(zip(("width", "height"), _sides(text), strict=True))) == pytest.approx(
        [side * scale for side in size], abs=1e-3
    )
    plain = sheets_of(read_parts(DRAWING), PLAIN)["#0000ff"]
    assert area(read_parts(text, pixels or 96.0)) == pytest.approx(area(plain), rel=1e-4)


def _sides(text: str) -> list[str]:
    return [text.split(f' {side}="')[1].split('"')[0] for side in ("width", "height")]


@pytest.fixture
def flag(tmp_path: Path) -> Path:
    image = Image.new("RGB", (480, 360), "white")
    ImageDraw.Draw(image).rectangle((60, 60, 239, 299), fill=(0, 0, 200))
    ImageDraw.Draw(image).ellipse((240, 100, 400, 260), fill=(200, 0, 0))
    image.resize((120, 90), Image.Resampling.BOX).save(tmp_path / "flag.png")
    return tmp_path / "flag.png"


def test_the_command_writes_a_sheet_for_each_colour(flag: Path) -> None:
    folder = flag.parent / "sheets"
    options = ("--size", "90mm", "--kerf", "0.2mm", "--check-cut", "--ppi", "72", "--json")
    result = invoke("run", flag, flag.with_name("out.svg"), "--sheets", folder, *options)
    assert result.exit_code == 0, result.stderr
    assert sorted(path.name for path in folder.iterdir()) == ["01-0000c8.svg", "02-c80000.svg"]
    assert "2 sheets: 01-0000c8.svg, 02-c80000.svg" in result.stderr
    assert "cut: nothing that would go wrong was found" in result.stderr
    facts = json.loads(result.stdout)
    assert (facts["cut_warnings"], facts["sheets"]) == ([], ["01-0000c8.svg", "02-c80000.svg"])
    assert _sides((folder / "01-0000c8.svg").read_text()) == ["255.118", "191.339"]
    assert _sides(flag.with_name("out.svg").read_text()) == ["255.1181", "191.3386"]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--kerf", "0.2mm"], "--kerf must come with --sheets"),
        (["--mirror"], "--mirror must come with --sheets"),
        (["--min-width", "1mm"], "--min-width must come with --sheets or --check-cut"),
        (["--sheets", "out", "--kerf", "0.2"], "--kerf must be a length in mm, cm or in"),
        (["--sheets", "flag.png"], "--sheets must be a folder"),
    ],
)
def test_options_of_sheets_are_checked_before_the_work(
    flag: Path, options: list[str], words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(flag.parent)
    assert_refused(invoke("run", flag, "out.svg", *options), words)
    assert [path.name for path in flag.parent.iterdir()] == ["flag.png"]


def test_sheets_go_to_a_new_folder_and_to_one_that_is_there(flag: Path, tmp_path: Path) -> None:
    for name in ("new", "."):
        check_cutting({**dict.fromkeys(CUT_OPTIONS), "sheets": str(tmp_path / name)})
    with pytest.raises(InputError, match="--sheets must be a folder"):
        check_cutting({**dict.fromkeys(CUT_OPTIONS), "sheets": str(flag)})
    with pytest.raises(InputError, match="--sheets must be a valid file name"):
        check_cutting({**dict.fromkeys(CUT_OPTIONS), "sheets": "a" * 5000})
