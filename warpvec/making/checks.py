"""Say what will go wrong when a drawing is cut."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import shapely

from warpvec.checks import counted
from warpvec.making.parts import Sheet
from warpvec.making.regions import narrow_places, region_of
from warpvec.making.sheets import SheetOptions, outline_count, sheets_of

MIN_WIDTH_MM = 0.5
"""Width in millimetres below which a place is called narrow: vinyl tears there, and wood burns away."""

PIECE_MIN = 4.0
"""Area in square millimetres below which a piece gets lost: 2 x 2 mm."""

OUTLINES_MAX = 5_000
"""Most outlines of a sheet that Cricut's program takes."""


def cut_warnings(drawing: Sheet, min_width: float, options: SheetOptions) -> list[str]:
    """Return what will go wrong, a sentence each. A pen cuts nothing: no place tears, and no piece gets lost.

    Args:
        drawing: the parts.
        min_width: places that are narrower, in millimetres, tear.
        options: how its sheets will be made.
    """
    sheets = sheets_of(drawing, replace(options, registration=False, weeding=False, size_check=False))
    found = list(_of_paints(drawing, "drawn" if options.keeps_lines else "cut"))
    for color, sheet in sheets.items():
        if not options.keeps_lines:
            found += _of_region(color, sheet, min_width)
        if outline_count(sheet) > OUTLINES_MAX:
            found.append(
                f"{color}: {outline_count(sheet):,} outlines are more than the {OUTLINES_MAX:,} that Cricut takes"
            )
    return found


def _of_paints(drawing: Sheet, made: str) -> Iterator[str]:
    gradients = sum(part.has_gradient for part in drawing.parts)
    translucent = sum(not part.is_opaque for part in drawing.parts)
    soft = sum(part.is_soft for part in drawing.parts)
    if soft:
        yield f"{counted(soft, 'soft path')} will be {made} along the outline, without the blur"
    if gradients:
        yield f"{counted(gradients, 'gradient')} will be {made} in one colour, the mean of its stops"
    if translucent:
        yield f"{counted(translucent, 'translucent path')} will be opaque"


def _of_region(color: str, sheet: Sheet, min_width: float) -> Iterator[str]:
    region = shapely.union_all([region_of(part) for part in sheet.parts])
    narrow = narrow_places(region, min_width)
    if narrow:
        place = max(narrow, key=lambda each: float(each.area)).representative_point()
        where = f"the largest at {place.x:.0f}, {place.y:.0f} mm"
        yield f"{color}: {counted(len(narrow), 'place')} narrower than {min_width:g} mm may tear; {where}"
    small = [each for each in _pieces(region) if each.area < PIECE_MIN]
    if small:
        place = small[0].representative_point()
        where = f"the first at {place.x:.0f}, {place.y:.0f} mm"
        yield f"{color}: {counted(len(small), 'piece')} below {PIECE_MIN:g} mm² may get lost; {where}"


def _pieces(region: object) -> list[shapely.Polygon]:
    return [each for each in shapely.get_parts(region) if not each.is_empty]
