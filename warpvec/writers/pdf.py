"""Write PDF files, for print shops, cutters and typesetting."""

from __future__ import annotations

from warpvec.writers import cairo
from warpvec.writers.writer import Canvas, Writer


def _encode(svg: str, canvas: Canvas | None) -> bytes:
    del canvas
    data: bytes = cairo.load("drawing.pdf", "path").svg2pdf(bytestring=svg.encode())
    return data


WRITER = Writer(".pdf", "application/pdf", _encode, cairo.check)
