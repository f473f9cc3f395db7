"""Write plain SVG files."""

from __future__ import annotations

from warpvec.writers.writer import Canvas, Writer


def _encode(svg: str, canvas: Canvas | None) -> bytes:
    del canvas
    return svg.encode()


WRITER = Writer(".svg", "image/svg+xml", _encode)
