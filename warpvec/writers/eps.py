"""Write EPS files. EPS has no opacity: cairo draws the parts of a page below translucent paths as pixels."""

from __future__ import annotations

from warpvec.writers import cairo
from warpvec.writers.writer import Canvas, Writer


def _encode(svg: str, canvas: Canvas | None) -> bytes:
    del canvas
    data: bytes = cairo.load("drawing.eps", "path").svg2eps(bytestring=svg.encode())
    return data


WRITER = Writer(".eps", "application/postscript", _encode, cairo.check)
