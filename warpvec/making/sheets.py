"""A sheet for each colour of a drawing: what shows of it, made ready to be cut."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import shapely
from shapely.geometry.base import BaseGeometry

from warpvec.making.arcs import FINE_ERROR
from warpvec.making.marks import MARKS, with_marks
from warpvec.making.parts import Part, Sheet
from warpvec.making.regions import EMPTY, areas_of, grown, narrow_places, outlines_of, region_of, stroke_edges

_TOUCH = 1e-3
"""Area in square millimetres that two parts may share and still count as beside each other."""


@dataclass(frozen=True, kw_only=True)
class SheetOptions:
    """How sheets are made; lengths are in millimetres.

    Attributes:
        bleed: how far a colour reaches below the colours on top of it, so that sheets that are laid a little off leave
            no gaps.
        kerf: width of the cut. Outlines move outwards by half of it, and holes inwards.
        mirror: turn each sheet over, for transfers that are cut from behind.
        min_width: places that are narrower are removed; 0 for none.
        registration: add marks by which sheets are laid on each other.
        weeding: add a border around the drawing, along which the rest is peeled off.
        size_check: add a square of 20 mm to be measured.
        keeps_lines: keep strokes as their centre lines, for pens.
    """

    bleed: float = 0.0
    kerf: float = 0.0
    mirror: bool = False
    min_width: float = 0.0
    registration: bool = False
    weeding: bool = False
    size_check: bool = False
    keeps_lines: bool = False


def sheets_of(drawing: Sheet, options: SheetOptions) -> dict[str, Sheet]:
    """Return a sheet for each colour, from bottom to top, by "#rrggbb".

    Of each colour a sheet has what no other path covers. Parts that nothing changes keep their true curves, others have
    lines and arcs.
    """
    found = {}
    parts = drawing.parts if options.keeps_lines else tuple(map(stroke_edges, drawing.parts))
    visible = list(visible_parts(parts, options.keeps_lines))
    shown = (part for part, region in visible if not region.is_empty or _is_line(part, options))
    colors = list(dict.fromkeys(part.color for part in shown))
    for number, color in enumerate(colors):
        later = {*colors[number + 1 :]} if options.bleed else set()
        above = [region for part, region in visible if part.color in later]
        own = [(part, region) for part, region in visible if part.color == color]
        parts = tuple(_made(color, own, shapely.union_all(above), options))
        if parts:
            sheet = with_marks(replace(drawing, parts=parts), options.registration, options.weeding, options.size_check)
            found[color] = mirrored(sheet) if options.mirror else sheet
    return found


def _is_line(part: Part, options: SheetOptions) -> bool:
    return options.keeps_lines and part.stroke is not None


def visible_parts(
    parts: tuple[Part, ...], keeps_lines: bool, error: float = FINE_ERROR
) -> Iterator[tuple[Part, BaseGeometry]]:
    """Yield each part, from bottom to top, with the area that shows of it; that of a kept line is empty.

    Chords are at most ``error`` millimetres off.
    """
    covered, found = EMPTY, []
    for part in reversed(parts):
        whole = EMPTY if keeps_lines and part.stroke is not None else region_of(part, error)
        found.append((part, areas_of(whole.difference(covered)) if whole.intersects(covered) else whole))
        covered = covered.union(whole)
    yield from reversed(found)


def _made(
    color: str, own: list[tuple[Part, BaseGeometry]], above: BaseGeometry, options: SheetOptions
) -> Iterator[Part]:
    """Yield the parts of a sheet: first those that keep their curves, then one of all others."""
    changed = []
    is_changed_all = bool(options.bleed or options.kerf or options.min_width)
    for place, (part, region) in enumerate(own):
        others = [other for index, (_, other) in enumerate(own) if index != place]
        if _is_line(part, options):
            yield part
        elif is_changed_all or not _is_whole(part, region, others):
            changed.append(region)
        else:
            yield replace(part, has_gradient=False, is_opaque=True)
    region = shapely.union_all(changed)
    if options.bleed:
        below = grown(region, options.bleed, is_sharp=False).intersection(above)
        region = areas_of(region.union(below))
    if options.min_width:
        region = areas_of(region.difference(shapely.union_all(narrow_places(region, options.min_width))))
    if options.kerf:
        region = grown(region, options.kerf / 2.0, is_sharp=True)
    outlines = outlines_of(region)
    if outlines:
        yield Part(color, outlines)


def _is_whole(part: Part, region: BaseGeometry, others: list[BaseGeometry]) -> bool:
    """Return whether all of a filled part shows, and it touches no other part of its colour."""
    if part.stroke is not None or region.is_empty:
        return False
    is_covered = abs(region_of(part).area - region.area) > _TOUCH
    return not is_covered and not any(region.intersects(other) for other in others)


def mirrored(sheet: Sheet) -> Sheet:
    """Return ``sheet`` with left and right exchanged."""
    return replace(sheet, parts=tuple(part.mapped(lambda shape: shape.mirrored(sheet.width)) for part in sheet.parts))


def outline_count(sheet: Sheet) -> int:
    """Return the number of outlines that are cut, without marks."""
    return sum(len(part.shapes) for part in sheet.parts if part.layer != MARKS)
