"""Make files of a drawing of the page for machines that cut, and say what may go wrong on them."""

from __future__ import annotations

from collections.abc import Callable
from io import BytesIO
from typing import TYPE_CHECKING, Any
from zipfile import ZIP_DEFLATED, ZipFile

from warpvec.checks import check_choice
from warpvec.errors import InputError
from warpvec.making.packages import check_packages

if TYPE_CHECKING:
    from warpvec.making.parts import Sheet

SHEETS, EDGES = "zip", "cut.dxf"
"""Formats for machines, which are the ends of file names too: a sheet for each colour, and each edge once."""

PEN = "pen"

MACHINES = ("vinyl", "laser", PEN, "stencil")
"""The machines of the page; all but the pen cut."""

SHEETS_MAX = 64
"""Most colours of a drawing, each of which takes a sheet, a file and some work of the server. It is what
the control of colours goes up to; each sheet is laid into the machine by hand, and nobody does that more often."""

WARNINGS_MAX = 20
"""Most warnings that the panel of the page lists: they stand above the button that saves."""


def sheets_zip(text: str) -> bytes:
    """Return a ZIP file with an SVG in millimetres of each colour of the drawing ``text``.

    Each sheet has marks by which sheets are laid on each other, and a border along which the rest is peeled off.

    Raises:
        InputError: the text is no drawing, it has too many colours, or a package is missing.
    """
    check_packages("sheets")
    from warpvec.making.sheet_svg import sheet_text
    from warpvec.making.sheets import SheetOptions, sheets_of

    sheets = sheets_of(_drawing_of(text), SheetOptions(registration=True, weeding=True))
    stream = BytesIO()
    with ZipFile(stream, "w", ZIP_DEFLATED) as file:
        for number, (color, sheet) in enumerate(sheets.items(), 1):
            file.writestr(f"{number:02}-{color[1:]}.svg", sheet_text(sheet))
    return stream.getvalue()


def edges_dxf(text: str) -> bytes:
    """Return a DXF file in millimetres of the edges of the drawing ``text``: one that two parts share is cut once.

    Raises:
        InputError: the text is no drawing, or a package is missing.
    """
    check_packages("edges for lasers")
    from warpvec.flat.cutting.edges_once import edges_once
    from warpvec.making.dxf import encode_sheet

    return encode_sheet(edges_once(text))


MACHINE_FILES: dict[str, tuple[str, Callable[[str], bytes]]] = {
    SHEETS: ("application/zip", sheets_zip),
    EDGES: ("image/vnd.dxf", edges_dxf),
}
"""Format -> the type that an answer states, and what makes the bytes of the file of a drawing."""


def cut_facts(text: str, machine: str) -> dict[str, Any]:
    """Return the size of the drawing ``text`` in words, and what will go wrong on a machine, a sentence each.

    Args:
        text: SVG text.
        machine: one of ``MACHINES``.

    Raises:
        InputError: the text is no drawing, it has too many colours, the machine is unknown, or a package is missing.
    """
    check_choice("machine", machine, MACHINES)
    check_packages("warnings")
    from warpvec.making.checks import MIN_WIDTH_MM, cut_warnings
    from warpvec.making.sheets import SheetOptions

    drawing = _drawing_of(text)
    size = f"{drawing.width:.4g} x {drawing.height:.4g} mm"
    options = SheetOptions(keeps_lines=machine == PEN)
    found = cut_warnings(drawing, MIN_WIDTH_MM, options)
    more = [f"and {len(found) - WARNINGS_MAX} more"] if len(found) > WARNINGS_MAX else []
    return {"size": size, "warnings": found[:WARNINGS_MAX] + more}


def _drawing_of(text: str) -> Sheet:
    """Return the parts of the drawing ``text``, of at most ``SHEETS_MAX`` colours."""
    from warpvec.making.parts import read_parts

    drawing = read_parts(text)
    count = len({part.color for part in drawing.parts})
    if count > SHEETS_MAX:
        rule = f"must have at most {SHEETS_MAX} colours, a sheet each"
        raise InputError("the drawing", rule, str(count), "choose fewer colours")
    return drawing
