"""What the page hands to machines that cut: a sheet for each colour, and what may go wrong."""

from __future__ import annotations

from io import BytesIO
from typing import Any
from zipfile import ZIP_DEFLATED, ZipFile

from warpvec.checks import check_choice
from warpvec.making.packages import check_packages

MEDIA_TYPE = "application/zip"

PEN = "pen"

MACHINES = ("vinyl", "laser", PEN, "stencil")
"""The machines of the page; all but the pen cut."""


def sheets_zip(text: str) -> bytes:
    """Return a ZIP file with an SVG in millimetres of each colour of the drawing ``text``.

    Each sheet has marks by which sheets are laid on each other, and a border along which the rest is peeled off.

    Raises:
        InputError: the text is no drawing, or a package is missing.
    """
    check_packages("sheets")
    from warpvec.making.parts import read_parts
    from warpvec.making.sheet_svg import sheet_text
    from warpvec.making.sheets import SheetOptions, sheets_of

    sheets = sheets_of(read_parts(text), SheetOptions(registration=True, weeding=True))
    stream = BytesIO()
    with ZipFile(stream, "w", ZIP_DEFLATED) as file:
        for number, (color, sheet) in enumerate(sheets.items(), 1):
            file.writestr(f"{number:02}-{color[1:]}.svg", sheet_text(sheet))
    return stream.getvalue()


def cut_facts(text: str, machine: str) -> dict[str, Any]:
    """Return the size of the drawing ``text`` in words, and what will go wrong on a machine, a sentence each.

    Args:
        text: SVG text.
        machine: one of ``MACHINES``.

    Raises:
        InputError: the text is no drawing, the machine is unknown, or a package is missing.
    """
    check_choice("machine", machine, MACHINES)
    check_packages("warnings")
    from warpvec.making.checks import MIN_WIDTH_MM, cut_warnings
    from warpvec.making.parts import read_parts
    from warpvec.making.sheets import SheetOptions

    drawing = read_parts(text)
    size = f"{drawing.width:.4g} x {drawing.height:.4g} mm"
    options = SheetOptions(keeps_lines=machine == PEN)
    return {"size": size, "warnings": cut_warnings(drawing, MIN_WIDTH_MM, options)}
