"""Write plain SVG files."""

from __future__ import annotations

from warpvec.writers.writer import Target, Writer


def _encode(svg: str, target: Target) -> bytes:
    del target
    return svg.encode()


WRITER = Writer(".svg", "image/svg+xml", _encode)
