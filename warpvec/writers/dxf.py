"""Write DXF files for laser cutters, routers and plotters, in millimetres: see `warpvec.making.dxf`.

The page is not a part.
"""

from __future__ import annotations

from warpvec.writers.writer import Target, Writer, check_package


def _check(path: str, name: str) -> None:
    check_package("ezdxf", path, name)


def _encode(svg: str, target: Target) -> bytes:
    _check("drawing.dxf", "path")
    from warpvec.making.dxf import encode_sheet  # not above: it loads Torch, which the help does without
    from warpvec.making.parts import read_parts

    return encode_sheet(read_parts(svg, target.per_inch), splines=target.splines)


WRITER = Writer(".dxf", "image/vnd.dxf", _encode, _check, draws_blur=False)
