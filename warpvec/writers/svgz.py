"""Write gzipped SVG files."""

from __future__ import annotations

from warpvec.files import gzip_bytes
from warpvec.writers.writer import Target, Writer


def _encode(svg: str, target: Target) -> bytes:
    del target
    return gzip_bytes(svg.encode())


WRITER = Writer(".svgz", "image/svg+xml", _encode)
