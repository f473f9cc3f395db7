"""Write DXF files for laser cutters, routers and plotters, in millimetres: see `warpvec.making.dxf`.

The page is not a part. A stroke is both its edges, which is what a cutter needs, or its centre line, for a pen.
"""

from __future__ import annotations

import re
from dataclasses import replace

from warpvec.making.packages import PACKAGES
from warpvec.writers.writer import Target, Writer, check_package

_LINES = re.compile(r'<metadata>[^<]*"mode": "lines"')
"""What the SVG of a drawing states that was made of lines for a pen."""


def _check(path: str, name: str) -> None:
    for package in PACKAGES:
        check_package(package, path, name)


def _encode(svg: str, target: Target) -> bytes:
    _check("drawing.dxf", "path")
    from warpvec.making.dxf import encode_sheet  # not above: it loads Torch, which the help does without
    from warpvec.making.parts import read_parts
    from warpvec.making.regions import stroke_edges

    sheet = read_parts(svg, target.per_inch)
    is_for_pen = _LINES.search(svg) is not None if target.center_lines is None else target.center_lines
    if not is_for_pen:
        sheet = replace(sheet, parts=tuple(map(stroke_edges, sheet.parts)))
    return encode_sheet(sheet, splines=target.splines)


WRITER = Writer(".dxf", "image/vnd.dxf", _encode, _check, draws_blur=False)
