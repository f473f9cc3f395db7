"""Write gzipped SVG files."""

from __future__ import annotations

from warpvec.files import gzip_bytes
from warpvec.writers.writer import Canvas, Writer


def _encode(svg: str, canvas: Canvas | None) -> bytes:
    del canvas
    return gzip_bytes(svg.encode())


WRITER = Writer(".svgz", "image/svg+xml", _encode)
